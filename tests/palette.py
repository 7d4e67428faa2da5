"""The structures that tests compile, and the choice of cases that stands for all of them.

A C module takes seconds to compile, and thousands of cases minutes: tests share the structures of
`PALETTE`, and of the full product of their factors the sets of tests run covering arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import combinations, product
from typing import Any

import pytest

from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.term import BASE, CONTACT
from rodgen.model.terms import TERMS, THESIS_TERMS
from rodgen.scene.structure import Structure

# All loads that are smooth in the motion; what moves a base is nothing without keys.
ALL = tuple(name for name, term in TERMS.items() if term.kind not in (BASE, CONTACT))
# What is derived and compiled grows faster than the number of loads: most structures have half of
# them, those at joints and ends or those all along the rod; a load that is new joins the latter.
ENDS = (*THESIS_TERMS, "tip_load")
ALONG = tuple(term for term in ALL if term not in ENDS)
# Every boundary with both inertias, every load with and without its neighbours, one link, two, and
# three of which one is inside.
SMALL = (
    Structure(1, "free", "uniform", ALONG),
    Structure(1, "clamped", "lumped", ENDS),
    Structure(2, "cantilever", "uniform", ALL),
    Structure(2, "free", "lumped", ()),
    Structure(3, "pinned", "lumped", ("internal_damping",)),
    Structure(3, "clamped", "uniform", ENDS),
    Structure(3, "cantilever", "lumped", ALONG),
    Structure(5),
)
# Joint forces are cut into segments from 9 and from 28 unknowns on: beyond both, with a full and a
# padded last segment, odd and even rows. Tensions are not cut.
LONG = (
    Structure(10, "free", terms=ENDS),
    Structure(20, "clamped", terms=ALONG),
    Structure(51, "pinned", terms=("external_damping", "tip_load")),
    Structure(50, "free", "lumped", ENDS),
)
PALETTE = (*SMALL, *LONG)
# A rod of one of these structures, for tests of pictures and of the live view.
ROD: dict[str, Any] = {
    "name": "dart",
    "rod": {"links": 5, "length": 2.0, "bending_stiffness": 5.0, "mass": 3.0},
    "loads": {
        "follower": {"force": 2.0},
        "gravity": {"g": 9.81},
        "internal_damping": {"coefficient": 0.0},
        "external_damping": {"coefficient": 0.0},
    },
    "initial": {"phi": "0.2*cos(pi*s)"},
    "integrate": {"span": [0.0, 5.0], "output_every": 0.01, "method": "dop853"},
}
# Several loads of one kind, each at a point of its own (a joint, a point inside a link, the tail);
# one with what it may have beside.
PLACED = Structure(
    4,
    "clamped",
    terms=(
        *("follower@1+1/4", "follower", "follower@2", "distributed_follower@angle"),
        *("moment@1+1/4", "moment", "moment@0", "gravity@acceleration"),
    ),
)
# What the rod runs against, with and without all that it may have: several at one point, at the
# tail and within a link; in the first joint with a spring and in another; walls that end.
TOUCHING = (
    *("joint_friction@moment_per_length", "gravity"),
    *("stop@1+1/4+exponent+damping", "stop", "stop@2", "stop@2+damping"),
    *("joint_stop@2+damping", "joint_stop@3+exponent"),
    *("wall@edge+damping+friction", "wall", "wall@edge"),
)
# What the air pushes, with and without wind, and where that and the density follow the height: at
# joints, within links, and at the tail.
AIRBORNE = (
    *("fins@1+1/4+wind", "fins@density_by_height+wind_by_height", "fins@2"),
    *("nose@0+1/3+density_by_height", "nose@wind", "axial_drag@wind+density_by_height"),
    *("axial_drag@3", "axial_drag@1+1/2+wind_by_height"),
)
AIR_LAWS = (
    ("fins_2_density", "air_density_1 * exp(-y(1.0)/air_density_2)"),
    ("fins_2_wind_x", "air_wind_x_1 * sin(t) * y(1.0)"),
    ("fins_2_wind_y", "interp(y(1.0), [low, high], [still, windy])"),
    ("nose_density", "air_density_1 * exp(-y(0.1)/air_density_2)"),
    ("axial_drag_density", "air_density_1 * exp(-y(1.0)/air_density_2)"),
    ("axial_drag_3_wind_x", "air_wind_x_1 * sin(t) * y(0.375)"),
    ("axial_drag_3_wind_y", "interp(y(0.375), [low, high], [still, windy])"),
    ("air_wind_x", "air_wind_x_1 * sin(t)"),
)
TIMED = Structure(
    4,
    "clamped",
    terms=ENDS,
    expressions=(
        ("follower_force", "300*min(t/0.5, 1, 2 - t) + tan(t)**2"),
        ("tip_force_x", "-1.5*sin(t)**2 if t <= 0.7 else max(t, 0.5)**-1.5"),
        ("tip_force_y", "exp(-t)*log(2 + t)/sqrt(1 + t) + tanh(t)*abs(cos(5*t)) - pi"),
    ),
)
# Every sensor at a joint, inside a link and at the tail, all kinds of functions, tables, a time,
# numbers that have names, states that follow each other, and a load that follows one alone.
LAWS = (
    (
        "follower_force",
        "P0 * (1 + tanh(vx(0.6)) * x(0.3)) + interp(y(1), [k1, k2, k3], [v1, v2, v3])"
        " + interp(y(1) + t, shape, 'cubic')",
    ),
    ("follower_angle", "max(-c, min(c, gimbal, 2.0), sin(omega(0.3)) - deg(40 * abs(phi(0))))"),
    (
        "tip_force_y",
        "filtered ** 2 * exp(-t) if vy(0.55) < b else cos(filtered) / (1 + phi(1) ** 2)",
    ),
)
STATES = (
    ("gimbal", "(-c * phi(0.3) - b * omega(0.3) - gimbal) / (b + t) + x(0) - log(1 + gimbal ** 2)"),
    (
        "filtered",
        "interp(gimbal, [k1, k2, k3], [v1, v2, v3], 'cubic') - y(0.25) * vx(1)"
        " - sqrt(2 + filtered**2) + tan(0.1 * vy(0.8)) + interp(3 * gimbal, shape)",
    ),
)
TABLES = (("shape", 7),)
# Those whose whole text is looked at: pairs and numbers, cut into segments and not, on the stack
# and not, with all loads, some and none.
TEXTS = (SMALL[0], SMALL[3], SMALL[6], LONG[2], TIMED)

Row = tuple[Any, ...]
NAMED = {ALL: "all", ENDS: "ends", ALONG: "along"}


def short(value: object) -> str:
    """A name for a case: of a structure, of a set of loads, of any other value."""
    if isinstance(value, Structure):
        value = value.stem
        for terms, name in NAMED.items():
            value = value.replace("_".join(terms), name)
        return value
    if isinstance(value, tuple):
        return NAMED.get(value) or "+".join(map(str, value)) or "none"
    return str(value)


def covering(rows: Iterable[Row], strength: int, chosen: Iterable[Row] = ()) -> set[Row]:
    """Extend the chosen rows until every pair of values occurs that occurs in all rows (with
    strength 1 every value, with 3 every triple): the row with most that is new comes next."""
    left = {row: set(combinations(enumerate(row), strength)) for row in rows}
    chosen = set(chosen)
    seen = {part for row in chosen for part in combinations(enumerate(row), strength)}
    left = {row: rest for row, parts in left.items() if (rest := parts - seen)}
    while left:
        best = max(left, key=lambda row: len(left[row]))
        new = left.pop(best)
        chosen.add(best)
        left = {row: rest for row, seen in left.items() if (rest := seen - new)}
    return chosen


def cases(
    names: str, *factors: Iterable[Any], where: Callable[..., bool] = lambda *_: True
) -> pytest.MarkDecorator:
    """Parametrize by the product of factors for which `where` holds: `make test` has every value,
    `make check` every pair of values, and `make check-all` every triple."""
    rows = [row for row in product(*map(tuple, factors)) if where(*row)]
    values = covering(rows, 1)
    pairs = covering(rows, 2, values)
    triples = covering(rows, 3, pairs)
    marks = {
        row: () if row in values else pytest.mark.slow if row in pairs else pytest.mark.nightly
        for row in triples
    }
    params = [
        pytest.param(*row, marks=marks[row], id="-".join(map(short, row)))
        for row in rows
        if row in marks
    ]
    return pytest.mark.parametrize(names, params)


def can_move(boundary: str, links: int, *_: object) -> bool:
    """Whether one of so many links moves under a boundary."""
    return links >= BOUNDARIES[boundary].min_links


# What may differ along a rod.
NONUNIFORM = (
    *(("stiffness",), ("mass",), ("bodies",), ("points",), ("stiffness", "bodies")),
    *(("rest",), ("stiffness", "mass", "rest"), ("stiffness", "mass", "lengths")),
    *(("stiffness", "bodies", "rest", "lengths"), ("stiffness", "points", "lengths")),
)


def carries(boundary: str, links: int, inertia: str, *rest: Any) -> bool:
    """Whether a rod can move and differ so, by the last argument: bodies are fixed to uniform
    links, point masses to the ends of massless ones."""
    apart = {"bodies": "lumped", "points": "uniform"}
    return can_move(boundary, links) and all(apart.get(what) != inertia for what in rest[-1])


def loads_of(terms: tuple[str, ...], nonuniform: tuple[str, ...]) -> tuple[str, ...]:
    """Those loads that a rod which differs so may have: the thesis's damping is of equal links."""
    every = "lengths" not in nonuniform
    return tuple(t for t in terms if every or not any(x.by_mass for x in TERMS[t].parameters))


# With no load and with either half: what NumPy's modules, Jacobians and Newton's cells are tried
# with.
SHORT_RODS = cases(
    "boundary, links, inertia, terms",
    BOUNDARIES,
    (1, 2, 5),
    INERTIAS,
    ((), ENDS, ALONG),
    where=can_move,
)
