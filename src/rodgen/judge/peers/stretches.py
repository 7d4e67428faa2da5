"""The span of a job in the pieces that an integration is made of."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from rodgen.judge.precision.contestant import Array
from rodgen.judge.precision.job import Job

SAME = 1e-12  # of the span: times closer than that are one
EDGE = 1e-12  # by which a time is held inside a stretch [s]: at its ends loads may jump


class Stretch(NamedTuple):
    """Where loads are smooth: from first to last [s]; times: after first, the samples there and
    last; samples: how many of them are samples, all or all but the last."""

    first: float
    last: float
    times: Array
    samples: int

    @property
    def middle(self) -> float:
        """A time at which it is told what loads are in it."""
        return 0.5 * (self.first + self.last)

    def inside(self, t: float) -> float:
        """The time, not beyond the ends, of which the next stretch may have another load."""
        return min(max(t, self.first + EDGE), self.last - EDGE)


def stretches(job: Job) -> list[Stretch]:
    """All of them, with their samples; the start of the job is in none."""
    first, last = job.span
    same, found = SAME * (last - first), []
    for begin, end in job.stretches:
        inner = job.times[(job.times > begin + same) & (job.times < end - same)]
        sampled = bool((np.abs(job.times - end) <= same).any())
        found.append(Stretch(begin, end, np.append(inner, end), len(inner) + sampled))
    return found


def integrated(job: Job, over: Callable[[Stretch, Array], Array]) -> Array:
    """States at the samples (samples, states); over: from a stretch and the state at its start
    to the states at its times."""
    y, rows = job.start, [job.start[None]]
    for stretch in stretches(job):
        states = over(stretch, y)
        if len(states) != len(stretch.times):
            raise ArithmeticError(f"ended after {len(states)} of {len(stretch.times)} samples")
        rows.append(states[: stretch.samples])
        y = np.array(states[-1])
    return np.concatenate(rows)


def runs(stretch: Stretch) -> Iterator[tuple[float, Array]]:
    """Times at equal distances, each with the time before the first: of a stretch that starts or
    ends between two samples, three."""
    gaps = np.diff(stretch.times, prepend=stretch.first)
    cuts = np.flatnonzero(np.abs(np.diff(gaps)) > 1e-9 * gaps.max()) + 1
    before = stretch.first
    for times in np.split(stretch.times, cuts):
        yield before, times
        before = float(times[-1])
