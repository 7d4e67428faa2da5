"""A live run as a Solution: each sample with the parameters that held when it was made."""

from __future__ import annotations

from dataclasses import InitVar, dataclass

import numpy as np

from rodgen.integrate.changes import Changes
from rodgen.integrate.solution import Solution
from rodgen.view.live.chunk import Chunk


@dataclass(repr=False)
class Recorded(Solution):
    """A Solution whose changes are those between the pieces that it is made from."""

    pieces: InitVar[tuple[Chunk, ...]] = ()

    def __post_init__(self, pieces: tuple[Chunk, ...]) -> None:
        if pieces:  # else it has some samples of another's, with their changes
            counts = [len(piece) for piece in pieces]
            p = np.repeat([piece.p for piece in pieces], counts, axis=0)
            self.changes = Changes(p, np.repeat([piece.given for piece in pieces], counts))
