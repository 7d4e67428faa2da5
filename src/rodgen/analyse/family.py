"""The equations linearised about the steady state, as a load grows."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from rodgen.analyse.eigen import lowest_values
from rodgen.analyse.motions import Modal, Motions
from rodgen.analyse.pencil import Dense, Held, Pencil
from rodgen.analyse.scaled_load import ScaledLoad
from rodgen.analyse.steady import Steady, linearised, steady
from rodgen.analyse.system import System, without
from rodgen.integrate.stepper import Array

Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]

BASIS = 16  # modes of the unloaded rod in which a range of forces is searched
MOST_DENSE = 200  # links up to which all modes are looked at
RIGID = 1e-6  # of the lowest frequency: less is a rigid-body motion
RIGID_DENSE, ROUNDED = 1e-4, 1e-7  # the same, of the lowest and of the largest, in dense matrices
KEPT = 64  # steady states remembered


class Family:
    """S(s, P) of a scene for every size P of a load, by default the follower force [N].

    A rod that stays straight has S linear in P; else the state is followed by Newton's method.
    """

    def __init__(self, system: System, load: ScaledLoad):
        self.system, self.load, self.unit = system, load, load.unit
        self._states: dict[float, Steady] = {}
        self._projected: dict[tuple[float, int], Dense] = {}
        self.straight = self.state(0.0).straight and self.state(self.unit).straight
        if self.straight:
            self._start, self._unit = (linearised(self.state(P)) for P in (0.0, self.unit))

    def state(self, force: float) -> Steady:
        """The steady state under a load; AnalysisError where there is none."""
        if force not in self._states:
            near = min(self._states, key=lambda P: abs(P - force), default=None)
            start = None if near is None else self._states[near]
            made = steady(self.system, start, **self.load.parameters(force))
            while len(self._states) > KEPT:
                self._states.pop(next(iter(self._states)))
            self._states[force] = made
        return self._states[force]

    def at(self, force: float) -> Pencil | Dense:
        """The linearised equations under a load."""
        if not self.straight:
            return linearised(self.state(force))
        x, kind = force / self.unit, type(self._start)
        pairs = zip(self._start.parts, self._unit.parts, strict=True)
        return kind(*(a + x * (b - a) for a, b in pairs))

    def held(self, force: float) -> Pencil | Held:
        """The same without external damping, turning the whole rod taken away."""
        state = self.state(force)
        pencil = state.pencil()
        return Held.of(pencil, state.turning) if state.turns_freely else pencil

    def modal(self, force: float) -> Dense:
        """The linearised equations in all modes of the unloaded rod, turning the whole not among
        them where every force leaves it as it is."""
        return self._on(force, self.whole)

    @property
    def damped(self) -> bool:
        """Whether rates have an effect."""
        return self.at(0.0).damped

    @cached_property
    def _modes(self) -> tuple[Array, Array]:
        """Squared frequencies and shapes (coordinates, k) of the unloaded rod without damping;
        turning alone, which every force leaves as it is, is not among them."""
        state, pencil = self.state(0.0), self.at(0.0)
        turns = state.turns_freely
        if isinstance(pencil, Pencil) and pencil.cells > MOST_DENSE:
            bare = Pencil(pencil.S0, np.zeros_like(pencil.S1), pencil.S2)
            found = lowest_values(bare, BASIS, state.turning if turns else None)
            first = np.argsort(np.abs(found.s))[:BASIS]
            shapes = found.vectors[:, first].real
            if turns:  # virtual work on turning the whole rod is to be none
                turn = np.ones((len(shapes), 1))
                pull = bare.eliminated(turn)[2].T
                shapes = shapes - turn @ (pull @ shapes) / (pull @ turn)
            return -(found.s[first] ** 2).real, shapes / np.abs(shapes).max(axis=0)
        dense = pencil.reduced() if isinstance(pencil, Pencil) else pencil
        K, M = ((matrix + matrix.T) / 2 for matrix in (dense.K, dense.M))
        squares, shapes = eigh(K, M)
        rigid = 1 if turns and isinstance(pencil, Pencil) else 0
        return squares[rigid:], shapes[:, rigid:]

    @cached_property
    def lowest(self) -> float:
        """Lowest frequency of the unloaded rod [rad/s], rigid-body motions apart."""
        rates = np.sqrt(np.abs(self._modes[0]))
        return float(rates[rates > RIGID * rates.max()].min())

    @cached_property
    def rigid(self) -> float:
        """Rate [rad/s] below which an eigenvalue is zero but for rounding."""
        largest = float(np.sqrt(np.abs(self._modes[0]).max()))
        dense = isinstance(self.at(0.0), Dense)
        return max(RIGID_DENSE * self.lowest, ROUNDED * largest) if dense else RIGID * self.lowest

    def motions(self, forces: Array, modes: int = BASIS, elastic: bool = False) -> Motions:
        """Small motions under every load, in a basis of so many modes of the unloaded rod; those
        without a rate, which move or turn the rod as a whole, as nan. elastic: also that which
        turns a free rod with external damping, the real one that grows most, at any load, unless
        the rod without that damping diverges, which is a matter of its stiffness alone."""
        found = self._modal(forces, modes).motions()
        if not isinstance(self.at(0.0), Dense):
            return found
        away = np.abs(found.s) <= self.rigid
        if elastic and self.bare is not None and self.system.base:
            away |= self._turns(found.s, np.asarray(forces), modes, ~away)
        return Motions(np.where(away, np.nan, found.s), np.where(away, 0.0, found.growth))

    def _turns(self, s: Complex, forces: Array, modes: int, kept: Flags) -> Flags:
        """Which motions turn the whole rod, among those that are kept."""
        assert self.bare is not None
        diverges = np.any(self.bare.motions(forces, modes).growth > 0, axis=-1, keepdims=True)
        real = np.where((np.abs(s.imag) <= self.rigid) & kept, s.real, -np.inf)
        largest = real.max(axis=-1, keepdims=True)
        first = np.arange(s.shape[-1]) == np.argmax(real, axis=-1)[:, None]
        return np.asarray(first & np.isfinite(largest) & ~diverges)

    def elastic(self, forces: Array, modes: int = BASIS) -> Complex:
        """Eigenvalues s [1/s] (forces, k) with nan for motions of the rod as a whole."""
        return self.motions(forces, modes, elastic=True).s

    @cached_property
    def bare(self) -> Family | None:
        """The same rod without damping, where external damping acts on one that turns freely."""
        if not (isinstance(self.at(0.0), Dense) and self.state(0.0).turns_freely):
            return None
        scene = without(without(self.system.scene, "external_damping"), "internal_damping")
        return Family(System.of(scene), self.load)

    def diverges(self, force: float) -> bool:
        """Whether the rod without damping grows without oscillating."""
        found = (self.bare or self).motions(np.array([force]))
        return bool(((found.growth > 0) & (found.s.imag <= self.rigid)).any())

    def turning(self, force: float) -> float:
        """Growth [1/s] of a slow turning of the whole rod; zero where there is none."""
        if self.bare is None or not self.system.base:
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
        return self._modal(forces, modes).motions().s

    def _modal(self, forces: Array, modes: int) -> Modal:
        if self.straight:
            first, last = (self._on(P, modes) for P in (0.0, self.unit))
            x = (np.asarray(forces) / self.unit)[:, None, None]
            K, C, M = (a + x * (b - a) for a, b in zip(first.parts, last.parts, strict=True))
        else:
            all_of = [self._on(float(P), modes).parts for P in forces]
            K, C, M = (np.stack(parts) for parts in zip(*all_of, strict=True))
        squares = self._modes[0][:modes]
        frequencies = np.maximum(np.sqrt(np.abs(squares)), self.lowest)
        singular = isinstance(self.at(0.0), Dense) and self.state(0.0).turns_freely
        return Modal(K, C, M, frequencies, singular)

    def _on(self, force: float, modes: int) -> Dense:
        """By virtual work of so many motions."""
        if (force, modes) not in self._projected:
            basis, pencil = self._modes[1][:, :modes], self.at(force)
            if isinstance(pencil, Pencil):
                made = Dense(*(basis.T @ column for column in pencil.eliminated(basis)))
            else:
                made = pencil.on(basis)
            self._projected[force, modes] = made
        return self._projected[force, modes]
