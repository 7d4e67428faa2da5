"""A live run as a Solution: each sample with the parameters that held when it was made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np

from rodgen.integrate.solution import Energy, Inertia, Solution
from rodgen.integrate.stepper import Array
from rodgen.view.live.chunk import Chunk


@dataclass(repr=False)
class Recorded(Solution):
    """A Solution of which what follows from the states follows piece by piece."""

    pieces: tuple[Chunk, ...] = ()

    def _by_piece(self, made: Callable[[ModuleType, Array, Array], Any], axis: int = 0) -> Array:
        """What is made of every piece, one after the other along the axis of time."""
        parts = [np.asarray(made(self._model, piece.y, piece.p)) for piece in self.pieces]
        return np.concatenate(parts, axis=axis)

    @cached_property
    def joints(self) -> Array:
        """Positions of the joints [m], nose to tail, (T, n+1, 2)."""
        return self._by_piece(lambda model, y, p: model.joints(y, p))

    @cached_property
    def energy(self) -> Energy:
        """Kinetic, spring and gravity energy [J]."""
        return Energy(*self._by_piece(lambda model, y, p: model.energy(y, p), 1))

    @cached_property
    def centre_of_gravity(self) -> Array:
        """Centre of gravity [m], (T, 2)."""
        return self._by_piece(lambda model, y, p: model.centre_of_gravity(y, p))

    @cached_property
    def inertia(self) -> Inertia:
        """Moments and product of inertia about the centre of gravity [kg m^2]."""
        return Inertia(*self._by_piece(lambda model, y, p: model.inertia(y, p), 1))

    @cached_property
    def energy_balance(self) -> Array:
        """Energy gained since the start less the work done and what changes and kicks have put in
        [J], (T,): zero but for errors."""
        given = np.concatenate([np.full(len(piece), piece.given) for piece in self.pieces])
        balance: Array = self.energy.total - self.pieces[0].start - self.total_work - given
        return balance
