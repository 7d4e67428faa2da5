"""Blocks of a study: boxes of its points, each a chunk of every array of the store."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

MARK = "status"  # the array whose chunks mark blocks that are done
CHUNKS = "c"  # the folder of an array in which Zarr has its chunks


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
