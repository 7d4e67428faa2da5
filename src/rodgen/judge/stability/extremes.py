"""Section "extremes": what happens at the edges, case by method."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rodgen.judge.cases import Case
from rodgen.judge.stability import extremes_invalid
from rodgen.judge.stability import extremes_loads as loads
from rodgen.judge.stability import extremes_motions as motions
from rodgen.judge.stability import extremes_scales as scales
from rodgen.judge.stability import extremes_sizes as sizes
from rodgen.judge.stability.extremes_case import Extreme
from rodgen.judge.stability.extremes_run import judge
from rodgen.judge.unit import Row, Unit

GROUPS: dict[str, Callable[[], Iterator[Extreme]]] = {
    "stiffness": sizes.stiffness,
    "mass": sizes.mass,
    "length": sizes.length,
    "follower": loads.follower,
    "damping": loads.damping,
    "still": loads.still,
    "folded": motions.folded,
    "turned": motions.turned,
    "spinning": motions.spinning,
    "far": motions.far,
    "links": scales.links,
    "spans": scales.spans,
    "tolerances": scales.tolerances,
}

INVALID = "invalid"
LIMIT = 300.0  # s for a group, on a busy machine
ALL = (*GROUPS, INVALID)
# In the short report most of the time goes into making modules: those that run at once at first
# have none in common.
EARLY = ("stiffness", "folded", "links", "damping")


def units(cases: list[Case], quick: bool = False) -> list[Unit]:
    """A unit for each group; the cases of the page have no part in them."""
    function = f"{__name__}:measure"
    names = (*EARLY, *(group for group in ALL if group not in EARLY)) if quick else ALL
    return [
        Unit(
            "extremes",
            f"extremes-{group}",
            function,
            {"group": group, "quick": quick},
            False,
            LIMIT,
        )
        for group in names
    ]


def measure(group: str, quick: bool = False) -> list[Row]:
    """All rows of a group."""
    if group == INVALID:
        return extremes_invalid.rows(quick)
    found = (case for case in GROUPS[group]() if case.quick or not quick)
    return [row for case in found for row in judge(case, quick)]
