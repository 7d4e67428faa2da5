"""Rods folded back, turned many times, spinning and far away."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from rodgen.judge.stability.extremes_case import TURN, Extreme
from rodgen.judge.stability.extremes_exact import rigid
from rodgen.judge.stability.extremes_scenes import SPAN, N, loaded, rod, shifted
from rodgen.judge.stability.extremes_truth import same_as, tight

BENT = "0.1*cos(pi*s)"


def folded() -> Iterator[Extreme]:
    """Links that lie on each other, and springs that are wound up."""
    pi = float(np.pi)
    zigzag = [0.0, pi] * (N // 2)
    for name, phi, stiff, span in (
        ("every link folded back", zigzag, 30.0, 0.05),
        ("every link folded back, no springs", zigzag, 0.0, 1.0),
        ("one fold of pi", [0.0, 0.0, pi, pi], 30.0, 0.05),
        ("one joint wound by 2 pi", [0.0, 0.0, TURN, TURN], 30.0, 0.05),
    ):
        initial = {"phi": phi, "omega": "0.5 + s"}
        tables = rod(rod={"bending_stiffness": stiff}, initial=initial, span=span)
        yield Extreme("folded", name, tables, tight, quick=name.startswith("every link folded"))
    plain = rod(rod={"bending_stiffness": 0.0}, initial={"phi": [0.1, 0.2, 0.1, 0.3]})
    wound = {**plain, "initial": {**plain["initial"], "phi": []}}
    turns = np.array([0, 3, -7, 1000]) * TURN
    wound["initial"]["phi"] = [
        float(a + b) for a, b in zip(plain["initial"]["phi"], turns, strict=True)
    ]
    carried = np.concatenate((np.zeros(2), turns, np.zeros(N + 2)))
    yield Extreme(
        *("folded", "turns of 2 pi k between links, no springs", wound),
        same_as(plain, lambda y: y + carried),
    )


def turned() -> Iterator[Extreme]:
    """The same motion after many turns."""
    for turns in (1, 1000, 159155, 10**9):
        tables, route = shifted(rod(initial={"phi": BENT}), {"phi": turns * TURN})
        yield Extreme("turned", f"{turns} turns", tables, route, quick=turns == 159155)
    for turns in (0, 159155):
        loose = {**rod(initial={"phi": BENT}), "integrate": {"span": [0.0, SPAN], "rtol": 1e-4}}
        tables, route = shifted(loose, {"phi": turns * TURN})
        yield Extreme("turned", f"{turns} turns, rtol 0.0001", tables, route, quick=turns > 0)
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
        yield Extreme("turned", f"{turns} turns, a chain", swings, route)
    far = rod(initial={"phi": 1e16, "omega": 0.0})
    yield Extreme("turned", "phi 1e16, which has no sine", far, rigid)


def spinning() -> Iterator[Extreme]:
    """Straight rods in free flight turn steadily, at any stiffness."""
    for power in (0, 3, 6):
        for stiffness in (0.0, 30.0, 1e6):
            spins = rod(
                rod={"bending_stiffness": stiffness},
                initial={"phi": 0.2, "omega": 10.0**power, "velocity": [1.0, 2.0]},
                span=100.0 / 10.0**power,
            )
            name = f"1e{power:+d} rad/s, EI {stiffness:g}, 16 turns"
            yield Extreme("spinning", name, spins, rigid, quick=power == 6)
    fast = rod(initial={"phi": 0.2, "omega": 1e3}, span=10.0)
    yield Extreme("spinning", "1e+3 rad/s, 1600 turns", fast, rigid)
    bent = rod(initial={"phi": BENT, "omega": 1e3}, span=0.05)
    yield Extreme("spinning", "1e+3 rad/s, bent", bent, tight)
    whirl = rod(initial={"phi": BENT, "omega": 1e6}, span=0.05e-3)
    yield Extreme("spinning", "1e+6 rad/s, bent", whirl, tight)


def far() -> Iterator[Extreme]:
    """The same motion somewhere else, and in passing."""
    for power in (3, 6, 9, 12):
        tables, route = shifted(loaded(), {"x": 10.0**power, "y": -(10.0**power)})
        yield Extreme("far", f"x0 1e{power:+d} m", tables, route, quick=power == 12)
    for power in (3, 6, 9):
        tables, route = shifted(rod(initial={"phi": BENT}), {"vx": 10.0**power})
        yield Extreme("far", f"vx0 1e{power:+d} m/s", tables, route)
