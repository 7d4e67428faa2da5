"""Linearised equations of a scene as a function of the size of one load."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from rodgen.analyse.eigenvalues import Complex, all_shapes, lowest_shapes
from rodgen.analyse.modal import MOST_DENSE, NONE, ModalEquations, ModalMotions, NeutralMotions
from rodgen.analyse.pencil import BlockPencil, DensePencil, MatrixPencil
from rodgen.analyse.scaled_load import ScaledLoad
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.analyse.steady_state import SteadyState, find_steady_state, pencil_about
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.model.terms import TERMS
from rodgen.system import ParameterLine

Flags = NDArray[np.bool_]
BASIS = 16  # modes of the unloaded rod in which a range of forces is searched
RIGID = 1e-6  # of the lowest frequency: less is a rigid-body motion
RIGID_DENSE, ROUNDED = 1e-4, 1e-7  # the same, of the lowest and of the largest, in dense matrices
# Sizes of a load, over the one that matters, at which S is taken: a line through points that lie
# close together enlarges their rounding.
FAR = 16.0
KEPT = 64  # steady states remembered
SOME = 0.37, 1.61, FAR  # arbitrary loads, in units of the one that matters
HIGHEST = 1000.0  # EI/L^2, up to which is searched: ten times what a free rod bears


class LoadFamily:
    """Linearised equations S(s, P) for every size P of a load, by default the follower force [N].

    S is linear in P for a rod that stays straight; else Newton's method follows the state.
    """

    def __init__(self, rod: SteadyRod, load: ScaledLoad):
        self.rod, self.load, self.unit = rod, load, load.unit
        self._line = ParameterLine.of(rod.system, load.parts)
        self._states: dict[float, SteadyState] = {}
        self._projected: dict[tuple[float, int], DensePencil] = {}
        self._dense: dict[float, DensePencil] = {}
        self.straight = (
            self.steady_state(0.0).is_straight and self.steady_state(self.unit).is_straight
        )
        if self.straight:
            self._start, self._far = (
                pencil_about(self.steady_state(P)) for P in (0.0, FAR * self.unit)
            )

    def steady_state(self, force: float) -> SteadyState:
        """Steady state under a load. Raises AnalysisError where there is none."""
        if force not in self._states:
            near = min(self._states, key=lambda P: abs(P - force), default=None)
            start = None if near is None else self._states[near]
            made = find_steady_state(self.rod, start, self._line.parameters(force))
            while len(self._states) > KEPT:
                self._states.pop(next(iter(self._states)))
            self._states[force] = made
        return self._states[force]

    def linearise(self, force: float) -> BlockPencil | DensePencil:
        """Linearised equations under a load."""
        if not self.straight:
            return pencil_about(self.steady_state(force))
        x, first, last = force / (FAR * self.unit), self._start, self._far
        pairs = zip(first.parts, last.parts, strict=True)
        K, C, M = (a + x * (b - a) for a, b in pairs)
        if isinstance(first, BlockPencil) or isinstance(last, BlockPencil):
            return BlockPencil(K, C, M)
        return DensePencil(K, C, M, first.added, first.bend)

    def without_rotation(self, force: float) -> MatrixPencil:
        """Linearised equations without external damping and without rigid rotation; with supports,
        or loads that depend on the motion, the equations as they are."""
        state = self.steady_state(force)
        if self.rod.has_feedback or self.rod.has_supports:
            here = self.linearise(force)
            assert not isinstance(here, BlockPencil)
            return MatrixPencil(*here.parts)
        return MatrixPencil.without_rotation(state.pencil(), state.free_rotation)

    def modal_pencil(self, force: float) -> DensePencil:
        """Linearised equations in all modes of the unloaded rod, without rigid rotation where it is
        free under every load."""
        return self._project(force, self.n_modes)

    @property
    def is_damped(self) -> bool:
        """Whether forces depend on rates."""
        return any(self.linearise(size * self.unit).is_damped for size in (0.0, 1.0))

    @cached_property
    def has_joint_damping(self) -> bool:
        """Whether forces depend on velocities of the joints, as with external damping."""
        return isinstance(self.linearise(0.0), DensePencil)

    @cached_property
    def _modes(self) -> tuple[Array, Array]:
        """Squared frequencies and shapes (coordinates, k) of the undamped, unloaded rod; rigid
        rotation that is free under every load is left out."""
        state, pencil = self.steady_state(0.0), self.linearise(0.0)
        turns = state.has_free_rotation
        always = turns and self.steady_state(self.unit).has_free_rotation
        if isinstance(pencil, BlockPencil) and pencil.n_moving > MOST_DENSE:
            squares, found = lowest_shapes(pencil, BASIS, state.free_rotation)
            if turns and not always:
                squares = np.append(0.0, squares)
                found = np.column_stack((np.ones(len(found)), found))
            return squares, found
        squares, found = all_shapes(self.dense_pencil(0.0))
        if isinstance(pencil, DensePencil):
            return squares, self._separate_translations(found)
        return squares[always:], found[:, always:]

    def _separate_translations(self, shapes: Array) -> Array:
        """Replace shapes of free translation by pure translations, for which rounding causes no
        stiffness."""
        moved = len(shapes) - self.rod.n_moving  # coordinates of joint 0
        if self.rod.has_supports or self.rod.has_feedback or not moved:
            return shapes
        rigid = moved + self.steady_state(0.0).has_free_rotation
        parts, still = shapes[:moved, :rigid], shapes.copy()
        still[:, :moved] = np.eye(len(shapes))[:, :moved]
        still[:, moved:rigid] = shapes[:, :rigid] @ scipy.linalg.null_space(parts)
        return still

    @cached_property
    def lowest_frequency(self) -> float:
        """Lowest frequency of the unloaded rod, without rigid motions [rad/s]; 0 of a rigid rod."""
        rates = np.sqrt(np.abs(self._modes[0]))
        elastic = rates[rates > RIGID * rates.max(initial=0.0)]
        return float(elastic.min()) if len(elastic) else 0.0

    @cached_property
    def zero_tolerance(self) -> float:
        """Modulus below which an eigenvalue is zero but for rounding [rad/s]."""
        largest = float(np.sqrt(np.abs(self._modes[0]).max()))
        if not self.has_joint_damping:
            return RIGID * self.lowest_frequency
        return max(RIGID_DENSE * self.lowest_frequency, ROUNDED * largest)

    def motions(self, forces: Array, modes: int = BASIS, elastic: bool = False) -> ModalMotions:
        """Compute small motions under every load, in a basis of ``modes`` modes of the unloaded
        rod; rigid motions without a rate are nan. elastic: so is rotation of a free rod with
        external damping, which is the real eigenvalue that grows most, at any load, unless the rod
        without that damping diverges, by its stiffness alone."""
        found = self._modal_stack(forces, modes, self.neutral_motions).motions()
        if not (elastic and self.without_damping is not None and self.rod.n_base):
            return found
        away = self._rotation_flags(found.s, np.asarray(forces), modes)
        return ModalMotions(np.where(away, np.nan, found.s), np.where(away, 0.0, found.growth))

    def iterate_motions(
        self, forces: Array, modes: int = BASIS, elastic: bool = False
    ) -> Iterator[ModalMotions]:
        """Yield the small motions under each load in turn, computed on demand."""
        if not self.straight:  # beyond a load without an equilibrium nothing is known
            return (one for P in forces for one in self.motions(P[None], modes, elastic).split())
        if self.has_joint_damping:
            return self.motions(forces, modes, elastic).split()
        return self._modal_stack(forces, modes, self.neutral_motions).iterate_motions()

    def _rotation_flags(self, s: Complex, forces: Array, modes: int) -> Flags:
        """Flags (forces, k) of the motions that turn the whole rod."""
        assert self.without_damping is not None
        diverges = np.any(
            self.without_damping.motions(forces, modes).growth > 0, axis=-1, keepdims=True
        )
        real = np.where((np.abs(s.imag) <= self.zero_tolerance) & np.isfinite(s), s.real, -np.inf)
        largest = real.max(axis=-1, keepdims=True)
        first = np.arange(s.shape[-1]) == np.argmax(real, axis=-1)[:, None]
        return np.asarray(first & np.isfinite(largest) & ~diverges)

    def elastic_eigenvalues(self, forces: Array, modes: int = BASIS) -> Complex:
        """Eigenvalues s [1/s] (forces, k), with nan for motions of the rod as a whole."""
        return self.motions(forces, modes, elastic=True).s

    @cached_property
    def without_damping(self) -> LoadFamily | None:
        """The rod without damping, if external damping acts on one that turns freely; else None."""
        if not (self.has_joint_damping and self.steady_state(0.0).has_free_rotation):
            return None
        damping = {f"loads.{term.table}": None for term in TERMS.values() if term.is_damping}
        return type(self)(SteadyRod.of(self.rod.system.at(damping)), self.load)

    def has_divergence(self, force: float) -> bool:
        """Whether a motion grows without oscillating; if the rod turns freely, without damping."""
        found = (self.without_damping or self).motions(np.array([force]))
        return bool(((found.growth > 0) & (found.s.imag <= self.zero_tolerance)).any())

    def rotation_growth(self, force: float) -> float:
        """Growth of a slow rotation of the whole rod [1/s]; zero where there is none."""
        if self.without_damping is None or not self.rod.n_base:
            return 0.0
        s = self.eigenvalues(np.array([force]), self.n_modes)[0]
        real = s.real[(np.abs(s.imag) <= self.zero_tolerance) & (s.real > self.zero_tolerance)]
        return float(real.max(initial=0.0))

    @property
    def n_modes(self) -> int:
        """Number of modes in the basis of the unloaded rod."""
        return int(self._modes[1].shape[1])

    def eigenvalues(self, forces: Array, modes: int = BASIS) -> Complex:
        """Eigenvalues s [1/s] (forces, k) in a basis of ``modes`` modes of the unloaded rod:
        without damping one of every pair of opposites, with imaginary part >= 0."""
        return self._modal_stack(forces, modes, self.neutral_motions).motions().s

    @cached_property
    def neutral_motions(self) -> NeutralMotions:
        """Neutral motions, which have eigenvalue zero under every load."""
        if not self.has_joint_damping:
            return NONE
        found: list[Array] = []
        for size in SOME:
            with suppress(AnalysisError):  # where the load is more than the rod bears
                found.extend(
                    self._modal_stack(
                        np.array([size * self.unit]), self.n_modes, NONE
                    ).first_order_matrices()
                )
        return NeutralMotions.of(found)

    def matrix_without_neutral(self, force: float) -> Array:
        """First-order matrix in all modes under a load, without the neutral motions."""
        (made,) = self._modal_stack(
            np.array([force]), self.n_modes, self.neutral_motions
        ).first_order_matrices()
        return self.neutral_motions.reduce(made)

    def _modal_stack(self, forces: Array, modes: int, neutral: NeutralMotions) -> ModalEquations:
        if self.straight:
            first, last = (self._project(P, modes) for P in (0.0, FAR * self.unit))
            x = (np.asarray(forces) / (FAR * self.unit))[:, None, None]
            K, C, M = (a + x * (b - a) for a, b in zip(first.parts, last.parts, strict=True))
        else:
            all_of = [self._project(float(P), modes).parts for P in forces]
            K, C, M = (np.stack(parts) for parts in zip(*all_of, strict=True))
        frequencies = np.maximum(np.sqrt(np.abs(self._modes[0][:modes])), self.lowest_frequency)
        return ModalEquations(K, C, M, frequencies, neutral, self.rod.n_added_states)

    def _project(self, force: float, modes: int) -> DensePencil:
        """Project the linearised equations on ``modes`` modes of the unloaded rod."""
        if (force, modes) not in self._projected:
            here = (
                self.linearise(force)
                if self.rod.n_moving > MOST_DENSE
                else self.dense_pencil(force)
            )
            self._projected[force, modes] = here.project(self._modes[1][:, :modes])
        return self._projected[force, modes]

    def dense_pencil(self, force: float) -> DensePencil:
        """Dense linearised equations under a load, without joint forces."""
        far = FAR * self.unit
        if self.straight and force not in (0.0, far):
            first, last = (self.dense_pencil(P).parts for P in (0.0, far))
            x = force / far
            K, C, M = (a + x * (b - a) for a, b in zip(first, last, strict=True))
            return DensePencil(K, C, M, added=self.rod.n_added_states)
        if force not in self._dense:
            while len(self._dense) > KEPT:
                self._dense.pop(next(iter(self._dense)))
            self._dense[force] = self.linearise(force).to_dense()
        return self._dense[force]
