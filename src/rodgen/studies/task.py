"""What a worker does: a block of points computed, written whole, then marked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter, process_time
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from rodgen.integrate.endings import FAILED, NO_RESULT
from rodgen.result import silent
from rodgen.studies.block import evaluate
from rodgen.studies.keep import variables
from rodgen.studies.layout import MARK
from rodgen.studies.points import points
from rodgen.studies.store import Store, text_or
from rodgen.studies.variable import Variable

if TYPE_CHECKING:
    from rodgen.studies.study import Study

Arrays = Mapping[str, NDArray[Any]]
ENOUGH = 0.05  # seconds that tell how long a point takes
LONG = 0.5  # seconds that one point alone may take to be timed with others
SEVERAL = 32  # points side by side
MOST_SHARED = 20  # processes on a processor: of what takes less of it, the clock tells the time
PATIENT = 20.0  # seconds after which what is timed is not timed again


@dataclass(frozen=True)
class Done:
    """A block that is marked: how many points it has, and how many of them failed."""

    block: int
    points: int
    failed: int


def compute(store: Store, block: int) -> Done:
    """Compute a block of a store, unless it is marked."""
    indices = store.layout.indices(block)
    if store.is_done(block):
        return Done(block, len(indices), 0)
    return keep(store, block, computed(store.study, indices))


def keep(store: Store, block: int, arrays: Arrays) -> Done:
    """Write what came out of the points of a block."""
    indices = store.layout.indices(block)
    store.write(block, points(store.study, indices), arrays)
    return Done(block, len(indices), int(np.isin(arrays[MARK], NO_RESULT).sum()))


def computed(study: Study, indices: Sequence[int]) -> Arrays:
    """What comes out of points, by the names of the variables. A point that raises what nobody
    expects is recorded as failed, and the others are computed without it."""
    given = points(study, indices)
    # The bits of a sum depend on how many threads take part in it.
    with threadpool_limits(1):
        try:
            with silent():  # doubts are counted
                return evaluate(study, given, indices).arrays
        except Exception as error:  # of a function of the user's, or of a library under it
            if len(indices) == 1:
                return failed(study, f"{type(error).__name__}: {error}")
    half = len(indices) // 2
    return joined([computed(study, indices[:half]), computed(study, indices[half:])])


def failed(study: Study, why: str) -> Arrays:
    """What is recorded of a point of which nothing is known but why."""
    arrays = {one.name: _empty(one) for one in variables(study)}
    arrays[MARK][:] = FAILED
    arrays["message"][:] = " ".join(why.split())
    return arrays


def _empty(one: Variable) -> NDArray[Any]:
    return np.full((1, *one.shape), one.fill, text_or(one.dtype))


def joined(pieces: Sequence[Arrays]) -> Arrays:
    """Arrays of several pieces, one after the other."""
    return {
        name: np.concatenate([piece[name].astype(first.dtype) for piece in pieces])
        for name, first in pieces[0].items()
    }


def timed(study: Study) -> float:
    """Time that a point takes of a processor [s], which other processes may share, or by the clock
    where it waits or computes elsewhere; of as many points as take long enough to tell, from the
    middle of the study on. Many side by side take less than each alone, which only tells whether
    it is long."""
    count, each = study.count, 1
    seconds = _seconds(study, 1)
    if LONG <= seconds <= PATIENT:
        seconds = min(seconds, _seconds(study, 1))  # the first may have been warming up
    while each < count and seconds < (LONG if each == 1 else ENOUGH):
        each = min(SEVERAL if each == 1 else 4 * each, count)
        seconds = _seconds(study, each)
    return seconds / each


def _seconds(study: Study, each: int) -> float:
    first = min(study.count // 2, study.count - each)
    clock, own = perf_counter(), process_time()
    computed(study, range(first, first + each))
    clock, own = perf_counter() - clock, process_time() - own
    return own if own > clock / MOST_SHARED else clock
