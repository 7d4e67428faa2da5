"""Tasks of workers: the points of a block are computed and written whole, then it is marked.

A point that fails raises no exception; computing needs no Dask and no files.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from time import perf_counter, process_time
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.solution import RunError
from rodgen.integrate.stepper import FAILED, NO_RESULT
from rodgen.result import collect_doubts
from rodgen.studies import point_runs
from rodgen.studies.analysis_results import analyse, kept_value
from rodgen.studies.kept_quantities import RUN, analysis_rows, variables
from rodgen.studies.point_arrays import PointArrays
from rodgen.studies.sampling import MARK, Point, points_at
from rodgen.studies.store import StudyStore
from rodgen.studies.time_limit import TimeLimitExceeded, time_limit

if TYPE_CHECKING:
    from rodgen.studies.study import Study

Arrays = Mapping[str, NDArray[Any]]
Work = int | list[int]  # a block by its number, or points by theirs
ENOUGH = 0.05  # seconds that are long enough to time points
LONG = 0.5  # seconds of a point, up to which it is timed together with others
SEVERAL = 32  # points side by side
MOST_SHARED = 20  # processes on a processor: a smaller share means waiting, which the clock tells
PATIENT = 20.0  # seconds after which what is timed is not timed again


def compute_points(study: Study, indices: Sequence[int]) -> Arrays:
    """Compute points; returns arrays by the names of the variables. A point that raises an
    unexpected exception is recorded as failed, and the others are computed without it."""
    given = points_at(study, indices)
    # The bits of a sum depend on how many threads take part in it.
    with threadpool_limits(1):
        try:
            with collect_doubts():  # doubts are counted
                return evaluate(study, given)
        except Exception as error:  # of a function of the user's, or of a library under it
            if len(indices) == 1:
                return failure_arrays(study, f"{type(error).__name__}: {error}")
    half = len(indices) // 2
    return concatenate(
        [compute_points(study, indices[:half]), compute_points(study, indices[half:])]
    )


def compute_work(
    store: StudyStore, work: Work, compute: Callable[[Study, Sequence[int]], Arrays]
) -> tuple[int, int] | tuple[list[int], Arrays]:
    """Compute a block, as `compute_block` does; or points, which are returned with their results
    and not written."""
    if isinstance(work, int):
        return compute_block(store, work, compute)
    return work, compute(store.study, work)


def compute_block(
    store: StudyStore, block: int, compute: Callable[[Study, Sequence[int]], Arrays]
) -> tuple[int, int]:
    """Compute a block of a store, write it and mark it, unless it is marked. Returns its number,
    and how many of its points failed."""
    if store.is_done(block):
        return block, 0
    indices = store.layout.indices(block)
    arrays = compute(store.study, indices)
    store.write_block(block, points_at(store.study, indices), arrays)
    return block, int(np.isin(arrays[MARK], NO_RESULT).sum())


def failure_arrays(study: Study, why: str) -> Arrays:
    """Return the arrays of one point that failed, with the reason as its message."""
    made = PointArrays(variables(study), 1)
    made.fail(0, " ".join(why.split()))
    made.arrays["seconds"][:] = np.nan
    return made.arrays


def concatenate(pieces: Sequence[Arrays]) -> Arrays:
    """Concatenate the arrays of several pieces."""
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


def time_point(study: Study) -> float:
    """Measure the time of a point [s]: of a processor, which other processes may share, or by the
    clock where it waits or computes elsewhere. As many points are computed as can be timed, from
    the middle of the study on. A single one only tells whether points take long, as many side by
    side take less each."""
    count, each = study.count, 1
    seconds = _time_points(study, 1)
    if LONG <= seconds <= PATIENT:
        seconds = min(seconds, _time_points(study, 1))  # the first may have been warming up
    while each < count and seconds < (LONG if each == 1 else ENOUGH):
        each = min(SEVERAL if each == 1 else 4 * each, count)
        seconds = _time_points(study, each)
    return seconds / each


def _time_points(study: Study, each: int) -> float:
    first = min(study.count // 2, study.count - each)
    clock, own = perf_counter(), process_time()
    compute_points(study, range(first, first + each))
    clock, own = perf_counter() - clock, process_time() - own
    return own if own > clock / MOST_SHARED else clock


def evaluate(study: Study, points: list[Point]) -> dict[str, NDArray[Any]]:
    """Compute what a study keeps of some of its points: arrays by the names of variables, whose
    first axis is the points.

    points: values by varied names. A point that cannot be built or computed has status "failed",
    its reason as message, and fill values. But for `seconds`, the results of a point do not depend
    on the others, their number or order, to the bit. Raises InputError for a quantity that cannot
    be kept.
    """
    made = PointArrays(variables(study), len(points))
    with np.errstate(all="ignore"):
        (point_runs.compute if study.analysis == RUN else _analyse_points)(study, points, made)
    return made.arrays


def _analyse_points(study: Study, points: list[Point], made: PointArrays) -> None:
    """Analyse every point, and fill in its results."""
    asked = analysis_rows(study)
    count = max((one.count for one in asked), default=0)
    for at, point in enumerate(points):
        start = time.process_time()
        try:
            system = study.system_at(point)
            with time_limit(study.time_limit, system):
                result = analyse(study.analysis, system, study.options, count)
            values = {one.text: kept_value(one.row, result, one.count) for one in asked}
            made.set_point(at, values, np.nan, "", len(result.doubts))
        except (InputError, AnalysisError, RunError) as error:
            made.fail(at, str(error), getattr(error, "status", FAILED))
        except TimeLimitExceeded:
            made.time_out(at, study.time_limit)
        made.arrays["seconds"][at] = time.process_time() - start
