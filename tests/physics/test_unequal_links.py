"""Rods whose links differ in length, held against equal links, hand-written programs and exact
values; ends that bend before a body."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import rodgen
from rodgen import Scene
from rodgen.check.module_check import check_module
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.loading import build
from rodgen.scene.structure import Structure

ROD: dict[str, Any] = {"length": 1.0, "mass": 1.0, "bending_stiffness": 1.0, "boundary": "clamped"}
SQUARES = "(i/n)**2"
# Clustered at the start, at both ends, and as far from equal as smooth meshes are wanted.
MESHES = (SQUARES, "sin(pi/2*i/n)**2")
UNEQUAL = ("stiffness", "mass", "lengths")


def _scene(links: int, joints: Any = None, **tables: Any) -> Scene:
    rod = ROD | {"links": links} | tables.pop("rod", {}) | ({"joints": joints} if joints else {})
    return Scene.from_dict({"name": "rod", "rod": rod} | tables)


def _extrapolate(values: np.ndarray) -> Any:
    """Limit of values for n, 2n, 4n, ... links, whose errors are of even powers of 1/n."""
    for order in range(1, len(values)):
        power = 4**order
        values = (power * values[1:] - values[:-1]) / (power - 1)
    return values[0]


def _extrapolated(of: Callable[[int], Any], coarsest: int) -> Any:
    return _extrapolate(np.array([of(coarsest * 2**k) for k in range(3)]))


def test_two_links_are_a_double_pendulum() -> None:
    """Uniform rods of 0.3 and 0.7 m, from the horizontal, against Lagrange's equations by hand and
    another integrator. Errors grow fifty-fold in 5 s."""
    (l, k), (m, h), g = (0.3, 0.7), (0.3, 0.7), 9.81

    def rates(_: float, y: np.ndarray) -> list[float]:
        a, b, u, w = y
        mixed, turning = (h * l * k / 2 * of(a - b) for of in (np.cos, np.sin))
        mass = [[m * l**2 / 3 + h * l**2, mixed], [mixed, h * k**2 / 3]]
        first = -turning * w**2 - (m / 2 + h) * g * l * np.cos(a)
        second = turning * u**2 - h / 2 * g * k * np.cos(b)
        return [u, w, *np.linalg.solve(mass, [first, second])]

    rod = {"boundary": "pinned", "bending_stiffness": 0.0}
    settings = {"span": [0.0, 5.0], "rtol": 1e-13, "atol": 1e-13, "output_every": 0.5}
    loads = {"gravity": {"g": g}}
    scene = _scene(2, [0.0, 0.3, 1.0], rod=rod, loads=loads, integrate=settings)
    found = rodgen.simulate(scene)
    due = solve_ivp(
        rates, (0, 5), np.zeros(4), method="DOP853", rtol=2.3e-14, atol=1e-14, t_eval=found.t
    )
    np.testing.assert_allclose(found.y, due.y.T, rtol=0, atol=1e-9)
    assert found.energy_error < 1e-11


def test_frequencies_converge_to_those_of_the_continuous_rod() -> None:
    """Clamped, joints at (i/n)^2, first two roots of 1 + cos b cosh b: of second order in 1/n."""
    roots = (brentq(lambda b: np.cos(b) * np.cosh(b) + 1, *ab) for ab in ((1.5, 2.2), (4.5, 5.0)))
    exact = np.array([b**2 / (2 * np.pi) for b in roots])
    few = [20, 40, 80]
    found = np.array([rodgen.natural_modes(_scene(n, SQUARES), 2).frequencies for n in few])
    errors = np.abs(found[:, 0] / exact[0] - 1)
    orders = [np.log2(a / b) for a, b in pairwise(errors)]
    np.testing.assert_allclose(orders, 2.0, atol=0.01)
    np.testing.assert_allclose(_extrapolate(found)[0], exact[0], rtol=1e-8)
    np.testing.assert_allclose(_extrapolate(found)[1], exact[1], rtol=1e-6)


@pytest.mark.parametrize("joints", MESHES)
def test_limits_do_not_depend_on_the_mesh(joints: str) -> None:
    """Beck's column, and a column that gravity and a dead force bend far."""
    beck = {"follower": {"force": 1.0}}
    bent = {"gravity": {"g": 1.0}, "tip": {"y": -1.0}}
    force = _extrapolated(lambda n: rodgen.critical_load(_scene(n, joints, loads=beck)).value, 20)
    assert force == pytest.approx(20.05095, rel=1e-6)  # of the continuous column
    tips = [
        _extrapolated(lambda n, of=of: rodgen.static_equilibrium(_scene(n, of, loads=bent)).tip, 20)
        for of in (joints, None)
    ]
    np.testing.assert_allclose(*tips, rtol=0, atol=1e-8)


def test_a_rod_on_springs_is_well_conditioned() -> None:
    """Links that differ a hundred-fold: small motions about a bent equilibrium, damped, of a free
    rod that springs hold, as with links that are nearly alike."""
    tables: dict[str, Any] = {
        "foundation": {"stiffness": "100*(1 + s)", "damping": 0.1},
        "supports": [{"at": 0.25, "stiffness": [50.0, 20.0], "rotation": 0.5}],
        "loads": {
            "material_damping": {"time": 0.01},
            "viscous_drag": {"normal": 0.5, "tangential": 0.1},
            "tip": {"y": -1.0},
        },
        "rod": {"boundary": "free"},
    }
    one, other = (
        rodgen.natural_modes(_scene(n, joints, **tables), 3)
        for n, joints in ((160, None), (80, SQUARES))
    )
    np.testing.assert_allclose(other.frequencies, one.frequencies, rtol=1e-3)
    np.testing.assert_allclose(other.growth, one.growth, rtol=1e-2)


EXPRESSIONS = (
    ("distributed_follower", "c*(1 + s)*(1 + t)"),
    ("tip_force_x", "phi(0.3)*a + x(0.55) + vy(1)"),
)
MASSES = (("", -1, "a*(2 + s*sin(t))"), ("tank", 2, "b*(3 - t)"))
PLACES = (("0.3", "1+1/4"), ("0.55", "2"), ("1.0", ""))


@pytest.mark.parametrize("target", ["numpy", pytest.param("c", marks=pytest.mark.compiler)])
def test_what_lies_along_links_equals_fifty_digit_arithmetic(target: str) -> None:
    """Loads and masses in s and t at Gauss points, sensors by their places on the links."""
    for ways, masses in ((UNEQUAL, MASSES[:1]), (("stiffness", "bodies", "lengths"), MASSES)):
        terms = ("tip_load", "distributed_follower", "gravity")
        more = {"masses": masses, "sensor_places": PLACES}
        module = build(Structure(4, "free", "uniform", terms, EXPRESSIONS, ways, **more), target)
        assert check_module(module, states=1).largest < 1e-12


@pytest.mark.compiler
def test_an_explicit_and_an_implicit_method_agree() -> None:
    """From rest, where the law of drag has a kink; with a sensor and a force inside a link."""
    loads = {
        "gravity": {"g": 9.81},
        "drag": {"normal": 0.8, "tangential": 0.1},
        "follower": [{"force": "phi(0.4) + 1", "at": 0.37}],
    }
    joints, initial = [0.0, 0.1, 0.3, 0.6, 0.85, 1.0], {"phi": "0.5*s"}
    scene = _scene(5, joints, rod={"boundary": "free"}, loads=loads, initial=initial)
    settings = {"span": [0.0, 0.5], "rtol": 1e-11, "atol": 1e-11}
    runs = [
        rodgen.simulate(scene.with_integrate(**settings, method=of), target="c")
        for of in ("dop853", "radau")
    ]
    np.testing.assert_allclose(runs[1].y[-1], runs[0].y[-1], rtol=0, atol=1e-8)
    assert all(one.energy_error < 1e-9 for one in runs)


def test_a_rod_with_equal_joints_has_the_module_of_equal_links() -> None:
    for joints in ("i/n", [0.0, 0.25, 0.5, 0.75, 1.0]):
        assert _scene(4, joints).structure == _scene(4).structure


# Bodies at the ends -------------------------------------------------------------------------------


def _tipped(n: int, at: float = 1.0, joints: Any = None, **rod: Any) -> Scene:
    tip = {"name": "tip", "at": at, "mass": 0.3, "inertia": 0.1}
    return _scene(n, joints, bodies=[tip], rod=rod)


@pytest.mark.parametrize("joints", [None, SQUARES])
def test_an_end_bends_before_a_body_that_resists_turning(joints: Any) -> None:
    """Cantilever with a tip mass and its inertia: order 2, to the root of the determinant of moment
    and shear at the tail of the continuous rod. Beside h^2, errors have h^3, of the end."""
    mu, beta = 0.3, 0.1

    def determinant(b: float) -> float:
        """Moment and shear at the tail of the shapes that the clamp allows."""
        c, s, C, S = np.cos(b), np.sin(b), np.cosh(b), np.sinh(b)
        w, slope = np.array([c - C, s - S]), np.array([-s - S, c - C])
        moment, shear = np.array([-c - C, -s - S]), np.array([s - S, -c - C])
        rows = [moment - beta * b**3 * slope, shear + mu * b * w]
        return float(np.linalg.det(rows))

    exact, h = brentq(determinant, 0.9, 1.5) ** 2 / (2 * np.pi), 1 / np.array([20, 40, 80])
    found = np.array(
        [rodgen.natural_modes(_tipped(round(1 / n), joints=joints), 1).frequencies[0] for n in h]
    )
    orders = [np.log2(a / b) for a, b in pairwise(np.abs(found / exact - 1))]
    np.testing.assert_allclose(orders, 2.0, atol=0.1)
    limit = np.linalg.solve(np.stack((h**0, h**2, h**3), axis=1), found)[0]
    assert limit == pytest.approx(exact, rel=1e-6)


def test_both_ends_of_a_free_rod_are_alike() -> None:
    """Nose and tail, seen from the other side: one frequency."""
    one, other = (
        rodgen.natural_modes(_tipped(9, at, boundary="free"), 2).frequencies for at in (0.0, 1.0)
    )
    np.testing.assert_allclose(one, other, rtol=1e-12)


@pytest.mark.parametrize("stiffness", [3.0, [3.0] * 6, "3 + 0*s"])
def test_stiffness_of_the_joint_before_a_body(stiffness: Any) -> None:
    """Whole last link and half the one before: 2/3 of k; up to a body at s = 0.96, a share of 0.8
    of that link, 1/(1/2 + 0.8) of k. Curvature is moment over stiffness there too."""
    for at, part in ((1.0, 2 / 3), (0.96, 1 / 1.3), (0.9, 1.0)):
        along = _tipped(5, at, bending_stiffness=stiffness).distribution
        np.testing.assert_allclose(along.joint_stiffness, [30.0, *[15.0] * 3, 15.0 * part])
        bent = along.joint_parameters.get("bent_length", [0.1, *[0.2] * 4])
        np.testing.assert_allclose(np.multiply(bent, along.joint_stiffness), 3.0)


def test_a_point_mass_leaves_the_ends_as_they_are() -> None:
    tip = {"name": "tip", "at": 1.0, "mass": 0.3}
    for body, kinds in (
        (tip, ("bodies",)),
        (tip | {"offset": [0.1, 0.0]}, ("stiffness", "bodies", "ends")),
    ):
        assert _scene(5, bodies=[body]).structure.nonuniform == kinds


@pytest.mark.slow
def test_onset_of_the_column_with_a_tip_mass() -> None:
    """To 160 links; 33.7714 is that of the continuous column in eight shapes (docs/tip-mass.md)."""
    column = Scene.example("tip_mass")
    found = [rodgen.critical_load(column.with_links(n)).value for n in (20, 40, 80, 160)]
    assert _extrapolate(np.array(found[1:])) == pytest.approx(33.7714, rel=1e-5)


@pytest.mark.parametrize("boundary", ["clamped", "cantilever"])
@pytest.mark.parametrize("joints", [None, SQUARES])
def test_a_support_holds_the_point_that_a_rod_with_a_bent_end_has_at_rest(
    joints: str | None, boundary: str
) -> None:
    scene = _scene(
        4,
        joints,
        rod={"rest_curvature": 1.0, "boundary": boundary},
        bodies=[{"name": "wheel", "at": 1.0, "mass": 0.3, "inertia": 0.1}],
        supports=[{"at": 1.0, "stiffness": [100.0, 100.0]}],
        initial={"phi": "rest"},
    )
    system = rodgen.System(scene)
    rates = build(scene, target="numpy").rhs(0.0, system.y0, system.p)
    np.testing.assert_allclose(rates, 0.0, atol=1e-10)  # 100 N/m beside 1e-12 of a metre


def test_shear_force_is_that_of_the_drag_on_the_rod_behind() -> None:
    """At rest in a steady wind across it, at a joint with links of 0.2 and 0.8 m."""
    scene = _scene(
        2,
        [0.0, 0.2, 1.0],
        rod={"bending_stiffness": 1e7},
        loads={"viscous_drag": {"normal": 1.0, "wind": [0.0, 1.0]}},
    )
    model, y = build(scene, "numpy"), scene.initial_state()
    y[:2] = rodgen.static_equilibrium(scene).phi
    piece = MotionSlice(model, model.parameters(**scene.parameters), y, np.array(0.0))
    # Bent by 1e-7 only.
    np.testing.assert_allclose(piece.values("shear_force"), [1.0, 0.8], rtol=1e-6)
