"""Where the tail and the centre of gravity have been, for a page."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from types import ModuleType

import numpy as np

from rodgen.integrate.stepper import Array
from rodgen.view.live.chunk import Chunk
from rodgen.view.live.store import Store

MOST = 300  # samples that wait for a message: it shows no more of the time from picture to picture
KEPT = 2000  # samples that a page is told of when it comes


class Trail:
    """Samples that a page has not been told of. `anew`: it is told of all that are kept, not of
    these alone. To be used from one thread at a time."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """What the page has is of no use."""
        self._waiting: list[Chunk] = []
        self.anew = True

    def follow(self, chunk: Chunk) -> None:
        """Samples have come; of too many, every other one is let go."""
        self._waiting.append(chunk.some(slice(None, None, max(1, len(chunk) // MOST))))
        while sum(map(len, self._waiting)) > MOST:
            self._waiting = _halved(self._waiting)

    def take(self, model: ModuleType, store: Store) -> Array:
        """Tail x, y and centre of gravity x, y [m], (K, 4), that the page is to be told of; none
        of them waits from then on."""
        chunks = _last(store.chunks(), KEPT) if self.anew else self._waiting
        self._waiting, self.anew = [], False
        return _places(model, chunks)


def _places(model: ModuleType, chunks: Sequence[Chunk]) -> Array:
    found = [np.zeros((0, 4))]
    # In as few calls as there are sets of parameters: most chunks have a sample or two.
    for _, group in itertools.groupby(chunks, lambda chunk: id(chunk.p)):
        same = list(group)
        y, p = np.concatenate([chunk.y for chunk in same]), same[0].p
        with np.errstate(all="ignore"):  # a state may have stopped being finite
            tail, centre = model.joints(y, p)[:, -1], model.centre_of_gravity(y, p)
        found.append(np.concatenate((tail, centre), axis=1))
    return np.concatenate(found)


def _halved(chunks: Iterable[Chunk]) -> list[Chunk]:
    """Every other sample of all."""
    kept, before = [], 0
    for chunk in chunks:
        kept.append(chunk.some(slice(before % 2, None, 2)))
        before += len(chunk)
    return [chunk for chunk in kept if len(chunk)]


def _last(chunks: Iterable[Chunk], most: int) -> list[Chunk]:
    """The last samples."""
    found: list[Chunk] = []
    for chunk in reversed(list(chunks)):
        if most <= 0:
            break
        found.append(chunk.some(slice(-most, None)))
        most -= len(chunk)
    return found[::-1]
