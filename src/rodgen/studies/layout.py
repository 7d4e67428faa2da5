"""Blocks of a study: boxes of its points, each a chunk of every array of the store."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

MARK = "status"  # the array whose chunks mark blocks that are done
CHUNKS = "c"  # the folder of an array in which Zarr has its chunks


@dataclass(frozen=True)
class Layout:
    """How points along some dimensions are cut into blocks; shape: points, chunk: those of a block
    that is not cut off at an end."""

    shape: tuple[int, ...]
    chunk: tuple[int, ...]

    @classmethod
    def of(cls, shape: tuple[int, ...], wanted: int) -> Layout:
        """Blocks of about so many points: all along the last dimensions, as far as they go."""
        chunk: list[int] = []
        for count in reversed(shape):
            size = min(count, max(1, wanted))
            size = math.ceil(count / math.ceil(count / size))  # none much smaller than the others
            chunk.insert(0, size)
            wanted //= size
        return cls(shape, tuple(chunk))

    @property
    def grid(self) -> tuple[int, ...]:
        """How many blocks there are along the dimensions."""
        return tuple(math.ceil(n / size) for n, size in zip(self.shape, self.chunk, strict=True))

    @property
    def count(self) -> int:
        """How many blocks there are."""
        return math.prod(self.grid)

    def place(self, block: int) -> tuple[int, ...]:
        """Where a block is among the blocks."""
        return tuple(int(at) for at in np.unravel_index(block, self.grid))

    def box(self, block: int) -> tuple[slice, ...]:
        """The points of a block, as slices along the dimensions."""
        ends = zip(self.place(block), self.chunk, self.shape, strict=True)
        return tuple(slice(at * size, min((at + 1) * size, n)) for at, size, n in ends)

    def indices(self, block: int) -> list[int]:
        """Numbers of the points of a block, the last dimension fastest."""
        along = np.ix_(*(np.arange(s.start, s.stop) for s in self.box(block)))
        found = np.ravel_multi_index(np.broadcast_arrays(*along), self.shape)
        numbers: list[int] = found.ravel().tolist()
        return numbers

    def points(self, block: int) -> int:
        """How many points a block has."""
        return math.prod(s.stop - s.start for s in self.box(block))
