"""Rods that nothing keeps straight: chains between stiff supports, and pinned rods that loads turn
about their pivot."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import fsolve

import rodgen
from rodgen.analyse.statics import static_equilibrium
from rodgen.scene import Scene
from tests.sets import sets

ROD = {"links": 10, "length": 1.0, "mass": 1.0, "bending_stiffness": 0.0, "boundary": "pinned"}
G = 9.81


def chain(supports: list[tuple[float, float, tuple[float, float]]], **rod: Any) -> Scene:
    """A chain under gravity, held at each s by a stiffness [N/m] that pulls to a point [m]."""
    held = [{"at": at, "stiffness": [k, k], "to": list(to)} for at, k, to in supports]
    table = {"name": "chain", "rod": ROD | rod, "loads": {"gravity": {"g": G}}, "supports": held}
    return Scene.from_dict(table | {"integrate": {"span": [0.0, 1.0]}})


def _hangs(pull: Any, n: int, k: float, to: tuple[float, float]) -> list[float]:
    """How far the end of a chain that pulls its first joint so (2,) [N] is from where its spring
    would hold it [m]: every link lies along the mean of the pulls at its ends."""
    weight = np.array([0.0, G])
    pulls = np.asarray(pull) + np.outer((np.arange(n) + 0.5) / n, weight)
    end = (pulls / np.linalg.norm(pulls, axis=1)[:, None]).sum(axis=0) / n
    return list(end - to + (pull + weight) / k)


@pytest.mark.parametrize(
    ("n", "k", "to"),
    sets(
        [(10, 1e9, (0.8, 0.0))],
        slow=[(10, 1e3, (0.3, -0.4)), (10, 1e12, (-0.6, 0.7)), (100, 1e9, (0.8, 0.0))],
        nightly=[(20, 1e9, (0.8, 0.0)), (50, 1e6, (-0.1, -0.5))],
    ),
)
def test_a_chain_between_two_points(n: int, k: float, to: tuple[float, float]) -> None:
    rest = static_equilibrium(chain([(1.0, k, to)], links=n))
    pull = rest.force[0] / n  # over the mass of a link
    exact = fsolve(_hangs, pull, (n, k, to), xtol=1e-13)
    np.testing.assert_allclose(pull, exact, rtol=0, atol=1e-9 * np.linalg.norm(exact))
    assert rest.stable
    # A residual of some roundings of the stiffness times the length, over the mass of a link.
    model = rodgen.build(rest.scene, "numpy")
    rates = model.rhs(0.0, rest.y, model.parameters(**rest.scene.parameters))
    assert np.abs(rates).max() < 64 * np.finfo(float).eps * (k + G) * n**2


def test_a_chain_that_hangs_deep_begins_as_a_catenary() -> None:
    """As it is one, a few corrections find it; from arcs they are three times as many."""
    rest = static_equilibrium(chain([(1.0, 1e9, (0.3, 0.0))]))
    assert rest.stable
    assert rest.iterations <= 8


@pytest.mark.parametrize(
    "supports",
    sets(
        [
            [(0.4, 1e8, (0.3, 0.1)), (1.0, 1e8, (0.6, -0.2))],
            [(0.5, 1e4, (0.0, -0.3)), (1.0, 1e4, (0.0, 0.0))],  # a loop that hangs from itself
            [(1.0, 1e6, (0.9, 0.6))],  # stretched
            [(0.3, 4e9, (-0.0358, -0.951))],  # stretched by far, and a tail that hangs from there
            [(1.0, 2.0, (0.8, 0.0))],  # too soft to hold it
        ],
        slow=[
            [(0.25, 1e10, (0.2, 0.0)), (0.75, 1e10, (0.5, 0.0)), (1.0, 1e10, (0.6, 0.1))],
            [(0.3, 10.0, (-0.2, 0.5)), (1.0, 1e5, (0.5, 0.5))],
        ],
    ),
)
@pytest.mark.parametrize("boundary", sets(["pinned"], slow=["free"]))
def test_chains_from_several_points_come_to_a_stable_rest(
    boundary: str, supports: list[Any]
) -> None:
    first = [(0.0, supports[0][1], (0.0, 0.0))] if boundary == "free" else []
    rest = static_equilibrium(chain([*first, *supports], boundary=boundary))
    assert rest.stable
    model = rodgen.build(rest.scene, "numpy")
    rates = model.rhs(0.0, rest.y, model.parameters(**rest.scene.parameters))
    # Roundings of the largest force over the mass of a link and its length.
    force = np.abs(rest.force).max() + G + max(k for _, k, _ in supports)
    assert np.abs(rates).max() < 1e3 * np.finfo(float).eps * force * 100


@pytest.mark.parametrize("n", sets([3], slow=[12], nightly=[24]))
def test_a_pinned_rod_hangs_before_loads_that_turn_with_it_grow(n: int) -> None:
    """Against small steps of the load, each by a solver of its own from the one before."""
    load, angle, stiffness = 6.0, np.pi / 2, 0.1 * n
    followers = [{"force": load / n, "at": (i + 1) / n, "angle": angle} for i in range(n)]
    table = {
        "name": "turned",
        "rod": ROD | {"links": n, "bending_stiffness": 0.1},
        "loads": {"gravity": {"g": G}, "follower": followers},
        "integrate": {"span": [0.0, 1.0]},
    }
    rest = static_equilibrium(Scene.from_dict(table))
    phi = np.full(n, -np.pi / 2)

    def moments(phi: Any, share: float) -> list[float]:
        """About every joint, of all that is behind it and of its spring: the thrust pushes towards
        the nose, turned by its angle."""
        tips = np.cumsum(np.stack((np.cos(phi), np.sin(phi)), axis=1), axis=0) / n
        starts = np.vstack((np.zeros(2), tips[:-1]))
        middles = (starts + tips) / 2
        # At a joint it belongs to the link that begins there, at the tail to the last.
        owner = np.minimum(np.arange(1, n + 1), n - 1)
        turned = phi[owner] + np.pi + angle
        push = share * load / n * np.stack((np.cos(turned), np.sin(turned)), axis=1)
        out = []
        for j in range(n):
            arms, pushed = middles[j:] - starts[j], tips[j:] - starts[j]
            # That at the start of link j has no arm about it.
            moment = -(arms[:, 0] * G / n).sum()
            moment += (pushed[:, 0] * push[j:, 1] - pushed[:, 1] * push[j:, 0]).sum()
            moment -= stiffness * (phi[j] - phi[j - 1]) if j else 0.0
            out.append(float(moment))
        return out

    for share in np.linspace(0.0, 1.0, 41)[1:]:
        phi = fsolve(moments, phi, (share,), xtol=1e-12)
    np.testing.assert_allclose(rest.phi, phi, atol=1e-9)
