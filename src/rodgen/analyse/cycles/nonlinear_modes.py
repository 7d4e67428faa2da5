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

from rodgen.analyse.curves.continuation import Steps, continued
from rodgen.analyse.curves.curve import Curve, Point, corrected, point_at
from rodgen.analyse.curves.datasets import SPECIAL_ROWS, attributes, kept, special_values
from rodgen.analyse.cycles.closing import Orbit
from rodgen.analyse.cycles.conserved import Conserved
from rodgen.analyse.cycles.cycle import Cycle, nontrivial
from rodgen.analyse.cycles.elimination import Complex
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.cycles.orbits import Orbits
from rodgen.analyse.cycles.search import Search, segments_of
from rodgen.analyse.cycles.shooting import SEGMENTS, Shooting, cut
from rodgen.analyse.guard import guarded
from rodgen.analyse.sizes import CYCLE, check_size
from rodgen.analyse.steady import steady
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.arrays import Array
from rodgen.dataset_result import POINT, SPECIAL, variables
from rodgen.errors import AnalysisError, InputError
from rodgen.result import Row
from rodgen.scene import Scene
from rodgen.scene.plain import is_number, plain
from rodgen.system import System

if TYPE_CHECKING:
    import xarray

FORMAT = "rodgen mode 1"
DIMS = {"multipliers": ("multiplier", "part"), "y0": ("state",)}
ROWS = (
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
)
SMALL = 1e-4  # root of the share of the energy: the first motion of a family
STEP = 0.05
MOST = 400  # points
GROWS = 1e-4  # by which a multiplier exceeds 1: beside others on the unit circle, roundings count
STILL = 1e-6  # of the fastest frequency: a slower motion is none
SAMPLES = 64  # of a period
TRIAL = 1e-3  # rad: a motion by whose energy others are sized


class Family(Orbits):
    """The motions of a mode; beside their own unknowns one for each conserved quantity, which is
    zero, and the root of the energy over the largest."""

    def __init__(self, flow: Flow, rest: Array, orbit: Orbit, energy: float):
        """rest: the state (size,) about which it swings; energy: the largest above it [J]."""
        self.flow, self.energy, self.conserved = flow, energy, Conserved(flow)
        self.lowest = self.conserved.values(rest)
        self.kept = len(self.lowest)
        super().__init__(flow.quotient, orbit, self.kept + 1)
        self.look_from(orbit)

    @property
    def trivial(self) -> int:
        """How many multipliers are 1 all along."""
        return 2 * self.kept

    def look_from(self, orbit: Orbit) -> None:
        """Let the phase be that of an orbit."""
        self.look_along(Shooting(self.flow).directions(orbit), orbit)

    def shooting(self, u: Array) -> Shooting:
        return Shooting(self.flow)

    def packed(self, orbit: Orbit) -> Array:
        """u of an orbit."""
        above = float(self.conserved.values(orbit.x[0])[0] - self.lowest[0])
        root = np.sqrt(max(above, 0) / self.energy)
        return np.concatenate([*self.start_of(orbit), np.zeros(self.kept), [root]])

    def at(self, u: Array) -> tuple[Array, Array]:
        orbit, _ = self.known(u)
        F, J, first = self.closing(u)
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

    def unstable(self, u: Array) -> int:
        left = nontrivial(self.multipliers(u), self.trivial)
        return int((np.abs(left) > 1 + GROWS).sum())


class _Rest(NamedTuple):
    """A search, its flow about rest, the state of rest (size,), and of all modes that swing the
    frequencies [rad/s] and shapes (size, k), the slowest first."""

    search: Search
    flow: Flow
    x: Array
    frequencies: Array
    shapes: Complex


def _prepared(system: System, target: str | None) -> _Rest:
    check_size(CYCLE, system)
    search = Search.of(system, target)
    if not search.conservative:
        what = ", ".join(search.at_work) or "loads that change"
        raise InputError("mode", system.name, f"of a scene without dissipation (it has {what})")
    state = steady(SteadyRod.of(search.system))
    y = state.rod.at_rest(state.at)
    flow = search.flow(0.0, y)
    x = y[flow.quotient.kept]
    s, vectors = np.linalg.eig(flow.jacobian(0.0, x))
    swings = np.flatnonzero(s.imag > STILL * np.abs(s).max())
    order = swings[np.argsort(s[swings].imag)]
    angles = vectors[: flow.quotient.positions, order]
    largest = angles[np.abs(angles).argmax(axis=0), np.arange(len(order))]
    return _Rest(search, flow, x, s[order].imag, vectors[:, order] / largest)


def _family(rest: _Rest, mode: int, energy: float, segments: int) -> tuple[Family, Point]:
    """The family of a mode, and its first motion."""
    mode, energy = _checked(mode, energy)
    if mode > len(rest.frequencies):
        allowed = f"the number of a mode that swings, 1 to {len(rest.frequencies)}"
        raise InputError("mode", mode, allowed)
    q = rest.shapes[:, mode - 1]
    size = SMALL * TRIAL * np.sqrt(energy / _above(rest, q))
    orbits = []
    for times in (1.0, 2.0):
        turned = np.exp(2j * np.pi * np.arange(segments) / segments)
        x = rest.x + times * size * (turned[:, None] * q).real
        orbits.append(Orbit(x, 0.0, 2 * np.pi / rest.frequencies[mode - 1], 0.0, times * size))
    family = Family(rest.flow, rest.x, orbits[0], energy)
    guess, larger = (family.packed(one) for one in orbits)
    row = np.append(np.zeros(len(guess) - 1), 1.0)
    found = corrected(family, guess, row)
    return family, point_at(family, found, (larger - guess) / family.length(larger - guess))


def _above(rest: _Rest, q: Complex) -> float:
    """Energy above rest [J] of a small motion along a shape."""
    conserved = Conserved(rest.flow)
    moved, still = (conserved.values(x)[0] for x in (rest.x + TRIAL * q.real, rest.x))
    return float(moved - still)


def _followed(family: Family, first: Point, step: float, most: int) -> Curve:
    """The family from its first motion up to the largest energy."""

    def seen(point: Point) -> None:
        family.look_from(family.orbit(point.u))

    steps = Steps(first=step / 10, least=1e-7, longest=step, most=most)
    return continued(family, first, 0.0, 1.0, steps, watch=seen)


def _checked(mode: object, energy: object) -> tuple[int, float]:
    number, most = plain(mode, "mode"), plain(energy, "energy")
    if not (isinstance(number, int) and number >= 1):
        raise InputError("mode", mode, "a whole number of at least 1")
    if not (is_number(most) and 0 < most < np.inf):
        raise InputError("energy", energy, "above 0 J, the energy of rest")
    return number, float(most)


@guarded
def continue_mode(
    system: System | Scene,
    mode: int = 1,
    energy: float = 1.0,
    *,
    segments: int = SEGMENTS,
    step: float = STEP,
    most: int = MOST,
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
    most
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
    rest = _prepared(System.of(system), target)
    family, first = _family(rest, mode, energy, segments_of(segments))
    curve = _followed(family, first, step, most)
    return kept(curve, lambda: _dataset(rest, family, curve, mode))


def _dataset(rest: _Rest, family: Family, curve: Curve, mode: int) -> xarray.Dataset:
    import xarray

    rows = [_row(family, point.u) for point in curve.points]
    values = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    values["unstable"] = np.array([point.unstable for point in curve.points])
    values["special_energy"] = np.array(
        [float(s.u[-1]) ** 2 * family.energy for s in curve.special]
    )
    values |= special_values(curve.special)
    said = attributes(FORMAT, rest.search.system.scene, curve, 0.0) | {
        "mode": mode,
        "linear_frequency": float(rest.frequencies[mode - 1]) / (2 * np.pi),
    }
    return xarray.Dataset(variables(ROWS, values, DIMS), {"part": ["re", "im"]}, said)


def _row(family: Family, u: Array) -> dict[str, Any]:
    """What there is to say of the motion of u."""
    orbit, q = family.orbit(u), family.flow.quotient
    x = cut(family.flow, orbit.t, orbit.x[0], orbit.period, SAMPLES)
    angles = x[:, q.angles]
    if q.turns:
        angles = angles - angles.mean(axis=1, keepdims=True)
    above = np.array([family.conserved.values(one)[0] for one in x]) - family.lowest[0]
    left = nontrivial(family.multipliers(u), family.trivial)
    return {
        "energy": float(above[0]),
        "frequency": 1 / orbit.period,
        "period": orbit.period,
        "amplitude": float(np.ptp(angles, axis=0).max()) / 2,
        "multipliers": np.stack((left.real, left.imag), -1),
        "y0": q.lifted(x[0]),
        "energy_error": float(np.ptp(above) / above[0]),
    }


@guarded
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
    return _at_energy(_prepared(System.of(system), target), mode, energy, segments_of(segments))


def _at_energy(rest: _Rest, mode: int, energy: float, segments: int) -> Cycle:
    family, first = _family(rest, mode, energy, segments)
    curve = _followed(family, first, 2 * STEP, MOST).uninterrupted()
    if not curve.complete:
        reached = family.energy * curve.points[-1].value ** 2
        raise AnalysisError(
            f"mode {mode} was followed up to {reached:.6g} J above rest: {curve.end}"
        )
    orbit = family.orbit(curve.points[-1].u)
    scale = float(np.ptp(orbit.x, axis=0).max())
    shooting = Shooting(family.flow)
    return rest.search.cycle(shooting, shooting.closed(replace(orbit, scale=scale)), family.trivial)


def of_start(system: System, segments: int, target: str | None) -> Cycle:
    """The periodic motion of a system without dissipation with the energy of its initial state, of
    the mode that has most of it. Raises AnalysisError for a rod that begins at rest."""
    rest = _prepared(system, target)
    conserved = Conserved(rest.flow)
    x = rest.search.system.y0[rest.flow.quotient.kept]
    energy = float(conserved.values(x)[0] - conserved.values(rest.x)[0])
    shares, *_ = np.linalg.lstsq(
        np.hstack((rest.shapes.real, rest.shapes.imag)), x - rest.x, rcond=None
    )
    count = len(rest.frequencies)
    energies = [
        (shares[k] ** 2 + shares[count + k] ** 2) * _above(rest, rest.shapes[:, k])
        for k in range(count)
    ]
    if not (energy > 0 and max(energies, default=0.0) > 0):
        raise AnalysisError("no cycle: the rod begins at rest, and nothing moves it")
    return _at_energy(rest, int(np.argmax(energies)) + 1, energy, segments)
