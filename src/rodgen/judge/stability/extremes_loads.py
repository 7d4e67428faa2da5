"""Follower forces far beyond critical, loads that switch, and damping without bounds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

import rodgen
from rodgen.judge.stability.extremes_case import Array, Extreme, Tables, Truth
from rodgen.judge.stability.extremes_exact import drifting, resting
from rodgen.judge.stability.extremes_scenes import CRITICAL, IDLE, SPAN, N, rod
from rodgen.judge.stability.extremes_truth import same_as, stiff, switched, tight

BEFORE = 7.2  # s, when a pulse at 7.3 s is not there yet
OFTEN, OFTEN_FOR = 500, 5.0  # times a second that a load is switched on, and for how long [s]


def pushed(force: float | str, span: float = SPAN, sign: float = 1.0, **tables: Any) -> Tables:
    """Free, under a follower force; sign -1: its mirror image about the x axis."""
    loads = {**IDLE, "follower": {"force": force, "angle": 0.1 * sign}}
    initial = {"phi": f"{0.2 * sign!r}*cos(pi*s)", "omega": f"{0.1 * sign!r}*s"}
    return rod(span=span, loads=loads, initial=initial, **tables)


def _mirrored(y: Array) -> Array:
    half = y.shape[1] // 2
    signs = np.ones(y.shape[1])
    signs[1:half] = signs[half + 1 :] = -1.0
    return y * signs


def follower() -> Iterator[Extreme]:
    """From nothing to 1000 times critical, pushing and pulling, ramped and switched."""
    for times in (0.0, 0.5, 1.0, 10.0, 100.0, 1000.0):
        force = CRITICAL * times
        span = 0.3 / max(1.0, times) ** 0.5
        tables = pushed(force, span)
        yield Extreme("follower", f"{times:g} times critical", tables, tight, quick=times == 1000)
        if times:
            yield Extreme(
                "follower", f"{times:g} times critical, pulling", pushed(-force, span), tight
            )
    yield Extreme(
        *("follower", "10 times critical, mirrored", pushed(10 * CRITICAL, 0.1, -1.0)),
        same_as(pushed(10 * CRITICAL, 0.1), _mirrored),
    )
    high = f"{0.8 * CRITICAL!r}"
    ramp = pushed(f"{high}*min(t/0.1, 1) if t < 0.2 else 0", 0.3)
    yield Extreme("follower", "ramped, then switched off", ramp, tight)
    for name, text in (
        ("switched 20 times", f"{high} if sin(20*pi*t) > 0 else -{high}"),
        ("reversed within 1e-9 s", f"{high}*tanh((0.5 - t)*1e9)"),
        ("a pulse of 1e-3 s at 0.7 s", f"30*{high}*exp(-((t - 0.7)/0.0003)**2)"),
    ):
        yield Extreme("follower", name, pushed(text, 1.0), tight)
    half = 0.5 / OFTEN
    fast = pushed(f"3 if sin(2*pi*{OFTEN}*t) > 0 else 0", OFTEN_FOR)
    jumps = [k * half for k in range(1, round(OFTEN_FOR / half))]
    name = f"switched {OFTEN} times a second, for {OFTEN_FOR:g} s"
    yield Extreme("follower", name, fast, switched(jumps))
    still = rod(
        rod={"bending_stiffness": 0.01},
        loads={"tip": {"y": "2*exp(-((t - 7.3)/0.01)**2)"}},
        initial={"phi": 0.0, "omega": 0.0},
        span=10.0,
    )
    yield Extreme("follower", "a pulse of 0.01 s upon a rod at rest", still, pulsed)


def pulsed(scene: rodgen.Scene) -> Truth:
    """A rod at rest until shortly before a pulse: from there on with steps of its own."""
    late = scene.with_integrate(span=[BEFORE, scene.integrate.span[1]], output_every=0.05)
    known, times = tight(late), scene.integrate.samples
    rest = np.tile(scene.initial_state(), (int(np.sum(times < BEFORE)), 1))
    at = [int(np.argmin(abs(late.integrate.samples - t))) for t in times[times >= BEFORE]]
    return replace(known, y=np.concatenate((rest, known.y[at])))


def damped(internal: float = 0.0, external: float = 0.0, span: float = SPAN) -> Tables:
    """Under thrust and gravity, with damping inside [m^2/s] and outside [1/s]."""
    loads: Tables = {
        "follower": {"force": 40.0},
        "gravity": {"g": 9.81},
        "internal_damping": {"coefficient": internal},
        "external_damping": {"coefficient": external, "fin_factor": {"tail": 3.0}},
    }
    start = {"position": [0.0, 0.0], "velocity": [3.0, 1.0]}
    return rod(span=span, loads=loads, initial=start)


def damping() -> Iterator[Extreme]:
    """From nothing to a million times critical."""
    for power in (-12, -3, 0, 2, 4, 6):
        coefficient = 10.0**power
        for kind in ("internal", "external"):
            tables = damped(**{kind: coefficient})
            route = tight if power <= 0 else stiff
            name = f"{kind} 1e{power:+d}"
            yield Extreme("damping", name, tables, route, quick=power == 6 and kind == "internal")
    both = damped(1e4, 1e4)
    yield Extreme("damping", "both 1e+4", both, stiff)


def still() -> Iterator[Extreme]:
    """Velocities that vanish or agree at every joint, in external damping."""
    drag = {**IDLE, "external_damping": {"coefficient": 5.0}}
    for name, angle, velocity in (
        ("at rest", 0.3, [0.0, 0.0]),
        ("along the rod", 0.0, [2.0, 0.0]),
        ("across the rod", 0.0, [0.0, 2.0]),
        ("aslant", 0.0, [1.0, 2.0]),
        ("across, at 1e-160 m/s", 0.0, [0.0, 1e-160]),
        ("across, at 1e6 m/s", 0.0, [0.0, 1e6]),
    ):
        initial = {"phi": angle, "omega": 0.0, "velocity": velocity}
        tables = rod(loads=drag, initial=initial)
        yield Extreme(
            "still",
            name,
            tables,
            drifting if any(velocity) else resting,
            quick=name == "across the rod",
        )
    # Here explicit steps grow beyond what their stability allows, if nothing holds them.
    calm = {"phi": 0.0, "omega": 0.0, "velocity": [1.0, 2.0]}
    loose = rod(loads=drag, initial=calm, integrate={"rtol": 1e-5, "atol": 1e-7})
    yield Extreme("still", "aslant, rtol 1e-5", loose, drifting, quick=True)
    turning = rod(loads=drag, initial={"phi": 0.0, "omega": 1.0})
    yield Extreme("still", "joint 0 alone at rest", turning, tight)
    meeting = rod(loads=drag, initial={"phi": 0.0, "omega": [1.0, -1.0, 1.0, -1.0][:N]})
    yield Extreme("still", "every other joint at rest", meeting, tight)
