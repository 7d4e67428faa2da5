"""A scene as a common task of all integrators, and measures of the errors of their states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from types import ModuleType
from typing import NamedTuple

import numpy as np

from rodgen.analyse.modes import natural_modes
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.loading import build
from rodgen.loading.generated_module import call_module
from rodgen.model.terms import CONTACTS
from rodgen.scene import Scene
from rodgen.system.freezing import masses_at

PARTS = "rhs", "jac", "mass", "power", "quantities", "flow", "newton"  # of the module
SAMPLES = 100  # intervals between the states that are compared
SAME = 1e-12  # of the span: times closer than that are one
EDGE = 1e-12  # by which a time is held inside a stretch [s]: at its ends loads may jump
MODES = 3  # the lowest, whose amplitudes are compared
STILL = 1e-9  # rad, by which the angles of a rod change that stays as it is
MEASURES = ("error_phi", "error_angles", "error_rates", "error_tail", "error_modes", "error_energy")

Errors = dict[str, float | None]


@dataclass(frozen=True, eq=False)
class Job:
    """A scene that every contestant integrates, with states at the same times."""

    name: str
    scene: Scene

    @classmethod
    def of(cls, name: str, scene: Scene) -> Job:
        """Create a job from a scene; its samples are a hundredth of the span apart.

        Without events: peers know nothing of them, and states can be compared only where all of
        them reach the end.
        """
        scene = scene.replace({"events": []})
        first, last = scene.integrate.span
        return cls(name, scene.with_integrate(output_every=(last - first) / SAMPLES))

    @cached_property
    def model(self) -> ModuleType:
        """Module in C, by which states are judged, with all that any method asks it for: no run is
        to wait for a compiler."""
        return build(self.scene, "c", parts=PARTS)

    @cached_property
    def p(self) -> Array:
        """Parameters of the module."""
        p: Array = self.model.parameters(**self.scene.parameters)
        return p

    @cached_property
    def initial_state(self) -> Array:
        """State at the start (states,)."""
        y0: Array = self.scene.initial_state()
        return y0

    @property
    def span(self) -> tuple[float, float]:
        """Start and end of the integration [s]."""
        first, last = self.scene.integrate.span
        return first, last

    @cached_property
    def sample_times(self) -> Array:
        """Times at which states are compared [s] (samples,), start and end among them."""
        times: Array = np.asarray(self.scene.integrate.sample_times)
        return times

    @cached_property
    def stretches(self) -> list[Stretch]:
        """Parts of the span in which loads are smooth: every method steps onto their ends. The
        start of the job is among the times of none."""
        first, last = self.span
        same, found = SAME * (last - first), []
        for begin, end in pairwise([first, *self.scene.breaks(), last]):
            inside = (self.sample_times > begin + same) & (self.sample_times < end - same)
            inner = self.sample_times[inside]
            sampled = bool((np.abs(self.sample_times - end) <= same).any())
            found.append(Stretch(begin, end, np.append(inner, end), len(inner) + sampled))
        return found

    @cached_property
    def mode_projections(self) -> Array | None:
        """Rows that give the amplitudes of the lowest modes from angles (modes, moving links).

        Projections in the mass matrix of the straight rod whose translation follows its angles;
        of modes whose largest angle is one.
        """
        shapes = self._lowest_shapes()
        if shapes is None:
            return None
        weighted = shapes @ self._angle_mass_matrix()
        rows: Array = weighted / np.einsum("ij,ij->i", weighted, shapes)[:, None]
        return rows

    def _lowest_shapes(self) -> Array | None:
        """Lowest modes of the rod without its loads (modes, moving links), None without any."""
        try:
            found = natural_modes(without_loads(self.scene), MODES)
        except (AnalysisError, InputError):
            return None
        shapes = np.real(found.phi)[:, self.scene.n_fixed_links :]
        if not len(shapes):
            return None
        largest = np.abs(shapes).max(axis=1, keepdims=True)
        return np.asarray(shapes / largest)

    def _angle_mass_matrix(self) -> Array:
        """Mass matrix of the angles of the straight rod (links, links), its translation
        eliminated."""
        t, y = self.scene.integrate.span[0], np.zeros_like(self.initial_state)
        mass: Array = call_module(self.model, "mass_matrix", t, y, self.p)
        base = 2 * self.scene.boundary_condition.translates
        across, rest = mass[:base, base:], mass[base:, base:]
        return rest - across.T @ np.linalg.solve(mass[:base, :base], across)


class Stretch(NamedTuple):
    """Part of the span in which loads are smooth, from first to last [s]. times: after first, the
    samples there and last; samples: how many of them are samples, all or all but the last."""

    first: float
    last: float
    times: Array
    samples: int

    @property
    def middle(self) -> float:
        """Time at which loads with jumps are evaluated for the stretch."""
        return 0.5 * (self.first + self.last)

    def clip(self, t: float) -> float:
        """Clip a time to inside the ends, at which the next stretch may have another load."""
        return min(max(t, self.first + EDGE), self.last - EDGE)


def integrate_stretches(job: Job, over: Callable[[Stretch, Array], Array]) -> Array:
    """Integrate a job by stretches; return states at the samples (samples, states). over: maps a
    stretch and the state at its start to the states at its times."""
    y, rows = job.initial_state, [job.initial_state[None]]
    for stretch in job.stretches:
        states = over(stretch, y)
        if len(states) != len(stretch.times):
            raise ArithmeticError(f"ended after {len(states)} of {len(stretch.times)} samples")
        rows.append(states[: stretch.samples])
        y = np.array(states[-1])
    return np.concatenate(rows)


@dataclass(frozen=True, eq=False)
class Measures:
    """Measures of the errors of states (samples, states) of a job, against the exact ones."""

    job: Job
    exact: Array

    def errors(self, y: Array) -> Errors:
        """All measures of states (samples, states); infinite where they are not finite.

        error_phi: largest difference of an angle at the end [rad]; error_angles, error_rates: of
        an angle and of a rate over the samples [rad, rad/s]; error_tail: largest distance of the
        tail over the samples [m]; error_modes: largest difference over the samples of an
        amplitude of the lowest modes [rad], None where the rod has none; error_energy: largest
        difference of the energy over the samples, relative to the largest energy.
        """
        modes = None if self.job.mode_projections is None else self.mode_error(y)
        angles, rates = self.angle_errors(y), np.abs(self._rates(y) - self._rates(self.exact)).max()
        found = (angles[-1], angles.max(), rates, self.tail_error(y), modes, self.energy_error(y))
        return {
            name: None if value is None else float(value) if np.isfinite(value) else np.inf
            for name, value in zip(MEASURES, found, strict=True)
        }

    def angle_errors(self, y: Array) -> Array:
        """Largest difference of an angle at every sample [rad] (samples,)."""
        worst: Array = np.abs(self._angles(y) - self._angles(self.exact)).max(axis=1)
        return worst

    def tail_error(self, y: Array) -> float:
        """Largest distance between the tails [m]."""
        off = self._tail(y) - self._exact_tail
        return float(np.hypot(off[:, 0], off[:, 1]).max())

    def mode_error(self, y: Array) -> float:
        """Largest difference of an amplitude of the lowest modes [rad]."""
        assert self.job.mode_projections is not None
        off = self._angles(y) - self._angles(self.exact)
        return float(np.abs(off @ self.job.mode_projections.T).max())

    def energy_error(self, y: Array) -> float:
        """Largest difference of the energy, relative to `energy_scale`."""
        total = sum(self._energies(y))
        return float(np.abs(total - self._exact_energy).max() / self.energy_scale)

    @cached_property
    def default_measure(self) -> str:
        """Measure of errors unless another one is asked for: that of the angles, or, of a rod that
        does not turn, of its tail."""
        turned = np.ptp(self._angles(self.exact), axis=0).max()
        return "error_phi" if turned > STILL else "error_tail"

    @cached_property
    def energy_scale(self) -> float:
        """The largest energy [J]: kinetic, of the springs, and change of that of gravity."""
        kinetic, spring, gravity = self._energies(self.exact)
        return float((kinetic + spring + np.abs(gravity - gravity[0])).max()) or 1.0

    def _angles(self, y: Array) -> Array:
        return y[:, 2 * self.job.scene.boundary_condition.translates : self._n_positions(y)]

    def _rates(self, y: Array) -> Array:
        half = self._n_positions(y)
        return y[:, half + 2 * self.job.scene.boundary_condition.translates : 2 * half]

    def _n_positions(self, y: Array) -> int:
        """Number of positions in a state."""
        return int(y.shape[1] - len(self.job.scene.states)) // 2

    def _tail(self, y: Array) -> Array:
        t = self.job.scene.integrate.sample_times
        joints: Array = call_module(self.job.model, "joints", t, y, self.job.p)
        return joints[:, -1]

    def _energies(self, y: Array) -> tuple[Array, Array, Array]:
        t = self.job.scene.integrate.sample_times
        kinetic, spring, gravity = call_module(self.job.model, "energy", t, y, self.job.p)
        return kinetic, spring, gravity

    @cached_property
    def _exact_tail(self) -> Array:
        return self._tail(self.exact)

    @cached_property
    def _exact_energy(self) -> Array:
        return np.asarray(sum(self._energies(self.exact)))


def without_loads(scene: Scene) -> Scene:
    """Remove the loads from a scene; its bodies are those at the start, its boundary is kept."""
    changes = masses_at(scene, scene.integrate.span[0])
    changes |= {"loads": {}, "states": {}, "initial": {}, "integrate": {}}
    changes |= {"supports": [], "events": [], "foundation": None}
    changes |= {term.table: [] for term in CONTACTS}
    return scene.replace(changes)
