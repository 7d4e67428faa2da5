"""The equations linearised about the steady state, as the follower force grows."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from rodgen.analyse.eigen import lowest_values
from rodgen.analyse.pencil import Dense, Held, Pencil
from rodgen.analyse.steady import Steady, linearised, steady
from rodgen.analyse.system import System, without
from rodgen.integrate.stepper import Array

Complex = NDArray[np.complex128]

BASIS = 16  # modes of the unloaded rod in which a range of forces is searched
MOST_DENSE = 200  # links up to which all modes are looked at
RIGID = 1e-6  # of the lowest frequency: less is a rigid-body motion
RIGID_DENSE, ROUNDED = 1e-4, 1e-7  # the same, of the lowest and of the largest, in dense matrices
GROWS = 1e-6  # of the lowest frequency: less growth without damping is rounding
KEPT = 64  # steady states remembered


class Family:
    """S(s, P) of a scene for every follower force P [N].

    A rod that stays straight has S linear in P; else the state is followed by Newton's method.
    """

    def __init__(self, system: System, unit: float):
        self.system, self.unit = system, unit
        self._states: dict[float, Steady] = {}
        self._projected: dict[tuple[float, int], Dense] = {}
        self.straight = self.state(0.0).straight and self.state(unit).straight
        if self.straight:
            self._start, self._unit = (linearised(self.state(P)) for P in (0.0, unit))

    def state(self, force: float) -> Steady:
        """The steady state under a follower force; AnalysisError where there is none."""
        if force not in self._states:
            near = min(self._states, key=lambda P: abs(P - force), default=None)
            start = None if near is None else self._states[near]
            made = steady(self.system, start, follower_force=float(force))
            while len(self._states) > KEPT:
                self._states.pop(next(iter(self._states)))
            self._states[force] = made
        return self._states[force]

    def at(self, force: float) -> Pencil | Dense:
        """The linearised equations under a follower force."""
        if not self.straight:
            return linearised(self.state(force))
        x = force / self.unit
        if isinstance(self._start, Pencil) and isinstance(self._unit, Pencil):
            a, b = self._start, self._unit
            return Pencil(a.S0 + x * (b.S0 - a.S0), a.S1, a.S2)
        assert isinstance(self._start, Dense)
        assert isinstance(self._unit, Dense)
        c, d = self._start, self._unit
        return Dense(c.K + x * (d.K - c.K), c.C, c.M)

    def held(self, force: float) -> Pencil | Held:
        """The same without external damping, turning the whole rod taken away."""
        state = self.state(force)
        pencil = state.pencil()
        return Held.of(pencil, state.turning) if state.turns_freely else pencil

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

    def elastic(self, forces: Array, modes: int = BASIS) -> Complex:
        """The same with nan for motions of the rod as a whole: zero ones, and, where external
        damping acts on a free rod, the real one that grows most, at any force, unless the rod
        without that damping diverges, which is a matter of its stiffness alone."""
        s = self.rates(forces, modes)
        s = np.where(np.abs(s) > self.rigid, s, np.nan)
        if self.bare is None or not self.system.base:
            return s
        diverges = (self.bare.rates(forces, modes).real > GROWS * self.lowest).any(axis=-1)
        slow = (np.abs(s.imag) <= self.rigid) & ~np.isnan(s)
        real = np.where(slow, s.real, -np.inf)
        at = np.argmax(real, axis=-1)
        rows = np.flatnonzero(~diverges & np.isfinite(real.max(axis=-1)))
        s[rows, at[rows]] = np.nan
        return s

    @cached_property
    def bare(self) -> Family | None:
        """The same rod without damping, where external damping acts on one that turns freely."""
        if not (isinstance(self.at(0.0), Dense) and self.state(0.0).turns_freely):
            return None
        scene = without(without(self.system.scene, "external_damping"), "internal_damping")
        return Family(System.of(scene), self.unit)

    def diverges(self, force: float) -> bool:
        """Whether the rod without damping grows without oscillating."""
        s = (self.bare or self).rates(np.array([force]))[0]
        return bool(((s.real > GROWS * self.lowest) & (s.imag <= self.rigid)).any())

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
        if self.straight:
            first, last = (self._on(P, modes) for P in (0.0, self.unit))
            x = (np.asarray(forces) / self.unit)[:, None, None]
            K, C, M = first.K + x * (last.K - first.K), first.C, first.M
        else:
            all_of = [self._on(float(P), modes) for P in forces]
            K, C, M = (np.stack([getattr(one, name) for one in all_of]) for name in "KCM")
        inverse = np.linalg.inv(M)
        A = -inverse @ K
        if not C.any():
            s = np.sqrt(np.linalg.eigvals(A).astype(complex))
            return np.asarray(np.where(s.imag < 0, -s, s))
        B = np.broadcast_to(-inverse @ C, A.shape)
        zero, one = np.zeros_like(A), np.broadcast_to(np.eye(A.shape[-1]), A.shape)
        return np.asarray(np.linalg.eigvals(np.block([[zero, one], [A, B]])))

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
