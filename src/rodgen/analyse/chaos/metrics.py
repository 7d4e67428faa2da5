"""Metrics of changes of a state, and Lyapunov exponents that are zero for every motion.

Liouville's theorem holds for positions and momenta: in positions and velocities the volume that is
kept has the density det M(q). The metric of kinetic energy, with M(q) for changes of positions and
M(q) for those of velocities, has just this density: in it an undamped motion keeps volumes.

A change of the state along the motion itself, or by a displacement or a turn that the equations do
not see, neither grows nor dies out; nor does a change of what is kept (energy, momentum).
"""

from __future__ import annotations

from types import ModuleType

import numpy as np
from scipy.linalg import solve_triangular

from rodgen.arrays import Array
from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.loading.generated_module import call_module
from rodgen.model.term import COUPLE
from rodgen.model.terms import TERMS
from rodgen.scene import Scene

ALIKE = ("external_damping",)  # drag that does not depend on the direction of the ground


class Metric:
    """Metric of kinetic energy, for tangents V (count, states) at a state y and a time t [s]; added
    states count as they are. Without a model, so does every number of the state."""

    def __init__(self, model: ModuleType | None, p: Array):
        self._model, self._p = model, p

    def _cholesky(self, t: float, y: Array) -> Array:
        """Cholesky factor L of the mass matrix, M = L L^T; empty without a model."""
        if self._model is None:
            return np.zeros((0, 0))
        root: Array = np.linalg.cholesky(call_module(self._model, "mass_matrix", t, y, self._p))
        return root

    def to_components(self, t: float, y: Array, tangents: Array) -> Array:
        """Components (count, states) of tangents in an orthonormal frame."""
        root, found = self._cholesky(t, y), tangents.copy()
        for half in _halves(root):
            found[:, half] = tangents[:, half] @ root
        return found

    def from_components(self, t: float, y: Array, measured: Array) -> Array:
        """Tangents with these components."""
        root, found = self._cholesky(t, y), measured.copy()
        for half in _halves(root):
            found[:, half] = solve_triangular(root, measured[:, half].T, lower=True, trans="T").T
        return found

    def log_density(self, t: float, y: Array) -> float:
        """Logarithm of the volume of a unit cube of numbers of the state."""
        return 2.0 * float(np.log(np.diag(self._cholesky(t, y))).sum())


def _halves(root: Array) -> tuple[slice, ...]:
    """Slices of positions and velocities in a state; none for an empty factor."""
    size = len(root)
    return (slice(size), slice(size, 2 * size)) if size else ()


def is_autonomous(scene: Scene) -> bool:
    """Whether no load, state, mass or spring of a scene depends on the time."""
    return not any(e.has_variable for e in scene.time_laws.expressions)


def is_conservative(scene: Scene, model: ModuleType) -> bool:
    """Whether a scene conserves its energy."""
    return is_autonomous(scene) and not loads_at_work(model) and not scene.states


def zero_exponents(scene: Scene, model: ModuleType) -> dict[str, int]:
    """Number of zero exponents of a scene, by reason; where it comes to rest there may be fewer
    that are due to the time. Sensors are taken to see every place."""
    found = {"time": 1} if is_autonomous(scene) else {}
    conservative = is_conservative(scene, model)
    if conservative:
        found["energy"] = 1
    if scene.time_laws.feedback or scene.states:
        return found
    terms = [TERMS[name] for name in scene.structure.loads]
    anchored = any(term.holds_joints for term in terms)
    along = (t for t in terms if not (t.follows or t.is_damping or t.at_joints))
    directed = [t for t in along if t.kind != COUPLE]
    blind = not (
        anchored or directed or any(t.follows_velocity and t.name not in ALIKE for t in terms)
    )
    moves = scene.boundary_condition.translates
    if moves and not anchored:
        found["place"] = 2
        # The centre falls freely beside all other motion.
        if conservative and not any(term.name == "tip_load" for term in terms):
            found["momentum"] = 2
    turns = moves or scene.rod.boundary == "pinned"
    if blind and turns:
        found["direction"] = 1
        if conservative:
            found["angular momentum"] = 1
    return found
