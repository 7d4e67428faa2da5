"""Few and many links, short and long spans, loose and tight tolerances."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import rodgen
from rodgen.judge.stability.extremes_case import Extreme, Tables, Truth
from rodgen.judge.stability.extremes_exact import pendulum, resting, rigid
from rodgen.judge.stability.extremes_loads import damped, pushed
from rodgen.judge.stability.extremes_scenes import SPAN, loaded, rescaled, rod
from rodgen.judge.stability.extremes_truth import compiled, same_as, stiff, switched, tight

LATE = 1.7e9  # s: seconds since 1970, as clocks of computers have them
FALLING = {"gravity": {"g": 9.81}}
COMPILED = ("rk4 c", "dop853 c", "gauss c", "radau c", "auto c", "semi_implicit_euler c")
FEW = ("dop853 c", "gauss c", "radau c")


def links() -> Iterator[Extreme]:
    """One, two, three, a thousand and ten thousand links."""
    swing = rod(1, 2.0, rod={"boundary": "pinned"}, loads=FALLING)
    swing["initial"] = {"phi": 1.5, "omega": 0.0}
    yield Extreme("links", "1, a pendulum", swing, pendulum, quick=True)
    alone = rod(1, initial={"phi": 0.3, "omega": 3.0}, loads=FALLING)
    yield Extreme("links", "1, in free flight", alone, rigid)
    for n in (1, 2, 3):
        yield Extreme("links", f"{n}, all loads", loaded(links=n), tight)
    for n, straight, span in ((1000, 1e-4, 1e-4), (10_000, 1e-6, 2e-9)):
        turning = {"phi": 0.3, "omega": 3.0}
        flies = rod(n, straight, initial=turning, loads=FALLING)
        yield Extreme("links", f"{n}, straight", flies, rigid, COMPILED)
        still = {"phi": "0.3*cos(pi*s)", "omega": 0.0}
        bent = rod(n, span, initial=still, loads=FALLING, integrate={"rtol": 1e-6, "atol": 1e-8})
        yield Extreme("links", f"{n}, bent", bent, compiled, COMPILED, n == 1000, FEW)


def spans() -> Iterator[Extreme]:
    """From a nanosecond to eleven days."""
    for power in (-9, -6):
        short = loaded()
        short["integrate"] = {"span": [0.0, 10.0**power]}
        yield Extreme("spans", f"1e{power:+d} s", short, tight, quick=power == -9)
    late = loaded()
    late["integrate"] = {"span": [1e6, 1e6 + SPAN]}
    yield Extreme("spans", f"{SPAN:g} s, from 1e6 s on", late, rescaled(1.0, 1.0))
    for start in (LATE, -LATE):
        yield Extreme("spans", f"2 s, from {start:.2g} s on", _loaded_from(start), _as_from_zero)
    jumps = f"40 if t < {LATE + 1:.1f} else -40", "40 if t < 1 else -40"
    at_last, at_once = (pushed(text, 2.0) for text in jumps)
    at_last["integrate"] = {"span": [LATE, LATE + 2.0]}
    name = f"2 s, from {LATE:.2g} s on, a force that jumps"
    yield Extreme("spans", name, at_last, same_as(at_once, np.copy, switched([1.0])))
    for power in (3, 6):
        time = 10.0**power
        slow = loaded(time=time)
        yield Extreme("spans", f"1e{power:+d} s, slow", slow, rescaled(1.0, time), quick=power == 6)
    hangs = rod(
        rod={"boundary": "pinned"},
        loads={**FALLING, "internal_damping": {"coefficient": 0.5}},
        initial={"phi": -1.5707963267948966, "omega": 0.0},
        span=1e6,
    )
    yield Extreme("spans", "1e+6 s, hanging still", hangs, resting)


def _loaded_from(start: float) -> Tables:
    return {**loaded(), "integrate": {"span": [start, start + 2.0]}}


def _as_from_zero(scene: rodgen.Scene) -> Truth:
    """No load knows what time it is."""
    return same_as(_loaded_from(0.0), np.copy)(scene)


def tolerances() -> Iterator[Extreme]:
    """From loose to tighter than a double can be."""
    for rtol in (0.1, 1e-2, 1e-4, 1e-6, 1e-10, 1e-13, 2.3e-14):
        tables = loaded()
        tables["integrate"] |= {"rtol": rtol, "atol": rtol * 1e-2}
        yield Extreme("tolerances", f"rtol {rtol:g}", tables, tight, quick=rtol in (1e-2, 1e-13))
    loose = damped(internal=1e4)
    loose["integrate"] |= {"rtol": 1e-2, "atol": 1e-4}
    yield Extreme("tolerances", "rtol 0.01, stiff", loose, stiff)
