"""Jumps between the stretches of a run: of masses, which take energy along, and of the velocity of
a base, which are blows.

What leaves with a jump of a mass has the velocity and the height of its place, so that the energy
which it takes along is the difference of the rod's energies with the masses before and after, in
one and the same state. A blow of the base changes the rates of the links: no force acts on their
angles in that instant but what is finite, so that the momenta which belong to these angles stay.
In a stretch between two break points works are integrals of powers; at the ends of stretches these
differences are added. A sample at a break point is that of what holds at that very time.
"""

from __future__ import annotations

import math
from types import ModuleType
from typing import NamedTuple

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.loading.generated_module import call_module, structure_of
from rodgen.model.rod import ROD
from rodgen.model.terms import BASE_ANGLE, EMPTYING, MOVING_BASE

NONE = 1e-9  # share of a velocity of the base, below which its change is none


class Jump(NamedTuple):
    """Change of the rates of the links [rad/s] (n_moving,), and work [J] of every load (works,);
    first: place of the first rate in a state."""

    rates: Array
    work: Array
    first: int

    def add_to(self, row: Array, states: int) -> None:
        """Add it to a state, and to the works behind the numbers of that."""
        row[self.first : self.first + len(self.rates)] += self.rates
        row[states:] += self.work[: len(row) - states]


class Jumps:
    """Jumps of masses and of the base's velocity in the run of one rod, which goes from stretch to
    stretch."""

    def __init__(self, model: ModuleType, p: Array):
        self._model, self._p, self._structure = model, p, structure_of(model)
        self._works = loads_at_work(model)
        self._masses, self._blows = has_mass_jumps(model), may_have_blows(model)
        timed = self._structure.time_dependent_loads(p) if self._blows else {}
        base = self._structure.base_parameters
        self._moved = {name: e for name, e in timed.items() if name in base}
        self._high, self._end = math.nan, math.nan

    def begin(self, t: float, y: Array, end: float, low: float, high: float) -> Jump | None:
        """Begin a stretch, and return the jump at its start, time t in state y; None without. end:
        of the stretch; low, high: bounds of the times of its loads."""
        before = self._high if self._end == t else t
        self.resume_stretch(end, high)
        return self._jump(before, low, y)

    def resume_stretch(self, end: float, high: float) -> None:
        """Continue in a stretch that was begun before."""
        self._end, self._high = end, high

    def at_end(self, t: float, y: Array) -> Jump | None:
        """Jump by time t itself, in state y, where the stretch ends then; None without."""
        return self._jump(self._high, t, y) if t == self._end else None

    def _jump(self, before: float, after: float, y: Array) -> Jump | None:
        """Jump from one time to another in a state; None without."""
        blow = self._blow(before, after, y) if self._blows else None
        if blow is None and not self._masses:
            return None
        rates = np.zeros(self._n_moving) if blow is None else blow
        hit = y.copy()
        hit[self._first_rate : self._first_rate + self._n_moving] += rates
        gained = self._energy(after, hit) - self._energy(before, y)
        work = np.zeros(len(self._works))
        if math.isfinite(gained):
            work[self._works.index(EMPTYING if blow is None else MOVING_BASE)] = gained
        return Jump(rates, work, self._first_rate)

    def _energy(self, t: float, y: Array) -> float:
        return float(sum(call_module(self._model, "energy", t, y, self._p)))

    # Blows of the base --------------------------------------------------------------------------

    @property
    def _n_moving(self) -> int:
        return self._structure.n_links - self._structure.boundary_condition.first

    @property
    def _first_rate(self) -> int:
        """Place of the first rate of a link in the state."""
        angles = self._structure.angle_slice
        return int(angles.stop + angles.start)

    def _blow(self, before: float, after: float, y: Array) -> Array | None:
        """Change of the rates (n_moving,) by a change of the base's velocity; None without."""
        old, new = (self._base_speeds(t) for t in (before, after))
        if (np.abs(new - old) <= NONE * (np.abs(new) + np.abs(old))).all():
            return None
        fastest = float(np.abs(np.concatenate((old, new))).max())
        momenta = (
            self._momenta_at_rest(before, y, fastest),
            self._momenta_at_rest(after, y, fastest),
        )
        mass = call_module(self._model, "mass_matrix", after, y, self._p)
        return np.asarray(np.linalg.solve(mass, momenta[0] - momenta[1]))

    def _base_speeds(self, t: float) -> Array:
        """Speeds of the ends of a link [m/s] that the velocities and the rate of the base give."""
        length = self._p[self._structure.indices[ROD[1].name]]
        found = []
        for name, e in self._moved.items():
            speed = float(e.derivative(t, {}))
            found.append(speed * length if name == BASE_ANGLE else speed)
        return np.array(found)

    def _momenta_at_rest(self, t: float, y: Array, speed: float) -> Array:
        """Momenta (n_moving,) that belong to the angles of links whose rates are zero, of a base
        that moves: derivatives of the kinetic energy by the rates. It is quadratic in them, so that
        differences have no error but rounding, least with rates of the size of the base's."""
        unit = speed / float(self._p[self._structure.indices[ROD[1].name]])
        count, first = self._n_moving, self._first_rate
        sides = np.tile(y, (2, count, 1))
        sides[..., first : first + count] = np.eye(count) * np.array([unit, -unit])[:, None, None]
        kinetic = call_module(self._model, "energy", np.float64(t), sides, self._p)[0]
        return np.asarray((kinetic[0] - kinetic[1]) / (2 * unit))


def has_mass_jumps(model: ModuleType) -> bool:
    """Whether the law of a mass of a module compares something, so that the mass may jump."""
    return any(law.corners() for law in structure_of(model).open_masses.values())


def may_have_blows(model: ModuleType) -> bool:
    """Whether the motion of the base is not smooth, so that its velocity may jump."""
    structure = structure_of(model)
    moved = (structure.open_expressions.get(name) for name in structure.base_parameters)
    return any(e is not None and (e.corners() or e.has_table) for e in moved)
