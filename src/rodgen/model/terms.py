"""The terms: loads and damping that a scene may have, and the parameters of each.

A load is a row here and its law in derive/loads/. Of a placed one a scene may have several: the
second and further are called after the first with a number, follower_2, and so are their
parameters, follower_2_force.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from functools import lru_cache

from rodgen.model.fixtures import BODY, FOUNDATION, SHARE, SUPPORT
from rodgen.model.palette import series_pair
from rodgen.model.parameter import JOINTS, LINKS, NOT_NEGATIVE, Parameter
from rodgen.model.rod import CLAMP_ANGLE, NONUNIFORM, ROD, STEADY
from rodgen.model.term import ANCHOR, DAMPER, DRAG, FORCE, SPREAD, WEIGHT, NumberedRows, Term

ROWS = (
    Term(
        name="follower",
        table="follower",
        kind=FORCE,
        label="follower force",
        symbol="P",
        description="thrust along a link, at the tail the last",
        colours=series_pair(2),
        follows=True,
        thesis=True,
        placed=True,
        parameters=(
            Parameter(
                name="follower_force",
                key="force",
                label="follower force",
                symbol="P",
                unit="N",
                description="thrust P at the tail [], compressive for P > 0",
                first=0.0,
                timed=True,
                scales=True,
            ),
            Parameter(
                name="follower_angle",
                key="angle",
                label="follower angle",
                symbol="ν",
                unit="rad",
                description="angle nu between thrust and last link []",
                default=0.0,
                timed=True,
            ),
        ),
    ),
    Term(
        name="gravity",
        table="gravity",
        kind=WEIGHT,
        label="gravity",
        symbol="M g",
        description="weight of every mass",
        colours=series_pair(7),
        thesis=True,
        parameters=(
            Parameter(
                name="gravity",
                key="g",
                label="gravity",
                symbol="g",
                unit="m/s^2",
                description="acceleration g [], downwards",
                default=9.81,
                scales=True,
            ),
        ),
    ),
    Term(
        name="internal_damping",
        table="internal_damping",
        kind=DAMPER,
        label="internal damping",
        description=("viscous moment across inner joints, and twice that in the root of `clamped`"),
        thesis=True,
        parameters=(
            Parameter(
                name="internal_damping",
                key="coefficient",
                label="internal damping",
                symbol="c_int",
                unit="m^2/s",
                description="c_int []",
                rule=NOT_NEGATIVE,
                first=0.01,
                links_power=2,
                by_mass=True,
            ),
        ),
    ),
    Term(
        name="external_damping",
        table="external_damping",
        kind=DRAG,
        label="external damping",
        description="force at the joints, across the rod",
        colours=series_pair(3),
        thesis=True,
        kinked=True,
        parameters=(
            Parameter(
                name="external_damping",
                key="coefficient",
                label="external damping",
                symbol="c_ext",
                unit="1/s",
                description="c_ext []",
                rule=NOT_NEGATIVE,
                first=0.5,
                by_mass=True,
            ),
            Parameter(
                name="fin_factor",
                key="fin_factor",
                label="fin factor",
                symbol="s",
                description="s at every joint, nose to tail",
                rule=NOT_NEGATIVE,
                default=1.0,
                each=JOINTS,
                links_power=1,
            ),
        ),
    ),
    Term(
        name="tip_load",
        table="tip",
        kind=FORCE,
        label="tip load",
        symbol="F",
        description="dead force at the tail: it keeps its direction",
        colours=series_pair(4),
        parameters=(
            Parameter(
                name="tip_force_x",
                key="x",
                label="tip force x",
                unit="N",
                description="x component of the dead force at the tail []",
                default=0.0,
                timed=True,
                scales=True,
            ),
            Parameter(
                name="tip_force_y",
                key="y",
                label="tip force y",
                unit="N",
                description="y component of the dead force at the tail []",
                default=0.0,
                first=-1.0,
                timed=True,
                scales=True,
            ),
        ),
    ),
    Term(
        name="material_damping",
        table="material_damping",
        kind=DAMPER,
        label="material damping",
        description="Kelvin-Voigt moment across every joint with a spring, for any number of links",
        parameters=(
            Parameter(
                name="material_damping_time",
                key="time",
                label="material damping time",
                symbol="τ",
                unit="s",
                description="tau, over which the moment is as large as that of the springs []",
                rule=NOT_NEGATIVE,
                first=0.001,
                decades=True,
            ),
        ),
    ),
    Term(
        name="distributed_follower",
        table="distributed_follower",
        kind=SPREAD,
        label="distributed follower force",
        symbol="Q",
        description="thrust along every link, in its middle",
        colours=series_pair(5),
        follows=True,
        parameters=(
            Parameter(
                name="distributed_follower",
                key="force_per_length",
                label="distributed follower force",
                symbol="q",
                unit="N/m",
                description="thrust per length q [], compressive for q > 0",
                first=0.0,
                timed=True,
                each=LINKS,
                scales=True,
            ),
        ),
    ),
    Term(
        name="foundation",
        table="foundation",
        kind=ANCHOR,
        label="foundation",
        description="springs and dampers all along the rod, across the straight rod",
        colours=series_pair(8),
        given=FOUNDATION,
        parameters=(
            Parameter(
                name="foundation_angle",
                key="angle",
                label="angle of the foundation",
                unit="rad",
                description="of the axis across which it acts []",
                default=0.0,
            ),
            Parameter(
                name="foundation_stiffness",
                key="stiffness",
                label="stiffness of the foundation",
                unit="N/m",
                description="of every joint across the straight rod []",
                rule=NOT_NEGATIVE,
                default=0.0,
                each=JOINTS,
            ),
            Parameter(
                name="foundation_damping",
                key="damping",
                label="damping of the foundation",
                unit="N s/m",
                description="of every joint across the straight rod []",
                rule=NOT_NEGATIVE,
                default=0.0,
                each=JOINTS,
            ),
        ),
    ),
    Term(
        name="supports",
        table="supports",
        kind=ANCHOR,
        label="supports",
        description="springs and dampers from points of the rod to fixed points",
        colours=series_pair(1),
        given=SUPPORT,
        array=True,
        parameters=(
            Parameter(
                name="support_angle",
                key="angle",
                label="angle of the supports",
                unit="rad",
                description="of a link that its support does not turn []",
                default=0.0,
            ),
            *(
                Parameter(
                    name=f"support_{one.name}",
                    key=one.name,
                    label=f"{one.label} of a support",
                    unit=one.unit,
                    description=f"{one.label} of the support of every link []",
                    rule=one.rule,
                    default=0.0,
                    each=LINKS,
                )
                for one in (SHARE, *SUPPORT[1:])
            ),
        ),
    ),
    Term(
        name="drag",
        table="drag",
        kind=DRAG,
        label="drag",
        description="force at the joints against a medium with a wind, by the square of the speed",
        colours=series_pair(6),
        parameters=(
            Parameter(
                name="drag_normal",
                key="normal",
                label="drag across",
                symbol="c_n",
                unit="kg/m^2",
                description="across the rod, over its length and the square of the speed []",
                rule=NOT_NEGATIVE,
                default=0.0,
                first=0.5,
            ),
            Parameter(
                name="drag_tangential",
                key="tangential",
                label="drag along",
                symbol="c_t",
                unit="kg/m^2",
                description="along the rod, likewise []",
                rule=NOT_NEGATIVE,
                default=0.0,
            ),
            Parameter(
                name="wind_x",
                key="wind",
                part=0,
                label="wind, x",
                unit="m/s",
                description="velocity of the medium along x []",
                default=0.0,
                timed=True,
            ),
            Parameter(
                name="wind_y",
                key="wind",
                part=1,
                label="wind, y",
                unit="m/s",
                description="velocity of the medium along y []",
                default=0.0,
                timed=True,
            ),
        ),
    ),
)


@lru_cache(maxsize=1024)  # of the many that a scene may have, which are asked for often
def _numbered_term(name: str, number: int, rest: str) -> Term | None:
    term = next((term for term in ROWS if term.name == name and term.placed), None)
    return None if term is None or rest else term.with_number(number)


# The rows by name, in the order in which names list them.
TERMS: NumberedRows[Term] = NumberedRows({term.name: term for term in ROWS}, _numbered_term)
# What the masses that change with time do, where works and powers are listed by term.
EMPTYING = "emptying"
# What is put in by moving the far end of a spring that pulls the rod by hand.
PULL = "pull"


def describe(name: str) -> str:
    """Words for a term, or for another source of work."""
    return name if name in (EMPTYING, PULL) else TERMS[name].words


THESIS_TERMS = tuple(term.name for term in ROWS if term.thesis)


def _all_parameters() -> tuple[Parameter, ...]:
    """All parameters in the order in which p holds them; those that are many numbers come last."""
    first, later = (
        [one for term in ROWS if term.thesis is thesis for one in term.parameters]
        for thesis in (True, False)
    )
    nonuniform = (one for way in NONUNIFORM.values() for one in way.parameters)
    every = (*ROD, *first, CLAMP_ANGLE, *later, *nonuniform, *STEADY.values())
    return tuple(sorted(every, key=lambda one: one.is_array))


@lru_cache(maxsize=4096)
def _parameter(name: str, number: int, rest: str) -> Parameter | None:
    term = _numbered_term(name, number, "")
    rows = term.parameters if term else ()
    return next((one for one in rows if one.name == f"{name}_{number}_{rest}"), None)


def load_places(terms: Iterable[str]) -> dict[str, str]:
    """Names of the loads of a structure, each with its place: "" at the tail, else a link by its
    number, and the share of it before the point where that is not its start: 6+1/10."""
    counts: Counter[str] = Counter()
    found = {}
    for text in terms:
        kind, _, place = text.partition("@")
        counts[kind] += 1
        found[kind if counts[kind] == 1 else f"{kind}_{counts[kind]}"] = place
    return found


PARAMETERS: NumberedRows[Parameter] = NumberedRows(
    {one.name: one for one in _all_parameters()}, _parameter
)
# Where a scene has a parameter of its module: the keys of tables, from the outermost in.
PLACES: dict[str, tuple[str, ...]] = {
    **{one.name: ("rod", one.key) for one in (*ROD, CLAMP_ANGLE)},
    **{
        one.name: ("loads", term.table, *one.key_path)
        for term in ROWS
        if term.is_load
        for one in term.parameters
    },
}


# What a scene fixes to a rod: the rows of its tables, and what one of several is called.
FIXTURES: dict[str, tuple[tuple[Parameter, ...], str]] = {
    "bodies": (BODY, "body"),
    "foundation": (FOUNDATION, ""),
    "supports": (SUPPORT, "support"),
}


def axis_label(key: str) -> str:
    """Axis label of a number of a scene, such as follower force [N] of loads.follower.force; the
    key itself where it is no parameter of a rod, of a load or of what is fixed to the rod."""
    one, of = _find_row(key)
    if one is None:
        return key
    return f"{one.label}{of} [{one.display_unit}]" if one.unit else f"{one.label}{of}"


def _find_row(key: str) -> tuple[Parameter | None, str]:
    """The row of a number of a scene, and of which of several things it is."""
    for name, path in PLACES.items():
        if ".".join(path) == key:
            return PARAMETERS[name], ""
    table, *keys = key.split(".")
    rows, called = FIXTURES.get(table, ((), ""))
    of = f" of {called} {int(keys.pop(0)) + 1}" if called and keys and keys[0].isdigit() else ""
    return next((one for one in rows if one.key_path == tuple(keys)), None), of
