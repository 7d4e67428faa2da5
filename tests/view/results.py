"""One of every class that shows itself, made once for all tests."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

import rodgen
from rodgen.scene import Scene

# A clamped rod that sways: every analysis has something to say of it.
TABLE: dict[str, Any] = {
    "name": "swaying",
    "rod": {
        "links": 3,
        "length": 2.0,
        "bending_stiffness": 30.0,
        "mass": 3.0,
        "boundary": "clamped",
    },
    "loads": {"follower": {"force": 4.0}, "gravity": {}},
    "initial": {"phi": 0.1},
    "events": [{"quantity": "phi_2", "value": 0.0}],
    "integrate": {"span": [0.0, 0.5], "output_every": 0.05},
}
SCENE = Scene.from_dict(TABLE)

REFERENCE = {"method": "dop853", "order": 8, "checked_by": "radau, rtol 1e-12"}


def _ensemble() -> rodgen.Ensemble:
    model = rodgen.build(SCENE)
    p, y = model.parameters(**SCENE.parameters), SCENE.initial_state()
    return rodgen.simulate_many(model, p, y, keep="max(phi_2)", span=(0.0, 0.1))


def _cycle() -> rodgen.Cycle:
    y, mu = SCENE.initial_state(), np.full(6, 0.5 + 0j)
    numbers = (0.0, 0.2, y, mu, 0, 0.0, 0.0, 0.5, 0.1, False, 1e-12, 4)
    return rodgen.Cycle(rodgen.System(SCENE), *numbers, "collocation")


def _setting(error: float) -> dict[str, Any]:
    """A setting of a method that took the longer, the less its error."""
    named = {"who": "rodgen", "method": "rk4", "target": "c", "kind": "step", "failed": ""}
    return named | {"setting": error**0.25, "seconds": 1e-8 / error, "error_phi": error}


MAKERS: dict[str, Callable[[], Any]] = {
    "Scene": lambda: SCENE,
    "Solution": lambda: rodgen.simulate(SCENE, target="numpy"),
    "Description": lambda: rodgen.describe(SCENE),
    "Modes": lambda: rodgen.natural_modes(SCENE),
    "LinearModel": lambda: rodgen.linearise(SCENE, ["loads.follower.force"], ["phi(1)"]),
    "Equilibrium": lambda: rodgen.static_equilibrium(SCENE),
    "Critical": lambda: rodgen.critical_load(SCENE),
    "Cycle": _cycle,
    "Exponents": lambda: rodgen.lyapunov_exponents(SCENE, count=2),
    "Floquet": lambda: rodgen.Floquet(
        np.array([0.5 + 0j]), 0.2, np.zeros(6), 0.0, 1e-9, 1e-12, (0,)
    ),
    "Spectrum": lambda: rodgen.spectrum(
        rodgen.simulate(SCENE, target="numpy", span=(0.0, 4.0), output_every=0.005), peaks=1
    ),
    "Extrapolation": lambda: rodgen.richardson([4, 8, 16], [1 + 1 / n**2 for n in (4, 8, 16)]),
    "SimulatedCritical": lambda: rodgen.SimulatedCritical(2.5, 2.0, 3.0, 10.0, None, 7, 0.1, "c"),
    "WorkPrecision": lambda: rodgen.WorkPrecision(
        SCENE, [_setting(1e-6), _setting(1e-8)], REFERENCE, {"error_phi": 1e-9}, {}
    ),
    "Study": lambda: rodgen.Study.of(SCENE, {"loads.follower.force": [1.0, 2.5]}, analysis="modes"),
    "Ensemble": _ensemble,
}


@cache
def made(name: str) -> Any:
    """One of the class of this name."""
    return MAKERS[name]()
