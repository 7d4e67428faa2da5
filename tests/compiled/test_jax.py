"""rodgen.jax: values, Jacobians, batches, and gradients through diffrax against 50 digits."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mpf

import rodgen
from rodgen.check.reference_equations import ReferenceEquations
from rodgen.scene import Scene
from tests.told import refused

jax = pytest.importorskip("jax", reason="the extra jax is not installed")
import jax.numpy as jnp  # noqa: E402  where JAX is installed

import rodgen.jax as of_jax  # noqa: E402  where JAX is installed

SCENE = Scene.from_dict(
    {
        "name": "bent",
        "rod": {
            "links": 2,
            "length": 1.3,
            "bending_stiffness": 7.0,
            "mass": 2.0,
            "boundary": "clamped",
        },
        "loads": {
            "follower": {"force": 3.0, "angle": 0.1},
            "gravity": {},
            "material_damping": {"time": 0.02},
        },
        "initial": {"phi": "0.4*s", "omega": "s"},
    }
)


@pytest.fixture(autouse=True)
def doubles() -> Any:
    jax.config.update("jax_enable_x64", True)


@pytest.fixture(scope="module")
def model() -> Any:
    return rodgen.build(SCENE, "c")


def values(model: Any, scene: Scene = SCENE) -> tuple[Any, Any]:
    return scene.initial_state(), model.parameters(**scene.parameters)


def test_rates_and_jacobians_are_those_of_the_module(model: Any) -> None:
    """The same functions are called, so that all is equal to the bit."""
    f, (y, p) = of_jax.rhs(model), values(model)
    for made in (f, jax.jit(f)):
        assert np.array_equal(made(0.3, y, p), model.rhs(0.3, y, p))
    for jacobian in (jax.jacfwd(f, 1), jax.jacrev(f, 1), jax.jit(jax.jacrev(f, 1))):
        assert np.array_equal(jacobian(0.3, y, p), model.jac(0.3, y, p))


def test_maps_over_any_axes(model: Any) -> None:
    """Over states alone and with parameters, which rhs_batch takes at once, and over all three in
    turn, which go row by row."""
    f, (y, p) = of_jax.rhs(model), values(model)
    Y, P, T = y + 0.1 * np.arange(5)[:, None], p * (1 + 0.1 * np.arange(5)[:, None]), np.arange(3.0)
    one = model.rhs_batch(0.3, Y, p)
    assert np.array_equal(jax.vmap(f, (None, 0, None))(0.3, Y, p), one)
    assert np.array_equal(jax.vmap(f, (None, 0, 0))(0.3, Y, P), model.rhs_batch(0.3, Y, P))
    every = jax.vmap(jax.vmap(jax.vmap(f, (None, 0, None)), (None, None, 0)), (0, None, None))
    rows = [[[model.rhs(t, a, b) for a in Y] for b in P[:2]] for t in T]
    assert np.allclose(every(T, Y, P[:2]), rows, rtol=1e-13, atol=0)  # fused otherwise in batches
    jacobians = jax.vmap(jax.jacrev(f, 1), (None, 0, None))(0.3, Y, p)
    assert np.array_equal(jacobians, [model.jac(0.3, a, p) for a in Y])


def test_derivatives_by_time_and_parameters() -> None:
    """Of a force that is a function of time, whose derivatives are known: the rates are linear in
    the force."""
    scene = SCENE.replace(
        {"loads.follower.force": "a*sin(w*t)", "parameters": {"a": 3.0, "w": 5.0}}
    )
    model = rodgen.build(scene, "c")
    f, (y, p) = of_jax.rhs(model), values(model, scene)
    t, places = 0.3, scene.structure.indices
    none = p.copy()
    none[places["a"]] = 0.0
    unit = (f(t, y, p) - f(t, y, none)) / (3.0 * np.sin(5.0 * t))  # rates of a force of 1 N
    due = {
        "t": 15.0 * np.cos(5.0 * t) * unit,
        "a": np.sin(5.0 * t) * unit,
        "w": 3.0 * t * np.cos(5.0 * t) * unit,
    }
    by_p = jax.jacrev(f, 2)(t, y, p)
    found = {"t": jax.jacfwd(f, 0)(t, y, p), **{n: by_p[:, places[n]] for n in ("a", "w")}}
    for name, column in due.items():  # rounding over the step of 1e-4
        assert np.allclose(found[name], column, rtol=0, atol=1e-11 * np.abs(f(t, y, p)).max()), name


def test_gradients_through_diffrax_against_50_digits(model: Any) -> None:
    """A run of twelve steps, differentiated in reverse by diffrax; the same steps in 50 digits on
    the hand-assembled equations, differenced over 1e-20."""
    diffrax = pytest.importorskip("diffrax", reason="diffrax is not installed")
    f, (y, p) = of_jax.rhs(model), values(model)
    steps, end = 12, 0.25
    weights = np.array([1.0, -2.0, 0.3, 0.1])

    def told(y: Any, p: Any) -> Any:
        made = diffrax.diffeqsolve(
            diffrax.ODETerm(f), diffrax.Euler(), 0.0, end, end / steps, y, args=p,
            stepsize_controller=diffrax.ConstantStepSize(), saveat=diffrax.SaveAt(t1=True),
        )  # fmt: skip
        return jnp.asarray(weights) @ made.ys[-1]

    by_y, by_p = jax.jit(jax.grad(told, (0, 1)))(y, p)

    def exactly(numbers: list[Any]) -> Any:
        state, h = np.array(numbers[: len(y)], dtype=object), mpf(end) / steps
        given = dict(zip(SCENE.structure.parameters, numbers[len(y) :], strict=True))
        for _ in range(steps):
            state = state + h * np.array(
                ReferenceEquations(model, given, state).rhs(), dtype=object
            )
        return sum(mpf(float(w)) * one for w, one in zip(weights, state, strict=True))

    start = [*y, *p]
    with mpmath.workdps(50):
        small, due = mpf(10) ** -20, []
        for at in range(len(start)):
            both = []
            for sign in (1, -1):
                moved = [mpf(float(one)) for one in start]
                moved[at] += sign * small
                both.append(exactly(moved))
            due.append(float((both[0] - both[1]) / (2 * small)))
    found = np.concatenate((by_y, by_p))
    assert np.abs(np.array(due)).min() > 1e-3  # every number counts
    assert np.allclose(found, due, rtol=1e-8, atol=0)
    assert np.allclose(by_y, due[: len(y)], rtol=1e-12, atol=0)  # by the exact Jacobian


def test_what_jax_cannot_do_is_refused(model: Any) -> None:
    f, (y, p) = of_jax.rhs(model), values(model)
    assert refused(f, 0.0, y[:3], p)[:2] == ("y", (3,))
    for wrong in (y + 1j, ["three"], None, SCENE.parameters):
        assert refused(f, 0.0, wrong, p).field == "y"
    for other in (rodgen.build(SCENE.replace({"loads.gravity": None})), np):
        assert refused(of_jax.rhs, other).allowed
    with pytest.raises(TypeError, match=r"str$"):
        of_jax.rhs("beck.toml")
    assert np.array_equal(of_jax.rhs(SCENE)(0.0, y, p), f(0.0, y, p))  # of its C module
    jax.config.update("jax_enable_x64", False)
    assert refused(f, 0.0, y, p).field
    jax.config.update("jax_enable_x64", True)
    call = jax.ffi.ffi_call("rodgen_jax_rhs", jax.ShapeDtypeStruct(y.shape, np.float64))
    with pytest.raises(jax.errors.JaxRuntimeError):  # as a program from another process
        jax.block_until_ready(call(jnp.float64(0.0), y, p, model=np.int64(7)))
    with pytest.raises(ValueError):  # noqa: PT011  in JAX's own words
        jax.jacfwd(jax.jacrev(f, 1), 1)(0.0, y, p)
