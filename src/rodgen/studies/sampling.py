"""Points of a study from their numbers, the same in whatever block they are computed; blocks, boxes
of points, each a chunk of every array of the store; and the reference point, from which the
properties common to all points are found.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError
from rodgen.studies.axis import LATIN, RANDOM, Sample, Value
from rodgen.studies.specification import Specification

MARK = "status"  # the array whose chunks mark blocks that are done
CHUNKS = "c"  # the folder of an array in which Zarr has its chunks

Point = dict[str, Value]
BITS = 32  # of the sequence of Sobol: more are not taken forward by SciPy 1.17
MOST_KEPT = 2  # Latin hypercubes and sequences of a process

MOST_TRIED = 1000  # points that are made to find one that the scene takes


@dataclass(frozen=True)
class Layout:
    """Division of the points along some dimensions into blocks. shape: numbers of points; chunk:
    those of a full block."""

    shape: tuple[int, ...]
    chunk: tuple[int, ...]

    @classmethod
    def of(cls, shape: tuple[int, ...], wanted: int) -> Layout:
        """Make blocks of about so many points, whole along as many last dimensions as fit."""
        chunk: list[int] = []
        for count in reversed(shape):
            size = min(count, max(1, wanted))
            size = math.ceil(count / math.ceil(count / size))  # none much smaller than the others
            chunk.insert(0, size)
            wanted //= size
        return cls(shape, tuple(chunk))

    @property
    def grid(self) -> tuple[int, ...]:
        """Number of blocks along each dimension."""
        return tuple(math.ceil(n / size) for n, size in zip(self.shape, self.chunk, strict=True))

    @property
    def count(self) -> int:
        """Number of blocks."""
        return math.prod(self.grid)

    def position(self, block: int) -> tuple[int, ...]:
        """Return the position of a block along each dimension."""
        return tuple(int(at) for at in np.unravel_index(block, self.grid))

    def slices(self, block: int) -> tuple[slice, ...]:
        """Return the points of a block, as slices along the dimensions."""
        ends = zip(self.position(block), self.chunk, self.shape, strict=True)
        return tuple(slice(at * size, min((at + 1) * size, n)) for at, size, n in ends)

    def indices(self, block: int) -> list[int]:
        """Return the numbers of the points of a block, the last dimension fastest."""
        along = np.ix_(*(np.arange(s.start, s.stop) for s in self.slices(block)))
        found = np.ravel_multi_index(np.broadcast_arrays(*along), self.shape)
        numbers: list[int] = found.ravel().tolist()
        return numbers

    def size(self, block: int) -> int:
        """Return the number of points of a block."""
        return math.prod(s.stop - s.start for s in self.slices(block))


def points_at(study: Specification, indices: Sequence[int]) -> list[Point]:
    """Return the points of these numbers, each the values of the varied keys in the order of axes.

    A grid is counted with its last axis fastest. Raises IndexError for a number that the study does
    not have.
    """
    for index in indices:
        if not 0 <= index < study.count:
            raise IndexError(f"point {index} of a study of {study.count}")
    if study.sample is None:
        return [_grid_point(study, index) for index in indices]
    shares = _draw_shares(study.sample, len(study.axes), indices)
    return [
        {axis.name: axis.value_at(share) for axis, share in zip(study.axes, row, strict=True)}
        for row in shares.tolist()
    ]


def _grid_point(study: Specification, index: int) -> Point:
    at = []
    for axis in reversed(study.axes):
        index, place = divmod(index, len(axis.values))
        at.append(place)
    return {a.name: a.values[k] for a, k in zip(study.axes, reversed(at), strict=True)}


def _draw_shares(sample: Sample, dimensions: int, indices: Sequence[int]) -> NDArray[np.float64]:
    """Draw numbers from 0 to below 1, (points, dimensions)."""
    if sample.method == RANDOM:
        seeds = (np.random.SeedSequence(sample.seed, spawn_key=(index,)) for index in indices)
        rows = [np.random.default_rng(seed).random(dimensions) for seed in seeds]
        return np.array(rows).reshape(-1, dimensions)
    if sample.method == LATIN:
        return _hypercube(sample.seed, sample.count, dimensions)[list(indices)]
    return _sobol_rows(_sobol_sequence(sample.seed, dimensions), indices)


@lru_cache(maxsize=MOST_KEPT)
def _hypercube(seed: int, count: int, dimensions: int) -> NDArray[np.float64]:
    from scipy.stats import qmc

    drawn = qmc.LatinHypercube(dimensions, seed=np.random.default_rng(seed))
    return np.asarray(drawn.random(count))


@lru_cache(maxsize=MOST_KEPT)
def _sobol_sequence(seed: int, dimensions: int) -> Any:
    from scipy.stats import qmc

    return qmc.Sobol(dimensions, bits=BITS, scramble=True, seed=np.random.default_rng(seed))


def _sobol_rows(sequence: Any, indices: Sequence[int]) -> NDArray[np.float64]:
    """Return rows of a sequence, which goes on from where it is: blocks follow each other."""
    first, beyond = min(indices, default=0), max(indices, default=-1) + 1
    if first < sequence.num_generated:
        sequence.reset()
    if first > sequence.num_generated:
        sequence.fast_forward(first - sequence.num_generated)
    with warnings.catch_warnings():
        # SciPy asks for a power of two; how many there are is the user's choice.
        warnings.simplefilter("ignore", UserWarning)
        rows = np.asarray(sequence.random(beyond - first), dtype=float)
    return rows[[index - first for index in indices]]


@lru_cache(maxsize=8)
def _reference_index(study: Specification) -> int:
    refused: InputError | None = None
    for index in _candidates(study.count):
        try:
            study.system_at(points_at(study, [index])[0])
        except InputError as error:
            refused = refused or error
        else:
            return index
    assert refused is not None
    raise refused


def reference_point(study: Specification) -> Point:
    """Return the first point that the scene accepts, of both ends, the middle and up to a thousand
    others. Raises InputError where it refuses them all."""
    return points_at(study, [_reference_index(study)])[0]


def _candidates(count: int) -> Iterator[int]:
    yield from (0, count - 1, count // 2)
    tried = min(count, MOST_TRIED)
    yield from (at * count // tried for at in range(tried))
