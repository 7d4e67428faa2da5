"""The linearised equations of a scene for every size of the load that is scaled."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from rodgen.analyse.eigen import Complex, all_shapes, lowest_shapes
from rodgen.analyse.modal import MOST_DENSE, Modal, Motions
from rodgen.analyse.neutral import NONE, Neutral
from rodgen.analyse.pencil import Dense, Parts, Pencil
from rodgen.analyse.scaled_load import ScaledLoad, default_load, scaled
from rodgen.analyse.sizes import CRITICAL, check_size
from rodgen.analyse.steady import Steady, linearised, steady
from rodgen.analyse.steady_rod import SteadyRod, state_after
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.system import ParameterLine, System

Flags = NDArray[np.bool_]
BASIS = 16  # modes of the unloaded rod in which a range of forces is searched
RIGID = 1e-6  # of the lowest frequency: less is a rigid-body motion
RIGID_DENSE, ROUNDED = 1e-4, 1e-7  # the same, of the lowest and of the largest, in dense matrices
# Sizes of a load, over the one that matters, at which S is taken: a line through points that lie
# close together enlarges their rounding.
FAR = 16.0
KEPT = 64  # steady states remembered
SOME = 0.37, 1.61, FAR  # loads of no importance
HIGHEST = 1000.0  # EI/L^2, up to which is searched: ten times what a free rod bears


class Family:
    """S(s, P) of a scene for every size P of a load, by default the follower force [N].

    A rod that stays straight has S linear in P; else the state is followed by Newton's method.
    """

    def __init__(self, rod: SteadyRod, load: ScaledLoad):
        self.rod, self.load, self.unit = rod, load, load.unit
        self._line = ParameterLine.of(rod.system, load.parts)
        self._states: dict[float, Steady] = {}
        self._projected: dict[tuple[float, int], Dense] = {}
        self._dense: dict[float, Dense] = {}
        self.straight = self.state(0.0).straight and self.state(self.unit).straight
        if self.straight:
            self._start, self._far = (linearised(self.state(P)) for P in (0.0, FAR * self.unit))

    def state(self, force: float) -> Steady:
        """The steady state under a load; AnalysisError where there is none."""
        if force not in self._states:
            near = min(self._states, key=lambda P: abs(P - force), default=None)
            start = None if near is None else self._states[near]
            made = steady(self.rod, start, self._line.parameters(force))
            while len(self._states) > KEPT:
                self._states.pop(next(iter(self._states)))
            self._states[force] = made
        return self._states[force]

    def at(self, force: float) -> Pencil | Dense:
        """The linearised equations under a load."""
        if not self.straight:
            return linearised(self.state(force))
        x, first, last = force / (FAR * self.unit), self._start, self._far
        pairs = zip(first.parts, last.parts, strict=True)
        K, C, M = (a + x * (b - a) for a, b in pairs)
        if isinstance(first, Pencil) or isinstance(last, Pencil):
            return Pencil(K, C, M)
        terms = None
        if first.terms is not None and last.terms is not None:
            terms = abs(1 - x) * first.terms + abs(x) * last.terms
        return Dense(K, C, M, first.added, terms)

    def without_turning(self, force: float) -> Pencil | Parts:
        """The linearised equations under a load without external damping, turning the whole rod
        taken away."""
        state = self.state(force)
        if self.rod.steered or self.rod.anchored:
            here = self.at(force)
            assert not isinstance(here, Pencil)
            return Parts.of(here)
        pencil = state.pencil()
        return Parts.without_turning(pencil, state.turning) if state.turns_freely else pencil

    def modal(self, force: float) -> Dense:
        """The linearised equations in all modes of the unloaded rod, turning the whole not among
        them where every force leaves it as it is."""
        return self._on(force, self.whole)

    @property
    def damped(self) -> bool:
        """Whether rates have an effect."""
        return any(self.at(size * self.unit).damped for size in (0.0, 1.0))

    @cached_property
    def dragged(self) -> bool:
        """Whether velocities of the joints count, as with external damping."""
        return isinstance(self.at(0.0), Dense)

    @cached_property
    def _modes(self) -> tuple[Array, Array]:
        """Squared frequencies and shapes (coordinates, k) of the unloaded rod without damping;
        turning alone, which every force leaves as it is, is not among them."""
        state, pencil = self.state(0.0), self.at(0.0)
        turns = state.turns_freely
        always = turns and self.state(self.unit).turns_freely
        if isinstance(pencil, Pencil) and pencil.cells > MOST_DENSE:
            squares, found = lowest_shapes(pencil, BASIS, state.turning if turns else None)
            if turns and not always:
                squares = np.append(0.0, squares)
                found = np.column_stack((np.ones(len(found)), found))
            return squares, found
        squares, found = all_shapes(self.equations(0.0))
        if isinstance(pencil, Dense):
            return squares, self._translated(found)
        return squares[always:], found[:, always:]

    def _translated(self, shapes: Array) -> Array:
        """Shapes among which are the translations that nothing holds, each on its own, for which
        no stiffness follows from rounding."""
        moved = len(shapes) - self.rod.cells  # coordinates of joint 0
        if self.rod.anchored or self.rod.steered or not moved:
            return shapes
        rigid = moved + self.state(0.0).turns_freely
        parts, still = shapes[:moved, :rigid], shapes.copy()
        still[:, :moved] = np.eye(len(shapes))[:, :moved]
        still[:, moved:rigid] = shapes[:, :rigid] @ null_space(parts)
        return still

    @cached_property
    def lowest(self) -> float:
        """Lowest frequency of the unloaded rod [rad/s], rigid-body motions apart."""
        rates = np.sqrt(np.abs(self._modes[0]))
        return float(rates[rates > RIGID * rates.max()].min())

    @cached_property
    def rigid(self) -> float:
        """Rate [rad/s] below which an eigenvalue is zero but for rounding."""
        largest = float(np.sqrt(np.abs(self._modes[0]).max()))
        if not self.dragged:
            return RIGID * self.lowest
        return max(RIGID_DENSE * self.lowest, ROUNDED * largest)

    def motions(self, forces: Array, modes: int = BASIS, elastic: bool = False) -> Motions:
        """Small motions under every load, in a basis of so many modes of the unloaded rod; those
        without a rate, which move or turn the rod as a whole, as nan. elastic: also that which
        turns a free rod with external damping, the real one that grows most, at any load, unless
        the rod without that damping diverges, which is a matter of its stiffness alone."""
        found = self._modal(forces, modes, self.neutral).motions()
        if not (elastic and self.bare is not None and self.rod.base):
            return found
        away = self._turns(found.s, np.asarray(forces), modes)
        return Motions(np.where(away, np.nan, found.s), np.where(away, 0.0, found.growth))

    def each(self, forces: Array, modes: int = BASIS, elastic: bool = False) -> Iterator[Motions]:
        """The same motions under one load after the other, each when it is asked for."""
        if not self.straight:  # beyond a load without an equilibrium nothing is known
            return (one for P in forces for one in self.motions(P[None], modes, elastic).each())
        if self.dragged:
            return self.motions(forces, modes, elastic).each()
        return self._modal(forces, modes, self.neutral).each()

    def _turns(self, s: Complex, forces: Array, modes: int) -> Flags:
        """Which motions turn the whole rod."""
        assert self.bare is not None
        diverges = np.any(self.bare.motions(forces, modes).growth > 0, axis=-1, keepdims=True)
        real = np.where((np.abs(s.imag) <= self.rigid) & np.isfinite(s), s.real, -np.inf)
        largest = real.max(axis=-1, keepdims=True)
        first = np.arange(s.shape[-1]) == np.argmax(real, axis=-1)[:, None]
        return np.asarray(first & np.isfinite(largest) & ~diverges)

    def elastic(self, forces: Array, modes: int = BASIS) -> Complex:
        """Eigenvalues s [1/s] (forces, k) with nan for motions of the rod as a whole."""
        return self.motions(forces, modes, elastic=True).s

    @cached_property
    def bare(self) -> Family | None:
        """The rod without damping, where external damping acts on one that turns freely."""
        if not (self.dragged and self.state(0.0).turns_freely):
            return None
        damping = {f"loads.{term.table}": None for term in TERMS.values() if term.damps}
        return Family(SteadyRod.of(self.rod.system.at(damping)), self.load)

    def diverges(self, force: float) -> bool:
        """Whether the rod without damping grows without oscillating."""
        found = (self.bare or self).motions(np.array([force]))
        return bool(((found.growth > 0) & (found.s.imag <= self.rigid)).any())

    def turning(self, force: float) -> float:
        """Growth [1/s] of a slow turning of the whole rod; zero where there is none."""
        if self.bare is None or not self.rod.base:
            return 0.0
        s = self.rates(np.array([force]), self.whole)[0]
        real = s.real[(np.abs(s.imag) <= self.rigid) & (s.real > self.rigid)]
        return float(real.max(initial=0.0))

    @property
    def whole(self) -> int:
        """Modes that there are, as far as they are all known."""
        return int(self._modes[1].shape[1])

    def rates(self, forces: Array, modes: int = BASIS) -> Complex:
        """Eigenvalues s [1/s] (forces, k) in a basis of so many modes of the unloaded rod: without
        damping one of every pair of opposites, with imaginary part >= 0."""
        return self._modal(forces, modes, self.neutral).motions().s

    @cached_property
    def neutral(self) -> Neutral:
        """What has no rate under any load."""
        if not self.dragged:
            return NONE
        found: list[Array] = []
        for size in SOME:
            with suppress(AnalysisError):  # where the load is more than the rod bears
                found.extend(self._modal(np.array([size * self.unit]), self.whole, NONE).by_rates())
        return Neutral.of(found)

    def without_neutral(self, force: float) -> Array:
        """The matrix of first order in all modes, without what has no rate under any load."""
        (made,) = self._modal(np.array([force]), self.whole, self.neutral).by_rates()
        return self.neutral.without(made)

    def _modal(self, forces: Array, modes: int, neutral: Neutral) -> Modal:
        if self.straight:
            first, last = (self._on(P, modes) for P in (0.0, FAR * self.unit))
            x = (np.asarray(forces) / (FAR * self.unit))[:, None, None]
            K, C, M = (a + x * (b - a) for a, b in zip(first.parts, last.parts, strict=True))
        else:
            all_of = [self._on(float(P), modes).parts for P in forces]
            K, C, M = (np.stack(parts) for parts in zip(*all_of, strict=True))
        frequencies = np.maximum(np.sqrt(np.abs(self._modes[0][:modes])), self.lowest)
        return Modal(K, C, M, frequencies, neutral, self._added)

    @cached_property
    def _added(self) -> int:
        """States that are added."""
        return len(self.rod.system.added)

    def _on(self, force: float, modes: int) -> Dense:
        """By virtual work of so many motions."""
        if (force, modes) not in self._projected:
            here = self.at(force) if self.rod.cells > MOST_DENSE else self.equations(force)
            self._projected[force, modes] = here.on(self._modes[1][:, :modes])
        return self._projected[force, modes]

    def equations(self, force: float) -> Dense:
        """The linearised equations under a load, of the angles alone."""
        far = FAR * self.unit
        if self.straight and force not in (0.0, far):
            first, last = (self.equations(P).parts for P in (0.0, far))
            x = force / far
            K, C, M = (a + x * (b - a) for a, b in zip(first, last, strict=True))
            return Dense(K, C, M, self._added)
        if force not in self._dense:
            while len(self._dense) > KEPT:
                self._dense.pop(next(iter(self._dense)))
            self._dense[force] = self.at(force).reduced()
        return self._dense[force]


def family_of(
    system: System | Scene,
    t: float | None = None,
    speed: float | None = None,
    after: float | None = None,
    load: str | None = None,
) -> Family:
    """The linearised scene for every size of a load. Raises InputError, AnalysisError."""
    system = System.of(system)
    check_size(CRITICAL, system)
    system, t = state_after(system, t, speed, after)
    load = default_load(system) if load is None else load
    term, law = scaled(load), None
    if term and term.name in system.load_terms and term.has_size:
        # Its size is not used by what follows; one that is a function of time is no parameter.
        name = term.sizes[0].name
        law = system.laws.get(name)
        if law is not None:
            system = system.at({system.field(name): 0.0})
    rod = SteadyRod.of(system, t, speed)
    made = ScaledLoad.of(load, rod)
    if law is not None:
        applied = math.nan if law.signals else float(law(rod.t))
        made = replace(made, applied=applied)
    return Family(rod, made)
