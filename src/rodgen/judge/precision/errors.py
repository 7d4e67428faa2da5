"""Error measures of a run against a reference solution."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

import rodgen
from rodgen.judge.precision.contestant import Array
from rodgen.judge.precision.job import Job

MODES = 3  # the lowest, whose amplitudes are compared
MEASURES = ("error_phi", "error_tail", "error_modes", "error_energy")

Errors = dict[str, float | None]


@dataclass(frozen=True, eq=False)
class Measures:
    """Of the states of a job against the exact ones (samples, states), of which it is told."""

    job: Job
    exact: Array

    def errors(self, y: Array) -> Errors:
        """All measures of states (samples, states); infinite where they are not finite.

        error_phi: largest difference of an angle at the end [rad]; error_tail: largest distance of
        the tail over the samples [m]; error_modes: largest difference over the samples of an
        amplitude of the lowest modes [rad], None where the rod has none; error_energy: largest
        difference of the energy over the samples, relative to the largest energy.
        """
        modes = None if self.shapes is None else self.modes(y)
        found = (self.over_time(y)[-1], self.tail(y), modes, self.energy(y))
        return {
            name: value if value is None or np.isfinite(value) else np.inf
            for name, value in zip(MEASURES, map(_number, found), strict=True)
        }

    def over_time(self, y: Array) -> Array:
        """Largest difference of an angle at every sample [rad] (samples,)."""
        worst: Array = np.abs(self._angles(y) - self._angles(self.exact)).max(axis=1)
        return worst

    def tail(self, y: Array) -> float:
        """Largest distance between the tails [m]."""
        off = self._tail(y) - self._exact_tail
        return float(np.hypot(off[:, 0], off[:, 1]).max())

    def modes(self, y: Array) -> float:
        """Largest difference of an amplitude of the lowest modes [rad]."""
        assert self.shapes is not None
        off = self._angles(y) - self._angles(self.exact)
        return float(np.abs(off @ self.shapes.T).max())

    def energy(self, y: Array) -> float:
        """Largest difference of the energy, relative to `scale`."""
        total = sum(self._energies(y))
        return float(np.abs(total - self._exact_energy).max() / self.scale)

    @cached_property
    def scale(self) -> float:
        """The largest energy [J]: kinetic, of the springs, and change of that of gravity."""
        kinetic, spring, gravity = self._energies(self.exact)
        return float((kinetic + spring + np.abs(gravity - gravity[0])).max()) or 1.0

    @cached_property
    def shapes(self) -> Array | None:
        """Rows that give the amplitudes of the lowest modes from angles (modes, moving links).

        Projections in the mass matrix of the straight rod whose translation follows its angles;
        of modes whose largest angle is one.
        """
        shapes = self._lowest()
        if shapes is None:
            return None
        mass = _of_angles(self.job)
        weighted = shapes @ mass
        rows: Array = weighted / np.einsum("ij,ij->i", weighted, shapes)[:, None]
        return rows

    def _lowest(self) -> Array | None:
        """The lowest modes of the rod without its loads (modes, moving links)."""
        try:
            found = rodgen.natural_modes(unloaded(self.job.scene), MODES)
        except (rodgen.AnalysisError, rodgen.SceneError):
            return None
        shapes = np.real(found.phi)[:, self.job.scene.held :]
        if not len(shapes):
            return None
        largest = np.abs(shapes).max(axis=1, keepdims=True)
        return np.asarray(shapes / largest)

    def _angles(self, y: Array) -> Array:
        base = 2 * self.job.scene.hold.translates
        return y[:, base : y.shape[1] // 2]

    def _tail(self, y: Array) -> Array:
        joints: Array = self.job.model.joints(y, self.job.p)
        return joints[:, -1]

    def _energies(self, y: Array) -> tuple[Array, Array, Array]:
        kinetic, spring, gravity = self.job.model.energy(y, self.job.p)
        return kinetic, spring, gravity

    @cached_property
    def _exact_tail(self) -> Array:
        return self._tail(self.exact)

    @cached_property
    def _exact_energy(self) -> Array:
        return np.asarray(sum(self._energies(self.exact)))


def unloaded(scene: rodgen.Scene) -> rodgen.Scene:
    """The rod of a scene, held as it is, without its loads."""
    rod = scene.rod.model_dump(exclude_none=True)
    return rodgen.Scene.from_dict({"name": scene.name, "rod": rod})


def _of_angles(job: Job) -> Array:
    """Mass matrix of the angles of the straight rod (links, links), its translation eliminated."""
    mass: Array = job.model.mass_matrix(np.zeros_like(job.start), job.p)
    base = 2 * job.scene.hold.translates
    if not base:
        return mass
    across = mass[:base, base:]
    return np.asarray(mass[base:, base:] - across.T @ np.linalg.solve(mass[:base, :base], across))


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)
