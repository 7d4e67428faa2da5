"""The extreme cases: forces, damping, shapes, scales and sizes at the edge."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

import rodgen
from rodgen_evidence.report.stability.extremes_case import (
    TURN,
    Array,
    ExtremeCase,
    Tables,
    TrueMotion,
    drifting,
    pendulum,
    resting,
    rigid,
)
from rodgen_evidence.report.stability.extremes_truth import (
    CRITICAL,
    IDLE,
    MASS,
    SPAN,
    STIFFNESS,
    N,
    compiled_truth,
    loaded_rod,
    piecewise,
    rescaling,
    rod,
    same_as,
    shifted_rod,
    stiff,
    tight,
)

HANGING = {"boundary": "pinned"}
FALLING = {"gravity": {"g": 9.81}}


def stiffness() -> Iterator[ExtremeCase]:
    """EI from 1e-12 to 1e12 N m^2: in time units of its own, and with the units of the rest."""
    for power in (-12, -6, 0, 6, 12):
        time = (STIFFNESS / 10.0**power) ** 0.5
        yield ExtremeCase(
            f"EI 1e{power:+d}, all in its own time",
            loaded_rod(time=time),
            rescaling(1.0, time),
            quick=power in (-12, 12),
        )
    swings = rod(
        rod={**HANGING, "bending_stiffness": 0.0},
        loads=FALLING,
        initial={"phi": "-1.2 + 0.3*s", "omega": 0.0},
    )
    yield ExtremeCase("EI 0, a chain", swings, tight)
    for power in (-12, -3):
        soft = {**swings, "rod": {**swings["rod"], "bending_stiffness": 10.0**power}}
        yield ExtremeCase(f"EI 1e{power:+d}, a chain nearly", soft, tight)
    for power in (6, 9, 12):
        yield ExtremeCase(f"EI 1e{power:+d}, a rigid pendulum", _pendulum(power), pendulum)
    for power in (0, 6, 12):
        stiff = rod(
            rod={"bending_stiffness": 10.0**power},
            loads=FALLING,
            initial={"phi": 0.3, "omega": 2.0, "velocity": [1.0, 2.0]},
        )
        yield ExtremeCase(f"EI 1e{power:+d}, straight and turning", stiff, rigid)


def _pendulum(power: int) -> Tables:
    return rod(
        rod={**HANGING, "bending_stiffness": 10.0**power},
        loads=FALLING,
        initial={"phi": -0.5, "omega": 0.0},
    )


def mass() -> Iterator[ExtremeCase]:
    """M from 1e-12 to 1e12 kg: with forces in proportion, and with EI as it is."""
    for power in (-12, -6, 6, 12):
        by = 10.0**power / MASS
        yield ExtremeCase(
            f"M 1e{power:+d}, forces in proportion", loaded_rod(mass=by), rescaling(1.0, 1.0)
        )
        time = by**0.5
        yield ExtremeCase(
            f"M 1e{power:+d}, in its own time",
            loaded_rod(mass=by, time=time),
            rescaling(1.0, time),
            quick=power == -12,
        )


def length() -> Iterator[ExtremeCase]:
    """L from 1e-6 to 1e6 m."""
    for power in (-6, -3, 3, 6):
        by = 10.0**power / 2.0
        yield ExtremeCase(
            f"L 1e{power:+d}, in the same time",
            loaded_rod(length=by),
            rescaling(by, 1.0),
            quick=abs(power) == 6,
        )
        time = by**1.5  # as EI stays what it is
        yield ExtremeCase(
            f"L 1e{power:+d}, in its own time",
            loaded_rod(length=by, time=time),
            rescaling(by, time),
        )


BEFORE = 7.2  # s, when a pulse at 7.3 s is not there yet
OFTEN, OFTEN_FOR = 500, 5.0  # times a second that a load is switched on, and for how long [s]


def follower_rod(
    force: float | str, span: float = SPAN, sign: float = 1.0, **tables: Any
) -> Tables:
    """Free rod under a follower force; sign -1: its mirror image about the x axis."""
    loads = {**IDLE, "follower": {"force": force, "angle": 0.1 * sign}}
    initial = {"phi": f"{0.2 * sign!r}*cos(pi*s)", "omega": f"{0.1 * sign!r}*s"}
    return rod(span=span, loads=loads, initial=initial, **tables)


def _mirror(y: Array) -> Array:
    half = y.shape[1] // 2
    signs = np.ones(y.shape[1])
    signs[1:half] = signs[half + 1 :] = -1.0
    return y * signs


def follower() -> Iterator[ExtremeCase]:
    """Thrusts from nothing to 1000 times critical, pushing and pulling, ramped and switched."""
    for times in (0.0, 0.5, 1.0, 10.0, 100.0, 1000.0):
        force = CRITICAL * times
        span = 0.3 / max(1.0, times) ** 0.5
        tables = follower_rod(force, span)
        yield ExtremeCase(f"{times:g} times critical", tables, tight, quick=times == 1000)
        if times:
            yield ExtremeCase(
                f"{times:g} times critical, pulling", follower_rod(-force, span), tight
            )
    yield ExtremeCase(
        "10 times critical, mirrored",
        follower_rod(10 * CRITICAL, 0.1, -1.0),
        same_as(follower_rod(10 * CRITICAL, 0.1), _mirror),
    )
    high = f"{0.8 * CRITICAL!r}"
    ramp = follower_rod(f"{high}*min(t/0.1, 1) if t < 0.2 else 0", 0.3)
    yield ExtremeCase("ramped, then switched off", ramp, tight)
    for name, text in (
        ("switched 20 times", f"{high} if sin(20*pi*t) > 0 else -{high}"),
        ("reversed within 1e-9 s", f"{high}*tanh((0.5 - t)*1e9)"),
        ("a pulse of 1e-3 s at 0.7 s", f"30*{high}*exp(-((t - 0.7)/0.0003)**2)"),
    ):
        yield ExtremeCase(name, follower_rod(text, 1.0), tight)
    half = 0.5 / OFTEN
    fast = follower_rod(f"3 if sin(2*pi*{OFTEN}*t) > 0 else 0", OFTEN_FOR)
    jumps = [k * half for k in range(1, round(OFTEN_FOR / half))]
    name = f"switched {OFTEN} times a second, for {OFTEN_FOR:g} s"
    yield ExtremeCase(name, fast, piecewise(jumps))
    still = rod(
        rod={"bending_stiffness": 0.01},
        loads={"tip": {"y": "2*exp(-((t - 7.3)/0.01)**2)"}},
        initial={"phi": 0.0, "omega": 0.0},
        span=10.0,
    )
    yield ExtremeCase("a pulse of 0.01 s upon a rod at rest", still, pulse_truth)


def pulse_truth(scene: rodgen.Scene) -> TrueMotion:
    """Compute the motion of a rod at rest until shortly before a pulse, from there in own steps."""
    late = scene.with_integrate(span=[BEFORE, scene.integrate.span[1]], output_every=0.05)
    known, times = tight(late), scene.integrate.sample_times
    rest = np.tile(scene.initial_state(), (int(np.sum(times < BEFORE)), 1))
    at = [int(np.argmin(abs(late.integrate.sample_times - t))) for t in times[times >= BEFORE]]
    return replace(known, y=np.concatenate((rest, known.y[at])))


def damped_rod(internal: float = 0.0, external: float = 0.0, span: float = SPAN) -> Tables:
    """Rod under thrust and gravity, with damping inside [m^2/s] and outside [1/s]."""
    loads: Tables = {
        "follower": {"force": 40.0},
        "gravity": {"g": 9.81},
        "internal_damping": {"coefficient": internal},
        "external_damping": {"coefficient": external, "fin_factor": {"tail": 3.0}},
    }
    start = {"position": [0.0, 0.0], "velocity": [3.0, 1.0]}
    return rod(span=span, loads=loads, initial=start)


def damping() -> Iterator[ExtremeCase]:
    """Dampings from nothing to a million times critical."""
    for power in (-12, -3, 0, 2, 4, 6):
        coefficient = 10.0**power
        for kind in ("internal", "external"):
            tables = damped_rod(**{kind: coefficient})
            route = tight if power <= 0 else stiff
            name = f"{kind} 1e{power:+d}"
            yield ExtremeCase(name, tables, route, quick=power == 6 and kind == "internal")
    both = damped_rod(1e4, 1e4)
    yield ExtremeCase("both 1e+4", both, stiff)


def still() -> Iterator[ExtremeCase]:
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
        yield ExtremeCase(
            name, tables, drifting if any(velocity) else resting, quick=name == "across the rod"
        )
    # Here explicit steps grow beyond what their stability allows, if nothing holds them.
    calm = {"phi": 0.0, "omega": 0.0, "velocity": [1.0, 2.0]}
    loose = rod(loads=drag, initial=calm, integrate={"rtol": 1e-5, "atol": 1e-7})
    yield ExtremeCase("aslant, rtol 1e-5", loose, drifting, quick=True)
    turning = rod(loads=drag, initial={"phi": 0.0, "omega": 1.0})
    yield ExtremeCase("joint 0 alone at rest", turning, tight)
    meeting = rod(loads=drag, initial={"phi": 0.0, "omega": [1.0, -1.0, 1.0, -1.0][:N]})
    yield ExtremeCase("every other joint at rest", meeting, tight)


BENT = "0.1*cos(pi*s)"


def folded_links() -> Iterator[ExtremeCase]:
    """Links that lie on each other, and springs that are wound up."""
    pi = float(np.pi)
    zigzag = [0.0, pi] * (N // 2)
    for name, phi, springs, span in (
        ("every link folded back", zigzag, 30.0, 0.05),
        ("every link folded back, no springs", zigzag, 0.0, 1.0),
        ("one fold of pi", [0.0, 0.0, pi, pi], 30.0, 0.05),
        ("one joint wound by 2 pi", [0.0, 0.0, TURN, TURN], 30.0, 0.05),
    ):
        initial = {"phi": phi, "omega": "0.5 + s"}
        tables = rod(rod={"bending_stiffness": springs}, initial=initial, span=span)
        yield ExtremeCase(name, tables, tight, quick=name.startswith("every link folded"))
    plain = rod(rod={"bending_stiffness": 0.0}, initial={"phi": [0.1, 0.2, 0.1, 0.3]})
    wound = {**plain, "initial": {**plain["initial"], "phi": []}}
    turns = np.array([0, 3, -7, 1000]) * TURN
    wound["initial"]["phi"] = [
        float(a + b) for a, b in zip(plain["initial"]["phi"], turns, strict=True)
    ]
    carried = np.concatenate((np.zeros(2), turns, np.zeros(N + 2)))
    yield ExtremeCase(
        "turns of 2 pi k between links, no springs", wound, same_as(plain, lambda y: y + carried)
    )


def turned_rods() -> Iterator[ExtremeCase]:
    """One motion, begun after more and more turns."""
    for turns in (1, 1000, 159155, 10**9):
        tables, route = shifted_rod(rod(initial={"phi": BENT}), {"phi": turns * TURN})
        yield ExtremeCase(f"{turns} turns", tables, route, quick=turns == 159155)
    for turns in (0, 159155):
        loose = {**rod(initial={"phi": BENT}), "integrate": {"span": [0.0, SPAN], "rtol": 1e-4}}
        tables, route = shifted_rod(loose, {"phi": turns * TURN})
        yield ExtremeCase(f"{turns} turns, rtol 0.0001", tables, route, quick=turns > 0)
    for turns in (0, 159155):
        swings = rod(
            2,
            3.0,
            rod={"boundary": "pinned", "bending_stiffness": 0.0},
            loads={"gravity": {"g": 9.81}},
            initial={"phi": [0.1 + turns * TURN, 0.5 + turns * TURN], "omega": 0.0},
        )
        plain = {**swings, "initial": {"phi": [0.1, 0.5], "omega": 0.0}}
        route = same_as(plain, partial(np.add, turns * TURN * np.array([1, 1, 0, 0])))
        yield ExtremeCase(f"{turns} turns, a chain", swings, route)
    far = rod(initial={"phi": 1e16, "omega": 0.0})
    yield ExtremeCase("phi 1e16, which has no sine", far, rigid)


def spinning() -> Iterator[ExtremeCase]:
    """Straight rods in free flight turn steadily, at any stiffness."""
    for power in (0, 3, 6):
        for stiffness in (0.0, 30.0, 1e6):
            spins = rod(
                rod={"bending_stiffness": stiffness},
                initial={"phi": 0.2, "omega": 10.0**power, "velocity": [1.0, 2.0]},
                span=100.0 / 10.0**power,
            )
            name = f"1e{power:+d} rad/s, EI {stiffness:g}, 16 turns"
            yield ExtremeCase(name, spins, rigid, quick=power == 6)
    fast = rod(initial={"phi": 0.2, "omega": 1e3}, span=10.0)
    yield ExtremeCase("1e+3 rad/s, 1600 turns", fast, rigid)
    bent = rod(initial={"phi": BENT, "omega": 1e3}, span=0.05)
    yield ExtremeCase("1e+3 rad/s, bent", bent, tight)
    whirl = rod(initial={"phi": BENT, "omega": 1e6}, span=0.05e-3)
    yield ExtremeCase("1e+6 rad/s, bent", whirl, tight)


def far() -> Iterator[ExtremeCase]:
    """One motion, begun ever farther away, and in ever faster passing."""
    for power in (3, 6, 9, 12):
        tables, route = shifted_rod(loaded_rod(), {"x": 10.0**power, "y": -(10.0**power)})
        yield ExtremeCase(f"x0 1e{power:+d} m", tables, route, quick=power == 12)
    for power in (3, 6, 9):
        tables, route = shifted_rod(rod(initial={"phi": BENT}), {"vx": 10.0**power})
        yield ExtremeCase(f"vx0 1e{power:+d} m/s", tables, route)


LATE = 1.7e9  # s: seconds since 1970, as clocks of computers have them
COMPILED = ("rk4 c", "dop853 c", "gauss c", "radau c", "auto c", "semi_implicit_euler c")
FEW = ("dop853 c", "gauss c", "radau c")


def links() -> Iterator[ExtremeCase]:
    """One, two, three, a thousand and ten thousand links."""
    swing = rod(1, 2.0, rod={"boundary": "pinned"}, loads=FALLING)
    swing["initial"] = {"phi": 1.5, "omega": 0.0}
    yield ExtremeCase("1, a pendulum", swing, pendulum, quick=True)
    alone = rod(1, initial={"phi": 0.3, "omega": 3.0}, loads=FALLING)
    yield ExtremeCase("1, in free flight", alone, rigid)
    for n in (1, 2, 3):
        yield ExtremeCase(f"{n}, all loads", loaded_rod(links=n), tight)
    for n, straight, span in ((1000, 1e-4, 1e-4), (10_000, 1e-6, 2e-9)):
        turning = {"phi": 0.3, "omega": 3.0}
        flies = rod(n, straight, initial=turning, loads=FALLING)
        yield ExtremeCase(f"{n}, straight", flies, rigid, COMPILED)
        still = {"phi": "0.3*cos(pi*s)", "omega": 0.0}
        bent = rod(n, span, initial=still, loads=FALLING, integrate={"rtol": 1e-6, "atol": 1e-8})
        yield ExtremeCase(f"{n}, bent", bent, compiled_truth, COMPILED, n == 1000, FEW)


def spans() -> Iterator[ExtremeCase]:
    """Spans from a nanosecond to eleven days."""
    for power in (-9, -6):
        short = loaded_rod()
        short["integrate"] = {"span": [0.0, 10.0**power]}
        yield ExtremeCase(f"1e{power:+d} s", short, tight, quick=power == -9)
    late = loaded_rod()
    late["integrate"] = {"span": [1e6, 1e6 + SPAN]}
    yield ExtremeCase(f"{SPAN:g} s, from 1e6 s on", late, rescaling(1.0, 1.0))
    for start in (LATE, -LATE):
        yield ExtremeCase(f"2 s, from {start:.2g} s on", _loaded_from(start), _as_from_zero)
    jumps = f"40 if t < {LATE + 1:.1f} else -40", "40 if t < 1 else -40"
    at_last, at_once = (follower_rod(text, 2.0) for text in jumps)
    at_last["integrate"] = {"span": [LATE, LATE + 2.0]}
    name = f"2 s, from {LATE:.2g} s on, a force that jumps"
    yield ExtremeCase(name, at_last, same_as(at_once, np.copy, piecewise([1.0])))
    for power in (3, 6):
        time = 10.0**power
        slow = loaded_rod(time=time)
        yield ExtremeCase(f"1e{power:+d} s, slow", slow, rescaling(1.0, time), quick=power == 6)
    hangs = rod(
        rod={"boundary": "pinned"},
        loads={**FALLING, "internal_damping": {"coefficient": 0.5}},
        initial={"phi": -1.5707963267948966, "omega": 0.0},
        span=1e6,
    )
    yield ExtremeCase("1e+6 s, hanging still", hangs, resting)


def _loaded_from(start: float) -> Tables:
    return {**loaded_rod(), "integrate": {"span": [start, start + 2.0]}}


def _as_from_zero(scene: rodgen.Scene) -> TrueMotion:
    """Compute the motion from time zero, as no load depends on time."""
    return same_as(_loaded_from(0.0), np.copy)(scene)


def tolerances() -> Iterator[ExtremeCase]:
    """Tolerances from loose to tighter than a double can be."""
    for rtol in (0.1, 1e-2, 1e-4, 1e-6, 1e-10, 1e-13, 2.3e-14):
        tables = loaded_rod()
        tables["integrate"] |= {"rtol": rtol, "atol": rtol * 1e-2}
        yield ExtremeCase(f"rtol {rtol:g}", tables, tight, quick=rtol in (1e-2, 1e-13))
    loose = damped_rod(internal=1e4)
    loose["integrate"] |= {"rtol": 1e-2, "atol": 1e-4}
    yield ExtremeCase("rtol 0.01, stiff", loose, stiff)


GROUPS: dict[str, Callable[[], Iterator[ExtremeCase]]] = {
    group.__name__: group
    for group in (
        *(
            stiffness,
            mass,
            length,
            follower,
            damping,
            still,
            folded_links,
            turned_rods,
            spinning,
            far,
        ),
        *(links, spans, tolerances),
    )
}
