"""Kept quantities of a study: the texts of `keep`, parsed and checked, and their variables.

Of a run: reductions of `rodgen.integrate.reductions`, count('EVENT'), section(tip_y, where='tip_x',
rising=0), peak(tip_y), and functions of a Solution. Of an analysis: what it finds, by name, with
how many of several, such as frequencies(4).
"""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from rodgen.errors import InputError, did_you_mean
from rodgen.integrate.module_facts import ModuleFacts, facts_of
from rodgen.integrate.reductions import REDUCTIONS, Numbers, parse, patterns_of
from rodgen.loading import build_fastest
from rodgen.model.quantities import ADDED, LOADS, QUANTITIES, parse_number, watchable_names
from rodgen.model.terms import PARAMETERS
from rodgen.result import Row
from rodgen.scene import Scene
from rodgen.scene.contact_terms import event_names
from rodgen.studies.analysis_results import function_of, rows_of, unit_in
from rodgen.studies.measures import (
    EVERY,
    MOST_POINTS,
    CrossingSection,
    EventCount,
    RunMeasure,
    SampleReduction,
    SpectralPeak,
    UserFunction,
)
from rodgen.studies.point_arrays import ALWAYS, METHOD, StudyVariable
from rodgen.studies.sampling import reference_point
from rodgen.studies.specification import Specification
from rodgen.system import System

RUN = "run"
PARTS = ("rhs", "flow", "power", "lanes")  # of a module, that runs ask for
LIMIT = 10**6  # largest `max_points` of a section
SUMMED = "total_work", "energy_balance"  # beside the work of each load

_CALL = re.compile(r"\s*(\w+)\s*(?:\((.*)\))?\s*", re.DOTALL)
_PART = re.compile(r"""\s*(?:(\w+)\s*=\s*)?('[^']*'|"[^"]*"|[^,'"=()]+?)\s*(?:,|$)""")
_OF_A_RUN = (
    f"a reduction of a run: {', '.join(REDUCTIONS)} of a number of a quantity, such as max(phi_0) "
    "or rms(tip_y, from=5), count('name of an event'), section(tip_y, where='tip_x', rising=0) or "
    "peak(tip_y)"
)


def variables(study: Specification) -> list[StudyVariable]:
    """Return the variables that the points of a study fill, known before any is computed. Raises
    InputError for what cannot be kept, and where the scene refuses all points that are tried."""
    made = [*quantity_variables(study), *([METHOD] if study.analysis == RUN else []), *ALWAYS]
    names = [variable.name for variable in made]
    for at, name in enumerate(names):
        if name in names[:at]:
            raise InputError("compute.keep", name, "each thing once")
    return made


def quantity_variables(study: Specification) -> list[StudyVariable]:
    """Return the variables of the quantities in `keep`, without those of every study."""
    if study.analysis == RUN:
        return [variable for one in run_quantities(study) for variable in one.variables]
    return [variable_of(study, one) for one in analysis_rows(study)]


# Of a run -----------------------------------------------------------------------------------------


def run_quantities(study: Specification) -> tuple[RunMeasure, ...]:
    """Return the quantities that are kept of every run. Raises InputError."""
    # Studies are equal whose functions have the same text, though they may hold other values.
    return _run_quantities(study, tuple(id(one) for one in study.keep if callable(one)))


@lru_cache(maxsize=8)
def _run_quantities(study: Specification, functions: tuple[int, ...]) -> tuple[RunMeasure, ...]:
    if study.options:
        raise InputError("compute.options", study.options, f"absent: analysis = {RUN!r} has none")
    if not study.keep:
        raise InputError("compute.keep", [], "what is kept of every run, such as last(tip_x)")
    scene = study.scene_at(reference_point(study))
    facts = facts_of(build_fastest(scene.structure, PARTS))
    made: list[RunMeasure] = []
    for at, text in enumerate(study.keep):
        made.append(_parse_quantity(f"compute.keep[{at}]", text, scene, facts))
    return tuple(_number_sections(made))


def _parse_quantity(place: str, text: Any, scene: Scene, facts: ModuleFacts) -> RunMeasure:
    """Parse one quantity that is kept of a run."""
    if callable(text):
        return UserFunction(getattr(text, "__name__", place).strip("<>"), function=text)
    if not isinstance(text, str):
        raise InputError(place, text, "text, or in Python a function of a Solution")
    numbers = facts.numbers
    reduction = parse(text)
    if reduction is not None:
        units = _unit_of(place, text, reduction.number, numbers)
        units = "s" if reduction.kind == "time_of_max" else units
        return SampleReduction(text, reduction.number, units, reduction=reduction)
    kind, arguments, named = _parse_call(place, text, _OF_A_RUN)
    number = arguments[0] if len(arguments) == 1 else ""
    span = _pop_span(place, text, named)
    if kind == "count" and number and not named:
        names = event_names(scene.watched_events)
        if number not in names:
            allowed = f"of an event of the scene: {', '.join(map(repr, names)) or 'it has none'}"
            raise InputError(place, text, allowed)
        return EventCount(text, event=number, **span)
    if kind == "peak" and number and not named:
        return SpectralPeak(text, number, _unit_of(place, text, number, numbers), **span)
    if kind == "section" and number:
        return _parse_section(place, text, number, named, span, scene, numbers)
    raise InputError(place, text, _OF_A_RUN)


def _parse_section(
    place: str,
    text: str,
    number: str,
    named: dict[str, str],
    span: dict[str, Any],
    scene: Scene,
    numbers: Numbers,
) -> CrossingSection:
    """Make a section from its arguments."""
    units = _unit_of(place, text, number, numbers)
    if number in SUMMED or numbers.places[number][0].startswith("work_"):
        allowed = "a section of what the states tell: work and balance are known at samples alone"
        raise InputError(place, text, allowed)
    where, most = named.pop("where", ""), named.pop("max_points", str(MOST_POINTS))
    known = [
        *watchable_names(scene.boundary_condition, scene.rod.links),
        *((name, range(1)) for name in (*scene.states, *scene.term_numbers)),
    ]
    if not any(parse_number(where, name) in range_ for name, range_ in known):
        shown = ", ".join(name for name, _ in known)
        raise InputError(place, text, f"where = one of {shown}")
    if len(named) != 1 or {*named} - {"rising", "falling", "either"}:
        raise InputError(place, text, "with one of rising=, falling= or either= the level")
    ((direction, level),) = named.items()
    points = _parse_number(place, text, most)
    if not (points.is_integer() and 0 < points <= LIMIT):
        raise InputError(place, text, f"with max_points= a whole number from 1 to {LIMIT}")
    value = _parse_number(place, text, level)
    crossed: dict[str, Any] = {"where": where, "level": value, "direction": direction}
    return CrossingSection(text, number, units, **span, **crossed, max_points=int(points))


def _number_sections(made: Sequence[RunMeasure]) -> list[RunMeasure]:
    """Give sections events of their own, and dimensions of their own where lengths differ."""
    lengths: list[int] = []
    numbered: list[RunMeasure] = []
    for at, one in enumerate(made):
        if isinstance(one, CrossingSection):
            if one.max_points not in lengths:
                lengths.append(one.max_points)
            number = lengths.index(one.max_points)
            dim = f"crossing_{number + 1}" if number else "crossing"
            one = replace(one, event=f"section {at} of the study", dim=dim)
        numbered.append(one)
    return numbered


def _parse_call(place: str, text: str, allowed: str) -> tuple[str, list[str], dict[str, str]]:
    """Split a call into its name, its positional and its named arguments. Raises InputError."""
    whole = _CALL.fullmatch(text)
    if whole is None:
        raise InputError(place, text, allowed)
    arguments, named, at, inside = list[str](), dict[str, str](), 0, whole[2] or ""
    while at < len(inside):
        part = _PART.match(inside, at)
        if part is None or (part[1] in named):
            raise InputError(place, text, allowed)
        value = part[2].strip("'\"") if part[2][0] in "'\"" else part[2]
        if part[1]:
            named[part[1]] = value
        else:
            arguments.append(value)
        at = part.end()
    return whole[1], arguments, named


def _pop_span(place: str, text: str, named: dict[str, str]) -> dict[str, Any]:
    """Take the times `from` and `to` out of the named arguments."""
    start, end = (
        _parse_number(place, text, named.pop(key)) if key in named else value
        for key, value in zip(("from", "to"), EVERY, strict=True)
    )
    if not start <= end:
        raise InputError(place, text, "with times from <= to")
    return {"start": start, "end": end}


def _parse_number(place: str, text: str, value: str) -> float:
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(place, text, f"with a finite number in place of {value!r}")
    return number


def check_numbers(system: System, wanted: Iterable[RunMeasure], facts: ModuleFacts) -> None:
    """Raise InputError for a number that this rod does not have, though another rod of the study
    has it."""
    for number in (one.number for one in wanted if one.number):
        if number not in facts.numbers.places:
            allowed = (
                f"a number of the rod: one of {system.structure.n_links} links has no {number}"
            )
            raise InputError("compute.keep", number, allowed)


def _unit_of(place: str, text: str, number: str, numbers: Numbers) -> str:
    """Return the unit of a number of a quantity. Raises InputError where there is none."""
    if number not in numbers.places:
        known, hint = patterns_of(numbers.places), did_you_mean(number, numbers.places)
        raise InputError(place, text, f"{_OF_A_RUN}; numbers are {known}{hint}")
    name, _ = numbers.places[number]
    if name in PARAMETERS:
        return PARAMETERS[name].unit
    for quantity in QUANTITIES:
        prefix = quantity.name.removesuffix("{}") if quantity.each else quantity.name
        open_ = quantity.each not in ("", LOADS, ADDED) and name.startswith(prefix)
        open_ = open_ and numbers.kinds.get(name, quantity.each) == quantity.each
        if name == quantity.name or open_:
            return quantity.unit
    return "J" if name == "total_work" else ""


# Of an analysis -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class KeptRow:
    """A row of a result that is kept; count: how many of several values."""

    text: str
    row: Row
    count: int = 0


@lru_cache(maxsize=8)
def analysis_rows(study: Specification) -> tuple[KeptRow, ...]:
    """Return the rows that are kept of every point of an analysis. Raises InputError."""
    rows = rows_of(study.analysis)
    _check_options(study)
    texts = study.keep or tuple(name for name, row in rows.items() if row.kept and row.kept.usual)
    return tuple(_parse_row(f"compute.keep[{at}]", text, rows) for at, text in enumerate(texts))


def _parse_row(place: str, text: Any, rows: Mapping[str, Row]) -> KeptRow:
    several = {name: row.kept.several for name, row in rows.items() if row.kept}
    shown = ", ".join(f"{name}(4)" if count else name for name, count in several.items())
    allowed = f"one of {shown}"
    if not isinstance(text, str):
        raise InputError(place, text, allowed)
    name, arguments, named = _parse_call(place, text, allowed)
    row = rows.get(name)
    if row is None or named or len(arguments) > (1 if several[name] else 0):
        raise InputError(place, text, allowed)
    count = _parse_number(place, text, arguments[0]) if arguments else float(several[name])
    if not (count.is_integer() and (0 < count <= 1000 or not several[name])):
        raise InputError(place, text, f"{name}(k) of a whole number k from 1 to 1000")
    return KeptRow(text, row, int(count))


def variable_of(study: Specification, one: KeptRow) -> StudyVariable:
    """Return the variable of a row that is kept."""
    row, kept = one.row, one.row.kept
    assert kept is not None
    load = study.options.get("load")
    units = row.unit.format(unit=unit_in(study.analysis, study.system, load))
    how = kept.dtype, units, kept.fill, row.words
    if not kept.several:
        return StudyVariable(one.text, (), (), *how)
    lengths = list(dict.fromkeys(a.count for a in analysis_rows(study) if a.count))
    number = lengths.index(one.count)
    dim = f"mode_{number + 1}" if number else "mode"
    return StudyVariable(one.text, (dim,), (one.count,), *how)


def _check_options(study: Specification) -> None:
    """Raise InputError for options that the analysis does not have; it checks their values at every
    point itself."""
    allowed = list(inspect.signature(function_of(study.analysis)).parameters)[1:]
    for name in study.options:
        if name not in allowed or name == "count":
            known = ", ".join(one for one in allowed if one != "count")
            raise InputError(f"compute.options.{name}", study.options[name], f"one of {known}")
