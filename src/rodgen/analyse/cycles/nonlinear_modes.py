"""Nonlinear normal modes: families of periodic motions of a rod without dissipation, one from each
linear mode, with the energy as their parameter.

Where quantities are conserved, periodic motions are not isolated and the equations of closing are
dependent. Each conserved quantity H adds an unknown e, with e grad H added to the closing: it is
zero in every solution, and the equations are regular (F. J. Munoz-Almaraz et al., Physica D 181
(2003) 1).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rodgen.analyse.analysis_guard import (
    CYCLE,
    check_analysis_memory,
    check_positive,
    check_whole_number,
    guard_analysis,
)
from rodgen.analyse.curves.continuation import StepControl, continue_curve
from rodgen.analyse.curves.curve import Curve, CurvePoint, correct, point_at
from rodgen.analyse.curves.curve_datasets import SPECIAL_ROWS, CurveFormat, make_dataset
from rodgen.analyse.cycles.cycle_problem import OrbitProblem
from rodgen.analyse.cycles.cycle_result import Cycle
from rodgen.analyse.cycles.cycle_search import CycleSearch, check_segments
from rodgen.analyse.cycles.elimination import Complex
from rodgen.analyse.cycles.flow import ConservedQuantities, Flow
from rodgen.analyse.cycles.periodicity import Orbit
from rodgen.analyse.cycles.shooting import SEGMENTS, Shooting
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.analyse.steady_state import find_steady_state
from rodgen.arrays import Array
from rodgen.dataset_result import POINT, SPECIAL
from rodgen.errors import AnalysisError, InputError
from rodgen.result import Row
from rodgen.scene import Scene
from rodgen.system import System

if TYPE_CHECKING:
    import xarray

FORMAT = CurveFormat(
    "rodgen mode 1",
    "a nonlinear mode",
    (
        Row("energy", "energy above rest", "J", along=POINT),
        Row("frequency", "frequency", "Hz", along=POINT),
        Row("period", "period", "s", along=POINT),
        Row("amplitude", "amplitude of the angles", "rad", along=POINT),
        Row("unstable", "multipliers larger than 1", along=POINT),
        Row("energy_error", "relative change of the energy over a period", along=POINT),
        Row("multipliers", "other multipliers", along=POINT),
        Row("y0", "state on the motion", along=POINT),
        Row("linear_frequency", "frequency of the linear mode", "Hz"),
        Row("end", "ends"),
        *SPECIAL_ROWS,
        Row("special_energy", "energy above rest", "J", along=SPECIAL),
    ),
    {"multipliers": ("multiplier", "part"), "y0": ("state",)},
    {"part": ["re", "im"]},
)
SMALL = 1e-4  # root of the share of the energy: the first motion of a family
STEP = 0.05
MOST = 400  # points
GROWS = 1e-4  # by which a multiplier exceeds 1: beside others on the unit circle, roundings count
STILL = 1e-6  # of the fastest frequency: a slower motion is none
SAMPLES = 64  # of a period
TRIAL = 1e-3  # rad: a motion by whose energy others are sized


class ModeFamily(OrbitProblem):
    """Continuation problem of the periodic motions of a mode. u ends with an unknown for each
    conserved quantity, zero in solutions, and the root of energy over the largest energy."""

    growth = GROWS

    def __init__(self, flow: Flow, rest: Array, orbit: Orbit, energy: float):
        """rest: the state (size,) about which it swings; energy: the largest above it [J]."""
        self.flow, self.energy, self.conserved = flow, energy, ConservedQuantities(flow)
        self.lowest = self.conserved.values(rest)
        self.kept = len(self.lowest)
        super().__init__(flow.quotient, orbit, self.kept + 1)
        self.set_phase(Shooting(flow), orbit)

    @property
    def trivial(self) -> int:
        return 2 * self.kept

    def shooting(self, u: Array) -> Shooting:
        return Shooting(self.flow)

    def pack(self, orbit: Orbit) -> Array:
        """Pack an orbit into u."""
        above = float(self.conserved.values(orbit.x[0])[0] - self.lowest[0])
        root = np.sqrt(max(above, 0) / self.energy)
        return np.concatenate([*self.pack_orbit(orbit), np.zeros(self.kept), [root]])

    def evaluate(self, u: Array) -> tuple[Array, Array]:
        orbit, _ = self.orbit_and_linearisation(u)
        F, J, first = self.closing_equations(u)
        size, states = len(self.scale), self.states
        gradients = self.conserved.gradients(orbit.x[0])
        extra = slice(first, first + self.kept)
        pushes = gradients / self.scale
        pushes /= np.linalg.norm(pushes, axis=1, keepdims=True)
        J[states - size : states, extra] = pushes.T
        F[states - size : states] += pushes.T @ u[extra]
        values = self.conserved.values(orbit.x[0])
        rows = slice(len(F) - self.kept, len(F))
        J[rows, :size] = gradients * self.scale / self.energy
        F[rows] = (values - self.lowest) / self.energy
        J[rows.start, -1], F[rows.start] = -2 * u[-1], F[rows.start] - u[-1] ** 2
        return F, J


class _Rest(NamedTuple):
    """A scene at rest: its search, the flow, the state x (size,), and the frequencies [rad/s] and
    shapes (size, k) of all modes that oscillate, the slowest first."""

    search: CycleSearch
    flow: Flow
    x: Array
    frequencies: Array
    shapes: Complex


def _find_rest(system: System, target: str | None) -> _Rest:
    check_analysis_memory(CYCLE, system)
    search = CycleSearch.of(system, target)
    if not search.is_conservative:
        what = ", ".join(search.working_loads) or "loads that change"
        raise InputError("mode", system.name, f"of a scene without dissipation (it has {what})")
    state = find_steady_state(SteadyRod.of(search.system))
    y = state.rod.state_at_rest(state.at)
    flow = search.flow(0.0, y)
    x = y[flow.quotient.kept]
    s, vectors = np.linalg.eig(flow.jacobian(0.0, x))
    swings = np.flatnonzero(s.imag > STILL * np.abs(s).max())
    order = swings[np.argsort(s[swings].imag)]
    angles = vectors[: flow.quotient.positions, order]
    largest = angles[np.abs(angles).argmax(axis=0), np.arange(len(order))]
    return _Rest(search, flow, x, s[order].imag, vectors[:, order] / largest)


def _make_family(
    rest: _Rest, mode: int, energy: float, segments: int
) -> tuple[ModeFamily, CurvePoint]:
    """Set up the family of a mode, and its first motion."""
    mode = check_whole_number(mode, "mode", 1)
    energy = check_positive(energy, "energy", "above 0 J, the energy of rest")
    if mode > len(rest.frequencies):
        allowed = f"the number of a mode that swings, 1 to {len(rest.frequencies)}"
        raise InputError("mode", mode, allowed)
    q = rest.shapes[:, mode - 1]
    size = SMALL * TRIAL * np.sqrt(energy / _energy_above_rest(rest, q))
    orbits = []
    for times in (1.0, 2.0):
        turned = np.exp(2j * np.pi * np.arange(segments) / segments)
        x = rest.x + times * size * (turned[:, None] * q).real
        orbits.append(Orbit(x, 0.0, 2 * np.pi / rest.frequencies[mode - 1], 0.0, times * size))
    family = ModeFamily(rest.flow, rest.x, orbits[0], energy)
    guess, larger = (family.pack(one) for one in orbits)
    row = np.append(np.zeros(len(guess) - 1), 1.0)
    found = correct(family, guess, row)
    return family, point_at(family, found, (larger - guess) / family.length(larger - guess))


def _energy_above_rest(rest: _Rest, q: Complex) -> float:
    """Energy above rest [J] of a small motion along a shape."""
    conserved = ConservedQuantities(rest.flow)
    moved, still = (conserved.values(x)[0] for x in (rest.x + TRIAL * q.real, rest.x))
    return float(moved - still)


def _follow_family(family: ModeFamily, first: CurvePoint, step: float, max_points: int) -> Curve:
    """Follow the family from its first motion up to the largest energy."""
    steps = StepControl.of(step, max_points, 10, 1e-7)
    return continue_curve(family, first, 0.0, 1.0, steps)


@guard_analysis
def continue_mode(
    system: System | Scene,
    mode: int = 1,
    energy: float = 1.0,
    *,
    segments: int = SEGMENTS,
    step: float = STEP,
    max_points: int = MOST,
    target: str | None = None,
) -> xarray.Dataset:
    """Follow the periodic motions that begin with a linear mode of a scene without dissipation.

    Parameters
    ----------
    system
        The scene, or a System.
    mode
        Number of the mode, 1 is the slowest.
    energy
        Energy above rest [J], up to which the family is followed.
    segments
        Number of parts into which the period is cut, as in `find_cycle`.
    step
        Length of the longest step along the family, dimensionless.
    max_points
        Largest number of points.
    target
        "c" or "numpy"; if not given, C where it can be built.

    Returns
    -------
    xarray.Dataset
        One dimension along the family: energy [J] above rest, frequency [Hz], period [s], amplitude
        (the largest deviation of an angle [rad]), unstable, multipliers (in two columns), y0,
        energy_error (the largest change along the motion, over the energy); special points; as
        attributes linear_frequency [Hz] and why the family ends.

    Raises
    ------
    InputError
        For a scene with dissipation or changing loads.
    AnalysisError
        If no family of motions is found.
    BranchInterrupted
        On Ctrl-C. It carries the points so far.

    Examples
    --------
    A pendulum swings the slower the farther it swings:

    >>> import rodgen
    >>> scene = rodgen.Scene.from_dict({
    ...     "name": "pendulum",
    ...     "rod": {"links": 1, "length": 1.0, "mass": 1.0, "bending_stiffness": 0.0,
    ...             "boundary": "pinned"},
    ...     "loads": {"gravity": {}},
    ...     "initial": {"phi": -1.5707963267948966},
    ... })
    >>> family = rodgen.continue_mode(scene, 1, 3.0)
    >>> bool(family.frequency[-1] < family.attrs["linear_frequency"])
    True
    """
    rest = _find_rest(System.of(system), target)
    family, first = _make_family(rest, mode, energy, check_segments(segments))
    curve = _follow_family(family, first, step, max_points)
    return make_dataset(curve, lambda: _dataset(rest, family, curve, mode))


def _dataset(rest: _Rest, family: ModeFamily, curve: Curve, mode: int) -> xarray.Dataset:
    rows = [_point_values(family, point.u) for point in curve.points]
    values = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    values["special_energy"] = np.array(
        [float(s.u[-1]) ** 2 * family.energy for s in curve.special]
    )
    said = {"mode": mode, "linear_frequency": float(rest.frequencies[mode - 1]) / (2 * np.pi)}
    return FORMAT.dataset(rest.search.system.scene, curve, 0.0, values, said)


def _point_values(family: ModeFamily, u: Array) -> dict[str, Any]:
    """Values of the motion at u, by the names of variables."""
    x, values = family.sample_motion(u, SAMPLES)
    above = np.array([family.conserved.values(one)[0] for one in x]) - family.lowest[0]
    return values | {
        "energy": float(above[0]),
        "frequency": 1 / values["period"],
        "energy_error": float(np.ptp(above) / above[0]),
    }


@guard_analysis
def nonlinear_mode(
    system: System | Scene,
    mode: int = 1,
    energy: float = 1.0,
    *,
    segments: int = SEGMENTS,
    target: str | None = None,
) -> Cycle:
    """Return the periodic motion with a given energy, of the family of a linear mode.

    Parameters
    ----------
    system
        A scene without dissipation, or a System.
    mode
        Number of the mode, 1 is the slowest.
    energy
        Energy above rest [J].
    segments
        Number of parts into which the period is cut, as in `find_cycle`.
    target
        "c" or "numpy"; if not given, C where it can be built.

    Returns
    -------
    Cycle
        The motion, its period [s] and multipliers.

    Raises
    ------
    InputError
        For a scene with dissipation or changing loads.
    AnalysisError
        If there is no motion with this energy.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.from_dict({
    ...     "name": "pendulum",
    ...     "rod": {"links": 1, "length": 1.0, "mass": 1.0, "bending_stiffness": 0.0,
    ...             "boundary": "pinned"},
    ...     "loads": {"gravity": {}},
    ...     "initial": {"phi": -1.5707963267948966},
    ... })
    >>> cycle = rodgen.nonlinear_mode(scene, 1, 2.0)
    >>> bool(1.0 < cycle.period < 3.0)
    True
    """
    return _cycle_at_energy(
        _find_rest(System.of(system), target), mode, energy, check_segments(segments)
    )


def _cycle_at_energy(rest: _Rest, mode: int, energy: float, segments: int) -> Cycle:
    family, first = _make_family(rest, mode, energy, segments)
    curve = _follow_family(family, first, 2 * STEP, MOST).raise_interrupt()
    if not curve.complete:
        reached = family.energy * curve.points[-1].value ** 2
        raise AnalysisError(
            f"mode {mode} was followed up to {reached:.6g} J above rest: {curve.end}"
        )
    orbit = family.orbit(curve.points[-1].u)
    scale = float(np.ptp(orbit.x, axis=0).max())
    shooting = Shooting(family.flow)
    return rest.search.make_cycle(
        shooting, shooting.complete(replace(orbit, scale=scale)), family.trivial
    )


def mode_of_initial_state(system: System, segments: int, target: str | None) -> Cycle:
    """Find the periodic motion with the energy of a system's initial state, of the mode that has
    most of it. Raises AnalysisError for a rod that begins at rest."""
    rest = _find_rest(system, target)
    conserved = ConservedQuantities(rest.flow)
    x = rest.search.system.y0[rest.flow.quotient.kept]
    energy = float(conserved.values(x)[0] - conserved.values(rest.x)[0])
    shares, *_ = np.linalg.lstsq(
        np.hstack((rest.shapes.real, rest.shapes.imag)), x - rest.x, rcond=None
    )
    count = len(rest.frequencies)
    energies = [
        (shares[k] ** 2 + shares[count + k] ** 2) * _energy_above_rest(rest, rest.shapes[:, k])
        for k in range(count)
    ]
    if not (energy > 0 and max(energies, default=0.0) > 0):
        raise AnalysisError("no cycle: the rod begins at rest, and nothing moves it")
    return _cycle_at_energy(rest, int(np.argmax(energies)) + 1, energy, segments)
