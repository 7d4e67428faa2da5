"""Rods for analyses, and their small motions by two other routes: the Jacobian of the module, and
differences of the hand-assembled closed form in 50-digit arithmetic."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import mpmath as mp
import numpy as np

import rodgen
from rodgen.analyse.cycles.cycle_search import CycleSearch
from rodgen.analyse.cycles.hopf import first_hopf
from rodgen.analyse.cycles.periodic_motion import find_cycle
from rodgen.check.reference_equations import ReferenceEquations
from rodgen.scene import Scene
from rodgen.system import ParameterRange, System

STIFFNESS, LENGTH, MASS = 100.0, 5.0, 50.0
SIZES = {"length": LENGTH, "bending_stiffness": STIFFNESS, "mass": MASS}
ONES = {"length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}
THRUST: dict[str, Any] = {"follower": {"force": 50.0}}
FORCE, AXIAL = "loads.follower.force", "loads.tip.x"
# Ziegler's double pendulum with damping, beyond its flutter.
ZIEGLER = Scene.from_dict(
    {
        "name": "ziegler",
        "rod": ONES | {"links": 3, "boundary": "cantilever", "inertia": "lumped"},
        "loads": {"follower": {"force": 16.0}, "internal_damping": {"coefficient": 0.3}},
        "initial": {"phi": [0.2, 0.1]},
        "integrate": {"span": [0.0, 12.0], "rtol": 1e-8, "atol": 1e-10},
    }
)
# Loads of no size change nothing: with them it is a structure that other tests compile as well.
NOTHING = {"gravity": {"g": 0.0}, "external_damping": {"coefficient": 0.0}}
NOTHING |= {"tip": {"x": 0.0, "y": 0.0}}
COLUMN = Scene.from_dict(
    {
        "name": "column",
        "rod": ONES | {"links": 3, "boundary": "clamped"},
        "loads": NOTHING | {"follower": {"force": 20.0}, "internal_damping": {"coefficient": 0.3}},
        "initial": {"phi": "0.2*s"},
        "integrate": {"span": [0.0, 20.0]},
    }
)
DIGITS = 50
NUDGE = 2.0**-60  # central differences: errors of 1e-36 and of 1e-32
TABLES = {"initial", "integrate", "parameters", "states", "supports", "foundation", "bodies"}


def rod(links: int, boundary: str, loads: dict[str, Any] | None = None, /, **keys: Any) -> Scene:
    """A scene of the rod of SIZES; keys: of [rod], or tables beside it."""
    own = {"links": links, "boundary": boundary}
    tables = {key: keys.pop(key) for key in TABLES & keys.keys()}
    table = {"name": "rod", "rod": SIZES | own | keys, "loads": loads or {}}
    return Scene.from_dict(table | tables)


def jacobian(scene: Scene, y: Any = None, **parameters: float) -> Any:
    """Derivatives of the rates by a state, that at the start if none is given."""
    model = rodgen.build(scene, "numpy")
    y = scene.initial_state() if y is None else y
    return model.jac(0.0, y, model.parameters(**scene.parameters | parameters))


def eigenvalues(scene: Scene, y: Any = None, **parameters: float) -> Any:
    """Rates [1/s] of all small motions about a state, by the Jacobian of the module."""
    return np.linalg.eigvals(jacobian(scene, y, **parameters))


def are_among(modes: Any, s: Any, within: float = 1e-6) -> None:
    """Every mode that was found is one of these eigenvalues."""
    for rate in modes.growth + 2j * np.pi * modes.frequencies:
        assert np.abs(s - rate).min() < within * max(1.0, abs(rate)), rate


def exact_rates(scene: Scene) -> list[Any]:
    """Eigenvalues s [1/s] of the small motions about the initial state of a scene, of a straight
    rod at rest, but for the zeros of rigid motions."""
    rod, y = scene.rod, scene.initial_state()
    module: Any = SimpleNamespace(
        N=rod.links, BOUNDARY=rod.boundary, INERTIA=rod.inertia, TERMS=scene.structure.terms
    )
    with mp.workdps(DIGITS):
        J = mp.matrix(len(y))
        for j, step in enumerate(NUDGE * np.eye(len(y))):
            up, down = (
                ReferenceEquations(module, scene.parameters, y + d).rhs() for d in (step, -step)
            )
            for i, (a, b) in enumerate(zip(up, down, strict=True)):
                J[i, j] = (a - b) / (2 * mp.mpf(NUDGE))
        return [s for s in mp.eig(J, left=False, right=False) if abs(s) > 1e-12]


def beside_hopf(scene: Scene, ends: tuple[float, float]) -> tuple[Any, list[float]]:
    """The Hopf point of a thrust between these; and of two cycles beside it, one of half the
    amplitude of the other, how far their periods are from those of the normal form."""
    search = CycleSearch.of(System(scene))
    hopf, flow = first_hopf(search, ParameterRange(search.system, FORCE, ends))
    errors = []
    for amplitude in (0.06, 0.03):
        x, value, period = hopf.cycle_guess(amplitude)
        y0 = flow(value).quotient.lift(x)
        found = find_cycle(scene.replace({FORCE: value}), y0=y0, period=period)
        errors.append(abs(found.period - period))
    return hopf, errors
