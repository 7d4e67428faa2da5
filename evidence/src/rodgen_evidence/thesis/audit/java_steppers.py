"""The true orders of the listing's steppers, measured: the literal steppers in floats, on a rod of
three links, against DOP853 with the equations that are derived.

The error at the end of a span is a power of the step; the power is fitted over several steps.
Section 1.4 of the text names the errors of one step, O(h^2) and O(h^5): orders 1 and 4.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np

from rodgen.integrate import simulate
from rodgen.scene import Scene
from rodgen_evidence.thesis.audit.claim import Verdict
from rodgen_evidence.thesis.audit.java_equation import FreeRodModel
from rodgen_evidence.thesis.audit.java_object import FLOATS
from rodgen_evidence.thesis.audit.java_steps import (
    MOVE_FRESH,
    complete,
    stepClassical,
    stepEuler,
    stepImprovedEuler,
    stepRungeKutta,
)

TOLERANCE = 0.2  # of a fitted order
SPAN = 0.2  # s
COUNTS = (50, 70, 100, 140)  # steps; the fastest oscillation takes some 0.3 s
NONE, ALL = "none", "follower, gravity, internal and external damping"
LINKS = 3
PHI, OMEGA = (0.3, 0.1, -0.2), (0.5, -1.0, 0.8)
START = (1.0, 6.0)  # m/s: no joint ever moves along the rod, where the damping has a kink
# By the listing's names of the members.
ROD = {"mass": 3.0, "length": 1.5, "stiffness": 1.0, "followerAngle": 0.1}
FINS = {"spikeDampingCoef": 2.0, "mediumDampingCoef": 1.5, "tailDampingCoef": 4.0}
COEFFICIENTS = {
    "followerForce": 3.0,
    "gravityAcceleration": 9.81,
    "innerDampingCoef": 0.05,
    "exterDampingCoef": 0.7,
}


def coefficients(loads: str) -> dict[str, float]:
    """Force [N], acceleration [m/s^2], coefficients of damping; without loads they are zero."""
    return {name: value * (loads == ALL) for name, value in COEFFICIENTS.items()}


@dataclass(frozen=True)
class Reading:
    """A stepper to be measured.

    name: what the text calls it; lines: of the listing; nominal: the order that the text claims;
    reading: how it is read, or what was put right; completed: whether the joints have velocities
    from the start.
    """

    name: str
    lines: str
    nominal: int
    reading: str
    step: Callable[[FreeRodModel], None]
    completed: bool = False


@dataclass(frozen=True, kw_only=True)
class Order(Reading):
    """Order of a stepper: with loads NONE or ALL, steps [s] and errors, the largest of the state
    at the end."""

    loads: str
    steps: tuple[float, ...]
    errors: tuple[float, ...]

    @property
    def slope(self) -> float:
        """The slope fitted over all steps."""
        return float(np.polyfit(np.log(self.steps), np.log(self.errors), 1)[0])

    @property
    def verdict(self) -> Verdict:
        """EXACT where the measured order is the claimed one."""
        return Verdict.EXACT if abs(self.slope - self.nominal) <= TOLERANCE else Verdict.MISPRINT


_RK = partial(Reading, "Runge-Kutta", "800-1002", 4)
READINGS = (
    Reading("Euler", "705-730", 1, "as listed", stepEuler),
    Reading("semi-implicit Euler", "747-772", 1, "as listed", stepImprovedEuler),
    Reading(
        "semi-implicit Euler",
        "747-772",
        1,
        "sines and cosines fresh",
        partial(stepImprovedEuler, move=MOVE_FRESH),
        completed=True,
    ),
    _RK("as listed", stepRungeKutta),
    _RK("as listed, allocateFor copies", partial(stepRungeKutta, copies=True)),
    _RK("sines and cosines fresh", partial(stepRungeKutta, move=MOVE_FRESH), completed=True),
    _RK("stages put right, initial state as listed", stepClassical),
    _RK("stages and initial state put right", stepClassical, completed=True),
)


@cache
def stepper_orders() -> list[Order]:
    """Every reading without loads and with all of them."""
    return [_measure_order(reading, loads) for reading in READINGS for loads in (NONE, ALL)]


def _measure_order(reading: Reading, loads: str) -> Order:
    exact = reference(loads)
    errors = []
    for count in COUNTS:
        it = initial(loads, SPAN / count, reading.completed)
        for _ in range(count):
            reading.step(it)
        errors.append(float(np.abs(state(it) - exact).max()))
    steps = tuple(SPAN / count for count in COUNTS)
    return Order(**vars(reading), loads=loads, steps=steps, errors=tuple(errors))


def initial(loads: str, step: float, completed: bool) -> FreeRodModel:
    """The listing's object after setInitialState."""
    it = FreeRodModel(LINKS, step, FLOATS)
    it.setInitialState(START[0], START[1], OMEGA, PHI, **ROD, **FINS, **coefficients(loads))
    if completed:
        complete(it)
    return it


def state(it: FreeRodModel) -> Any:
    """State in rodgen's order: x0, y0, angles, their rates."""
    start, velocity = list(it.coordinates)[:2], list(it.velocities)[:2]
    return np.array([*start, *it.angles, *velocity, *it.omegas])


def scene(loads: str) -> Scene:
    """The rod of the listing in rodgen, to be integrated without noticeable error."""
    size, fins = coefficients(loads), [FINS["mediumDampingCoef"]] * (LINKS + 1)
    fins[0] *= FINS["spikeDampingCoef"]
    fins[-1] *= FINS["tailDampingCoef"]
    rod = {"links": LINKS, "mass": ROD["mass"], "length": ROD["length"], "boundary": "free"}
    terms = {
        "follower": {"force": size["followerForce"], "angle": ROD["followerAngle"]},
        "gravity": {"g": size["gravityAcceleration"]},
        "internal_damping": {"coefficient": size["innerDampingCoef"]},
        "external_damping": {"coefficient": size["exterDampingCoef"], "fin_factor": fins},
    }
    return Scene.from_dict(
        {
            "name": "three",
            "rod": {**rod, "bending_stiffness": ROD["stiffness"]},
            "loads": terms,
            "initial": {"phi": list(PHI), "omega": list(OMEGA), "velocity": list(START)},
            "integrate": {
                "method": "dop853",
                "span": [0.0, SPAN],
                "rtol": 1e-13,
                "atol": 1e-14,
                "output_every": SPAN,
            },
        }
    )


@cache
def reference(loads: str) -> Any:
    """The state at the end of the span by DOP853."""
    return simulate(scene(loads), target="numpy").y[-1]
