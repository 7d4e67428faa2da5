"""Linearised equations as a function of the size of one load, of a rod with links without mass."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from rodgen.analyse.eigenvalues import Complex
from rodgen.analyse.light_motions import (
    first_order,
    light_motions,
    lowest_light_rate,
    neutral_motions_of,
    shapes_with_inertia,
)
from rodgen.analyse.load_family import BASIS, RIGID_DENSE, SOME, LoadFamily
from rodgen.analyse.massless import regular_pencil
from rodgen.analyse.modal import NONE, ModalMotions, NeutralMotions
from rodgen.analyse.pencil import DensePencil, MatrixPencil
from rodgen.analyse.steady_state import has_drag
from rodgen.arrays import Array


class LightLoadFamily(LoadFamily):
    """A load family whose equations have all coordinates, and whose motions are those of what has
    inertia: how many have it depends on how the rod is bent."""

    def without_rotation(self, force: float) -> MatrixPencil:
        return MatrixPencil(*self.linearise(force).to_dense().parts)

    def dense_pencil(self, force: float) -> DensePencil:
        return regular_pencil(self.linearise(force).to_dense(), self._inertia).pencil

    @cached_property
    def _modes(self) -> tuple[Array, Array]:
        return shapes_with_inertia(self.linearise(0.0).to_dense(), self._inertia)

    @property
    def _inertia(self) -> float:
        return self.steady_state(0.0).inertia

    @cached_property
    def lowest_frequency(self) -> float:
        return lowest_light_rate(self.linearise(0.0).to_dense(), self._inertia)

    @cached_property
    def zero_tolerance(self) -> float:
        return RIGID_DENSE * self.lowest_frequency

    def motions(self, forces: Array, modes: int = BASIS, elastic: bool = False) -> ModalMotions:
        """Compute all small motions under every load; nan stands for those without inertia."""
        most, found = 3 * (self.rod.n_moving + 2) + self.rod.n_added_states, []
        for force in np.asarray(forces).tolist():
            here = regular_pencil(self.linearise(force).to_dense(), self._inertia)
            made = light_motions(here, self.lowest_frequency, self.neutral_motions)
            found.append(made.pad(most))
        parts = zip(*((one.s, one.growth) for one in found), strict=True)
        return ModalMotions(*map(np.stack, parts))

    def iterate_motions(
        self, forces: Array, modes: int = BASIS, elastic: bool = False
    ) -> Iterator[ModalMotions]:
        return (one for P in forces for one in self.motions(P[None]).split())

    def eigenvalues(self, forces: Array, modes: int = BASIS) -> Complex:
        return self.motions(forces).s

    @cached_property
    def without_damping(self) -> LoadFamily | None:
        return super().without_damping if has_drag(self.rod) else None

    @cached_property
    def neutral_motions(self) -> NeutralMotions:
        if not (has_drag(self.rod) or self.rod.has_feedback):
            return NONE
        pencils = [self.dense_pencil(size * self.unit) for size in SOME]
        return neutral_motions_of(pencils, self.lowest_frequency)

    def matrix_without_neutral(self, force: float) -> Array:
        made = first_order(self.dense_pencil(force), self.lowest_frequency)
        return self.neutral_motions.reduce(made)
