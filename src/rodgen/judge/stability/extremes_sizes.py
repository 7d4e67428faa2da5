"""Stiffness, mass and length over many orders of magnitude."""

from __future__ import annotations

from collections.abc import Iterator

from rodgen.judge.stability.extremes_case import Extreme, Tables
from rodgen.judge.stability.extremes_exact import pendulum, rigid
from rodgen.judge.stability.extremes_scenes import MASS, STIFFNESS, loaded, rescaled, rod
from rodgen.judge.stability.extremes_truth import tight

HANGING = {"boundary": "pinned"}
FALLING = {"gravity": {"g": 9.81}}


def stiffness() -> Iterator[Extreme]:
    """EI from 1e-12 to 1e12 N m^2: in time units of its own, and with the units of the rest."""
    for power in (-12, -6, 0, 6, 12):
        time = (STIFFNESS / 10.0**power) ** 0.5
        yield Extreme(
            *("stiffness", f"EI 1e{power:+d}, all in its own time", loaded(time=time)),
            rescaled(1.0, time),
            quick=power in (-12, 12),
        )
    swings = rod(
        rod={**HANGING, "bending_stiffness": 0.0},
        loads=FALLING,
        initial={"phi": "-1.2 + 0.3*s", "omega": 0.0},
    )
    yield Extreme("stiffness", "EI 0, a chain", swings, tight)
    for power in (-12, -3):
        soft = {**swings, "rod": {**swings["rod"], "bending_stiffness": 10.0**power}}
        yield Extreme("stiffness", f"EI 1e{power:+d}, a chain nearly", soft, tight)
    for power in (6, 9, 12):
        yield Extreme("stiffness", f"EI 1e{power:+d}, a rigid pendulum", _pendulum(power), pendulum)
    for power in (0, 6, 12):
        stiff = rod(
            rod={"bending_stiffness": 10.0**power},
            loads=FALLING,
            initial={"phi": 0.3, "omega": 2.0, "velocity": [1.0, 2.0]},
        )
        yield Extreme("stiffness", f"EI 1e{power:+d}, straight and turning", stiff, rigid)


def _pendulum(power: int) -> Tables:
    return rod(
        rod={**HANGING, "bending_stiffness": 10.0**power},
        loads=FALLING,
        initial={"phi": -0.5, "omega": 0.0},
    )


def mass() -> Iterator[Extreme]:
    """M from 1e-12 to 1e12 kg: with forces in proportion, and with EI as it is."""
    for power in (-12, -6, 6, 12):
        by = 10.0**power / MASS
        yield Extreme(
            *("mass", f"M 1e{power:+d}, forces in proportion", loaded(mass=by)),
            *(rescaled(1.0, 1.0),),
        )
        time = by**0.5
        yield Extreme(
            *("mass", f"M 1e{power:+d}, in its own time", loaded(mass=by, time=time)),
            rescaled(1.0, time),
            quick=power == -12,
        )


def length() -> Iterator[Extreme]:
    """L from 1e-6 to 1e6 m."""
    for power in (-6, -3, 3, 6):
        by = 10.0**power / 2.0
        yield Extreme(
            *("length", f"L 1e{power:+d}, in the same time", loaded(length=by)),
            rescaled(by, 1.0),
            quick=abs(power) == 6,
        )
        time = by**1.5  # as EI stays what it is
        yield Extreme(
            *("length", f"L 1e{power:+d}, in its own time", loaded(length=by, time=time)),
            rescaled(by, time),
        )
