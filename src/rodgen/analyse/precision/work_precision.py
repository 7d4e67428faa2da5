"""Work-precision sets of a scene: rodgen's methods and SciPy's, beside a reference solution.

The reference is by two families of methods, each of which tells how good the other is: an explicit
method and a symmetric collocation method, or, where steps of the first would be too short, that and
a stiffly stable one. What a method comes to is held against the solution that is not its own.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rodgen.analyse.precision import methods
from rodgen.analyse.precision.contestant import (
    Contestant,
    Finish,
    Limits,
    NotModelledError,
    Row,
    attempt,
    blank,
    in_a_row,
    sweep,
)
from rodgen.analyse.precision.job import Errors, Job, Measures
from rodgen.analyse.precision.methods import contestant, families
from rodgen.analyse.precision.rows import cheapest, front
from rodgen.analyse.sizes import PRECISION, check_size
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.stability import LIMITS, dominant, limit
from rodgen.scene import Scene
from rodgen.shown import Shown
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
    """A reference solution. states: (samples, states) by `method`, other: those by the method that
    it is checked by; off: their difference over time [rad] (samples,); estimate: of all measures;
    order, tolerance, rhs: how the first was found."""

    states: Array
    other: Array
    off: Array
    estimate: Errors
    method: str = ""
    checked_by: str = ""
    order: float = 0.0
    tolerance: float = 0.0
    rhs: int = 0

    def measures(self, job: Job, method: str) -> Measures:
        """Errors of a method against the solution that is not its own, whoever it is by."""
        return Measures(job, self.other if method.lower() == self.method else self.states)


@dataclass(frozen=True)
class Solved:
    """What a method came to at the tightest tolerance that there was time for."""

    who: Contestant
    finish: Finish

    @property
    def words(self) -> str:
        """The method and its tolerance."""
        return f"{self.who.method}, rtol {self.who.setting:g}"


def reference(job: Job, seconds: float) -> Reference:
    """Two solutions and their difference, found in about so many seconds.

    Raises BuildError without a C compiler, AnalysisError where a family has no solution in time.
    """
    _ = job.model  # the seconds begin when it is made
    end, why = time.perf_counter() + seconds, ""
    found: list[Solved] = []
    for method in FAMILIES:
        share = (end - time.perf_counter()) / (2 - len(found))
        try:
            found.append(_tightest(job, method, share))
        except AnalysisError as error:
            why = str(error)
        if len(found) == 2:
            break
    else:
        raise AnalysisError(f"no reference solution: {why}")
    best, check = found
    measures = Measures(job, best.finish.y)
    return Reference(
        best.finish.y,
        check.finish.y,
        measures.over_time(check.finish.y),
        measures.errors(check.finish.y),
        best.who.method,
        check.words,
        best.who.order or 0.0,
        best.who.setting,
        best.finish.counts["rhs"],
    )


def _tightest(job: Job, method: str, seconds: float) -> Solved:
    """A method at one tolerance after the other. Raises AnalysisError where none came to an end."""
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
        found, expected = Solved(who, tried.finish), GROWTH * tried.seconds
    if found is None:
        raise AnalysisError(f"{method}: {why}")
    return found


@dataclass(frozen=True, eq=False, repr=False)
class WorkPrecision(Shown):
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
    rows: list[Row]
    reference: dict[str, Any]
    trusted: dict[str, float | None]
    limits: dict[str, float]
    measure: str = "error_phi"

    def __repr__(self) -> str:
        methods = len({(row["who"], row["method"]) for row in self.rows})
        return f"<WorkPrecision of {self.scene.name}: {methods} methods, {len(self.rows)} settings>"

    @property
    def table(self) -> DataFrame:
        """The rows as a table of pandas."""
        from pandas import DataFrame

        return DataFrame(self.rows)

    def front(self, measure: str | None = None) -> list[Row]:
        """Rows than which none is both faster and closer, by rising seconds.

        measure: of errors, by default that of the result.
        """
        measure = measure or self.measure
        return front(self.rows, measure, self.trusted[measure] or 0.0)

    def cheapest(self, error: float, measure: str | None = None, **of: str) -> Row | None:
        """The fastest row within an error; None if there is none.

        error: the largest that is allowed, in SI units; measure: of errors, by default that of the
        result; of: entries that the row must have, such as method="rk4".
        """
        rows = (row for row in self.rows if all(row[key] == value for key, value in of.items()))
        return cheapest(rows, error, measure or self.measure)

    def to_dict(self) -> dict[str, Any]:
        """All of it for JSON: what is not finite is None."""
        return {
            "scene": self.scene.name,
            "links": self.scene.rod.links,
            "measure": self.measure,
            "reference": self.reference | dict(self.trusted),
            "largest_stable_steps": _finite(self.limits),
            "rows": [_finite(row) for row in self.rows],
        }


def work_precision(
    system: System | Scene,
    *,
    seconds: float = SECONDS,
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
    check_size(PRECISION, system)
    scene = system.scene
    if not 0 < seconds < math.inf:
        raise InputError("seconds", seconds, "a positive number of seconds")
    job = Job.of(scene.name, scene.model_dump(exclude_none=True))
    progress("reference")
    found = reference(job, SHARE * seconds)
    own = families(job, False, {}, numpy=False)
    share = (1 - SHARE) * seconds / (len(own) + len(SCIPY))
    limits = Limits(share / 2, share)
    rows: list[Row] = []
    known: Row = {"scene": scene.name, "n": scene.rod.links, "family": ""}
    for one in own:
        progress(one.method)
        who: Row = {"who": one.who, "method": one.method, "target": one.target}
        rows += sweep(one.make(), known | who, found.measures(job, one.method), limits)
    for name in SCIPY:
        progress(f"SciPy {name}")
        rows += _scipy(job, name, known, found.measures(job, name), limits)
    made = {"method": found.method, "order": found.order, "tolerance": found.tolerance}
    made |= {"checked_by": found.checked_by}
    measure = Measures(job, found.states).main
    return WorkPrecision(scene, rows, made, dict(found.estimate), stable_steps(job), measure)


def _scipy(job: Job, name: str, known: Row, measures: Measures, limits: Limits) -> list[Row]:
    nothing: Row = {"who": "SciPy", "method": name, "target": ""}
    try:
        made = getattr(methods, name)(job, False)
    except NotModelledError as error:
        return [blank(known | nothing) | {"failed": str(error)}]
    return in_a_row(made, known | nothing, measures, limits)


def stable_steps(job: Job) -> dict[str, float]:
    """Largest stable step [s] of every explicit method, for the fastest motion at the start."""
    fastest = dominant(job.model, job.span[0], job.start, job.p)
    return {name: limit(name, fastest.value, fastest.partner) for name in LIMITS}


def _finite(row: dict[str, Any]) -> dict[str, Any]:
    def shown(value: Any) -> Any:
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return {key: shown(value) for key, value in row.items()}
