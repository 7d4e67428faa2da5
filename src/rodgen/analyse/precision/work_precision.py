"""Work-precision sets of a scene: rodgen's methods and SciPy's, beside a reference solution.

The reference is by two families of methods, each of which tells how good the other is: an explicit
method and a symmetric collocation method, or, where steps of the first would be too short, that and
a stiffly stable one. Errors of a method are those against the solution that is not its own.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rodgen.analyse.analysis_guard import PRECISION, check_analysis_memory, check_positive
from rodgen.analyse.precision import method_families
from rodgen.analyse.precision.contestant import (
    Contestant,
    Limits,
    Measurement,
    NotModelledError,
    RunResult,
    attempt,
    empty_row,
    sweep,
    sweep_methods,
)
from rodgen.analyse.precision.job import Errors, Job, Measures
from rodgen.analyse.precision.method_families import contestant, own_family
from rodgen.analyse.precision.rows import (
    find_cheapest,
    format_setting,
    format_short,
    group_rows,
    pareto_front,
    read_number,
)
from rodgen.arrays import Array
from rodgen.display import Plottable
from rodgen.errors import AnalysisError
from rodgen.integrate.jumps import may_have_blows
from rodgen.integrate.stability import LIMITS, dominant, step_limit
from rodgen.model.methods import ADAPTIVE, FIXED_STEP
from rodgen.progress import format_duration
from rodgen.result import Result, ResultTable, Row, omit_from_tables
from rodgen.scene import Scene
from rodgen.scene.term_texts import check_choice
from rodgen.system import System

if TYPE_CHECKING:
    from pandas import DataFrame

FAMILIES = ("dop853", "gauss", "radau")  # the first two that come to an end in time
RUNGS = (1e-7, 1e-9, 1e-11, 1e-13)  # tolerances, one after the other while there is time
GROWTH = 2.5  # by which a run may take longer than the one before it
SECONDS = 40.0  # of everything but making the module
SHARE = 0.25  # of them for the reference
SCIPY = ("rk45", "dop853", "radau", "bdf", "lsoda")


@dataclass(frozen=True)
class Reference:
    """Reference solution. states: (samples, states) by `method`; other: those by the method that
    checks it; off: their difference over time [rad] (samples,); estimate: of all measures; order,
    tolerance, nfev: how the first was found."""

    states: Array
    other: Array
    off: Array
    estimate: Errors
    method: str = ""
    checked_by: str = ""
    order: float = 0.0
    tolerance: float = 0.0
    nfev: int = 0

    def measures(self, job: Job, method: str) -> Measures:
        """Measures of a method against the solution that is not its own, whoever it is by."""
        return Measures(job, self.other if method.lower() == self.method else self.states)


def compute_reference(job: Job, seconds: float) -> Reference:
    """Find two solutions and their difference, in about so many seconds.

    Raises BuildError without a C compiler, AnalysisError where a family has no solution in time.
    """
    _ = job.model  # the seconds begin when it is made
    end, why = time.perf_counter() + seconds, ""
    found: list[tuple[Contestant, RunResult]] = []
    for method in FAMILIES:
        share = (end - time.perf_counter()) / (2 - len(found))
        try:
            found.append(_run_tightest(job, method, share))
        except AnalysisError as error:
            why = str(error)
        if len(found) == 2:
            break
    else:
        raise AnalysisError(f"no reference solution: {why}")
    (best, solved), (check, other) = found
    measures = Measures(job, solved.y)
    return Reference(
        solved.y,
        other.y,
        measures.angle_errors(other.y),
        measures.errors(other.y),
        best.method,
        f"{check.method}, rtol {check.setting:g}",
        best.order or 0.0,
        best.setting,
        solved.counts["nfev"],
    )


def _run_tightest(job: Job, method: str, seconds: float) -> tuple[Contestant, RunResult]:
    """Run a method at ever tighter tolerances, while there is time. Raises AnalysisError where no
    run came to an end."""
    end = time.perf_counter() + seconds
    found, why, expected = None, "", 0.0
    for rtol in RUNGS:
        left = end - time.perf_counter()
        if found is not None and expected > left:
            break
        who = contestant(job, method, "c", rtol=rtol)
        tried = attempt(who, Limits(left, left))
        if tried.finish is None:
            why = why or tried.failed
            if tried.slow:
                break
            continue
        found, expected = (who, tried.finish), GROWTH * tried.seconds
    if found is None:
        raise AnalysisError(f"{method}: {why}")
    return found


ASKED = (1e-3, 1e-6, 1e-9)  # errors of which a table tells the costs, rad or m
# By the name that is asked for: the measure of errors, its unit, and what it is of.
HELD_BY = {
    "end": ("error_phi", "rad", "the angles at the end"),
    "angles": ("error_angles", "rad", "the angles over time"),
    "rates": ("error_rates", "rad/s", "the rates over time"),
    "tail": ("error_tail", "m", "the tail over time"),
}


def _front_column(name: str) -> Callable[[WorkPrecision], list[Any]]:
    """Column of a table with this entry of the settings on the front."""
    return lambda found: [row[name] for row in found.front()]


@dataclass(frozen=True, eq=False, repr=False)
class WorkPrecision(Result, Plottable):
    """Errors and run times of methods and settings on a scene.

    scene: the scene; rows: one for each setting, loose to tight by method, with `who`, `method`,
    `kind` ("step" or "rtol") and `setting`, `seconds`, `error_phi` [rad],
    `error_angles` [rad], `error_rates` [rad/s], `error_tail` [m], `error_modes` [rad],
    `error_energy`, counts, and `failed`, why a setting came to nothing;
    reference: method, order and tolerance of the reference solution, and the method that checks it;
    trusted: error of the reference in every measure, in its unit [rad, rad/s or m], below
    which errors mean nothing;
    limits: largest stable step of every explicit method at the start of the scene [s], 0 if no step
    is stable, infinite if any is; measure: of errors, that `front` and `cheapest` take if they are
    given none: `error_phi`, or `error_tail` for a rod that does not turn.

    Examples
    --------
    >>> import rodgen
    >>> found = rodgen.work_precision(rodgen.Scene.example("missile"), seconds=2.0)
    >>> found.measure, "dop853" in {row["method"] for row in found.rows}
    ('error_phi', True)
    >>> found.front()[-1]["error_phi"] < 1e-6, found.cheapest(1e-3)["seconds"] < 1
    (True, True)
    >>> len(found.table) == len(found.to_dict()["rows"]) == len(found.rows)
    True
    """

    scene: Scene
    rows: list[Measurement]
    reference: dict[str, Any]
    trusted: dict[str, float | None]
    limits: dict[str, float]
    measure: str = "error_phi"

    ROWS = (
        Row("name", "scene", of=lambda found: found.scene.name),
        Row("links", "links", of=lambda found: found.scene.rod.links),
        Row("measure", "errors"),
        Row("reference", "reference", text=lambda found: found._reference_text),
        Row("trusted", "errors of the reference", text=omit_from_tables),
        Row("limits", "largest stable steps", "s", text=omit_from_tables),
        Row(
            "method",
            "method",
            along="setting",
            of=lambda found: [f"{row['who']} {row['method']}" for row in found.front()],
        ),
        Row(
            "setting", "step or tolerance", format="g", along="setting", of=_front_column("setting")
        ),
        Row("seconds", "run time", "s", ".3g", along="setting", of=_front_column("seconds")),
        Row(
            "error",
            "error",
            "{unit}",
            ".2e",
            along="setting",
            of=lambda found: [row[found.measure] for row in found.front()],
        ),
        Row("rows", "all settings", text=omit_from_tables),
    )

    @property
    def unit(self) -> str:
        """Unit of the errors by which methods are compared."""
        return self._measure_info[1]

    @property
    def _measure_info(self) -> tuple[str, str, str]:
        """Measure of errors by which methods are compared, its unit, and what it is of."""
        return next(one for one in HELD_BY.values() if one[0] == self.measure)

    @property
    def _reference_text(self) -> str:
        made, good = self.reference, self.trusted[self.measure] or 0.0
        method = f"{made['method']}, order {made['order']}, checked by {made['checked_by']}"
        return f"{method}; good to {good:.1e} {self.unit}"

    def tables(self) -> list[ResultTable]:
        """Tables of the reference and of the methods, a line for each: its cheapest settings for
        some errors, its least error and its largest stable step."""
        of = {"errors of": self._measure_info[2], "reference": self._reference_text}
        titles = (f"{format_short(error, '.0e')} {self.unit}" for error in ASKED)
        heads = "method", *titles, "least error", "stable up to"
        groups = group_rows(self.rows, lambda row: f"{row['who']}\0{row['method']}").items()
        lines = (self._line(name, some) for name, some in groups)
        return [ResultTable.of_values(of), ResultTable.of_rows(heads, lines)]

    def _line(self, name: str, rows: list[Measurement]) -> Iterator[str]:
        who, method = name.split("\0")
        own = who == "rodgen"
        yield method if own else f"{who} {method}"
        for error in ASKED:
            row = self.cheapest(error, who=who, method=method)
            yield (
                f"{format_duration(read_number(row, 'seconds'))}, {format_setting(row)}"
                if row
                else "-"
            )
        errors = (error for row in rows if (error := read_number(row, self.measure)) >= 0)
        least = min(errors, default=math.inf)
        yield f"{least:.1e} {self.unit}" if least < math.inf else "-"
        limit = self.limits.get(method, math.inf) if own else math.inf
        yield f"{limit:.3g} s" if 0 < limit < math.inf else "none" if limit == 0 else "-"

    def __repr__(self) -> str:
        methods = len({(row["who"], row["method"]) for row in self.rows})
        return f"<WorkPrecision of {self.scene.name}: {methods} methods, {len(self.rows)} settings>"

    @property
    def table(self) -> DataFrame:
        """The rows as a table of pandas."""
        from pandas import DataFrame

        return DataFrame(self.rows)

    def front(self, measure: str | None = None) -> list[Measurement]:
        """Rows than which none is both faster and closer (the Pareto front), by rising seconds.

        measure: of errors, by default that of the result.
        """
        measure = measure or self.measure
        return pareto_front(self.rows, measure, self.trusted[measure] or 0.0)

    def cheapest(self, error: float, measure: str | None = None, **of: str) -> Measurement | None:
        """The fastest row within an error; None if there is none.

        error: the largest that is allowed, in SI units; measure: of errors, by default that of the
        result; of: entries that the row must have, such as method="rk4".
        """
        rows = (row for row in self.rows if all(row[key] == value for key, value in of.items()))
        return find_cheapest(rows, error, measure or self.measure)


def work_precision(
    system: System | Scene,
    *,
    seconds: float = SECONDS,
    of: str | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> WorkPrecision:
    """Measure errors against run time, of rodgen's methods in C and SciPy's on the same rates.

    Errors are differences from a solution by another family of methods at its tightest tolerance. A
    third family tells how good this reference is. Events of the scene are left out.

    Parameters
    ----------
    system
        The scene, or a System.
    seconds
        About how long the measurement takes [s], shared by all methods. Making the module comes on
        top.
    of
        Errors that methods are held by: "end" (angles at the end), "angles" or "rates" (over time),
        "tail" (its place over time). By default "end", of a rod that does not turn "tail".
    progress
        A function that is called with the method that is tried.

    Returns
    -------
    WorkPrecision
        A row for every method and setting: seconds, errors, counts.

    Raises
    ------
    InputError
        For ``seconds`` that are not positive.
    BuildError
        Without a C compiler.
    AnalysisError
        If no reference is found in this time.

    Examples
    --------
    >>> import rodgen
    >>> found = rodgen.work_precision(rodgen.Scene.example("missile"), seconds=2.0)
    >>> {"method", "seconds", "error_phi"} <= set(found.rows[0])
    True
    """
    system = System.of(system)
    check_analysis_memory(PRECISION, system)
    scene = system.scene
    check_positive(seconds, "seconds", "a positive number of seconds")
    if of is not None:
        check_choice("of", of, HELD_BY)
    job = Job.of(scene.name, scene)
    progress("reference")
    found = compute_reference(job, SHARE * seconds)
    own = (*FIXED_STEP, *ADAPTIVE)
    share = (1 - SHARE) * seconds / (len(own) + len(SCIPY))
    limits = Limits(share / 2, share)
    rows: list[Measurement] = []
    known: Measurement = {"scene": scene.name, "n": scene.rod.links, "family": ""}
    for method in own:
        progress(method)
        who: Measurement = {"who": "rodgen", "method": method, "target": "c"}
        family = own_family(job, method, "c", quick=False)
        rows += sweep(family, known | who, found.measures(job, method), limits)
    for name in SCIPY:
        progress(f"SciPy {name}")
        rows += _sweep_scipy(job, name, known, found.measures(job, name), limits)
    made = {"method": found.method, "order": found.order, "tolerance": found.tolerance}
    made |= {"checked_by": found.checked_by}
    measure = Measures(job, found.states).default_measure if of is None else HELD_BY[of][0]
    fastest = dominant(job.model, job.span[0], job.initial_state, job.p)
    steps = {name: step_limit(name, fastest.value, fastest.partner) for name in LIMITS}
    return WorkPrecision(scene, rows, made, dict(found.estimate), steps, measure)


def _sweep_scipy(
    job: Job, name: str, known: Measurement, measures: Measures, limits: Limits
) -> list[Measurement]:
    nothing: Measurement = {"who": "SciPy", "method": name, "target": ""}
    try:
        if may_have_blows(job.model):
            raise NotModelledError("a base whose velocity jumps")
        made = getattr(method_families, name)(job, False)
    except NotModelledError as error:
        return [empty_row(known | nothing) | {"failed": str(error)}]
    return sweep_methods(made, known | nothing, measures, limits)
