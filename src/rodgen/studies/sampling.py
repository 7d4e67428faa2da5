"""Points of a study from their numbers, the same in whatever block they are computed."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.studies.axis import LATIN, RANDOM, Sample, Value
from rodgen.studies.specification import Specification

Point = dict[str, Value]
BITS = 32  # of the sequence of Sobol: more are not taken forward by SciPy 1.17
MOST_KEPT = 2  # Latin hypercubes and sequences of a process


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
        rows = [_random_row(sample.seed, index, dimensions) for index in indices]
        return np.array(rows).reshape(-1, dimensions)
    if sample.method == LATIN:
        return _hypercube(sample.seed, sample.count, dimensions)[list(indices)]
    return _sobol_rows(_sobol_sequence(sample.seed, dimensions), indices)


def _random_row(seed: int, index: int, dimensions: int) -> NDArray[np.float64]:
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,))).random(
        dimensions
    )


@lru_cache(maxsize=MOST_KEPT)
def _hypercube(seed: int, count: int, dimensions: int) -> NDArray[np.float64]:
    from scipy.stats import qmc

    made: NDArray[np.float64] = qmc.LatinHypercube(
        dimensions, seed=np.random.default_rng(seed)
    ).random(count)
    return made


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
