"""Dense output of a run: states between its samples, integrated anew from the sample before; and
the growth of small errors, by a neighbouring motion that is brought back again and again.

G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9-20.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.events import EventDetector
from rodgen.integrate.methods.method_choice import LEAST_NEWTON, choose, make_integrator
from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.integrate.recorder import Recorder
from rodgen.integrate.stepper import FINISHED, StepError
from rodgen.integrate.stretches import Stretches, with_span
from rodgen.integrate.trajectory import ErrorGrowth, Trajectory
from rodgen.scene.integration import AUTO, IntegrationTable

SHARE = 0.1  # of the tolerance

# Of the growth of errors.
NEIGHBOUR_SHARE = 0.01  # of the run's tolerance, that of both motions
ABOVE = 1e3  # times that tolerance: what sets them apart is not the error of their steps
NEAR = 1e-6, 1e-3  # rad: the neighbour at first, at least and at most
FAR = 1e-2  # rad: from here on what is not linear counts
PIECES = 16  # of the run, at least
SHORTEST = 1e-6  # of the run, a piece
LOOKS = 32  # times in a piece at which they are compared, as what swings passes through zero
WAVES = 4  # of a smooth disturbance along the rod
VISIBLE = 1e-3  # rad: errors that are seen,
EXPECTED = 100.0  # where they are more than so many times the tolerance
LARGEST = math.log(np.finfo(float).max)

UNKNOWN = ErrorGrowth(math.nan, math.nan, math.nan)


class DenseOutput:
    """Dense output of a trajectory, by integrating it anew from any of its samples to the next.

    Method and tolerance are those of the run, so that the error is too, whatever the spacing of the
    samples, and none of its steps need be kept. share: of the tolerance of the run, that of the
    repetition. first, last: bounds of its times [s]; settings: of the repetition.
    """

    def __init__(self, trajectory: Trajectory, share: float = SHARE):
        self._model = trajectory.model
        if trajectory.changes is not None:
            allowed = "of a run whose values were not changed while it went on"
            raise InputError("solution", trajectory, allowed)
        self.t, self.y = _known_states(trajectory)
        self.first, self.last = _time_bounds(trajectory, self.t)
        scene = with_span(trajectory.scene, self.first, self.last)
        if scene.integrate.method == AUTO:  # of a run without an end
            scene = scene.with_integrate(method=choose(scene, self._model).method)
        self.settings = _tighten(scene.integrate, share)
        self._stretches = Stretches.of(scene.time_laws, scene.integrate.has_fixed_step)
        self._switches = () if scene.integrate.has_fixed_step else scene.time_laws.switches()
        self._p = trajectory.system.p
        self._works = loads_at_work(self._model)

    def states_at(self, times: NDArray[Any]) -> Array:
        """States (K, states) at times (K,) [s], in any order.

        Raises InputError for times that the run does not reach, StepError where a step fails.
        """
        outside = ~((times >= self.first) & (times <= self.last))
        if outside.any():
            allowed = f"from {self.first!r} to {self.last!r} s, where the run has been"
            raise InputError("t", float(times[outside][0]), allowed)
        asked, place = np.unique(times, return_inverse=True)
        states = np.empty((len(asked), self.y.shape[1]))
        before = np.searchsorted(self.t, asked, side="right") - 1
        for sample in np.unique(before):
            here = before == sample
            states[here] = self._states_from(int(sample), asked[here])
        return states[place]

    def _states_from(self, sample: int, times: Array) -> Array:
        """States at ascending times from one sample on up to the next."""
        t, y = float(self.t[sample]), self.y[sample]
        states = np.empty((len(times), len(y)))
        known = int(times[0] == t)
        states[:known] = y
        if known < len(times):
            states[known:] = self.integrate_from(t, y, times[known:])
        return states

    def integrate_from(self, t: float, y: Array, times: Array) -> Array:
        """Integrate from a state y at time t [s], and return the states (K, states) at later times
        (K,) [s], ascending. Events are not looked for. Raises StepError."""
        try:
            with np.errstate(all="ignore"):
                run = make_integrator(self._model, self._p, self.settings, t, y.copy())
                recorder = Recorder(times, len(y), self._works)
                watch = EventDetector([], self._model, self._p, self._switches)
                stretches = self._stretches.between(t, float(times[-1]))
                stretches.walk(run, recorder, watch, self.settings.step_limit)
        except (StepError, OverflowError) as error:
            message = f"no states between samples after t = {t:.9g} s: {error}"
            raise StepError(message) from None
        return recorder.in_memory()[1]


def _tighten(settings: IntegrationTable, share: float) -> IntegrationTable:
    """Tighten tolerances: a repetition adds its error to the sample's, and is to be small."""
    rtol = min(settings.rtol, max(share * settings.rtol, LEAST_NEWTON))
    return settings.model_copy(update={"rtol": rtol, "atol": share * settings.atol})


def _known_states(trajectory: Trajectory) -> tuple[Array, Array]:
    """Times and states of the samples, and of the start of the run where it is none of them."""
    settings, t, y = trajectory.scene.integrate, trajectory.t, trajectory.y
    if settings.t_eval is None or (len(t) and t[0] == settings.span[0]):
        return t, y
    y0 = trajectory.scene.initial_state()
    return np.append(settings.span[0], t), np.concatenate((y0[None], y))


def _time_bounds(trajectory: Trajectory, t: Array) -> tuple[float, float]:
    """Bounds of the time that the run has covered [s]; t: times at which its state is known."""
    if not len(t):
        raise InputError("solution", trajectory, "one with samples")
    settings = trajectory.scene.integrate
    # One that an event has ended says so.
    whole = trajectory.status == FINISHED and not trajectory.message
    last = settings.span[1] if whole and settings.t_eval is not None else t[-1]
    return float(t[0]), float(last)


def error_growth(trajectory: Trajectory) -> ErrorGrowth:
    """Find how fast small errors grow in the motion of a run, from its start to its last state.

    Two motions are followed by the method of the run, with a hundredth of its tolerance or with its
    fixed step, which costs some three to six times the run. Events are not looked for: none but the
    end of the run changes the motion. Not-a-number where a step fails. Raises InputError for a run
    that was changed while it went on, or has no samples.
    """
    run, scene = DenseOutput(trajectory, NEIGHBOUR_SHARE), trajectory.scene
    fixed, rtol = scene.integrate.has_fixed_step, scene.integrate.rtol
    seen = math.inf if fixed else visible_error(rtol) / rtol
    base = 2 * scene.boundary_condition.translates
    angles = slice(base, (run.y.shape[1] - len(scene.states)) // 2)
    try:
        return _follow_neighbour(run, angles, math.log(seen))
    except StepError:
        return UNKNOWN


def visible_error(rtol: float) -> float:
    """Error [rad] from which on it counts as seen in a run with this tolerance."""
    return max(VISIBLE, EXPECTED * rtol)


def _follow_neighbour(run: DenseOutput, angles: slice, seen: float) -> ErrorGrowth:
    """Follow both motions; angles: which states are; seen: logarithm of a visible factor."""
    at, y = run.first, run.y[0]
    near, least = _initial_distance(run.settings), SHORTEST * (run.last - at)
    off = start = _disturbance(len(y), angles, near)
    piece = (run.last - at) / PIECES
    grown, most, when = 0.0, 0.0, math.inf  # logarithms, and a time
    while run.last - at > least:
        times = np.linspace(at, min(at + piece, run.last), LOOKS + 1)[1:]
        here, there = (run.integrate_from(at, state, times) for state in (y, y + off))
        apart = np.linalg.norm((there - here)[:, angles], axis=1)
        largest = apart.max()
        if largest > FAR and piece > least:
            piece /= 2
            continue
        over = apart > near * math.exp(min(seen - grown, LARGEST))
        if over.any():
            when = min(when, float(times[over][0]))
        at, y = float(times[-1]), here[-1]
        # New errors come all the time: what has died out does not keep them from growing.
        grown = max(0.0, grown + math.log(largest / near)) if largest else 0.0
        most = max(most, grown)
        off = (there[-1] - here[-1]) * (near / largest) if largest else start
    factor = math.exp(most) if most < LARGEST else math.inf
    decades = most / math.log(10.0)
    tenfold = (run.last - run.first) / decades if decades else math.inf
    return ErrorGrowth(factor, tenfold, when)


def _initial_distance(settings: IntegrationTable) -> float:
    """Initial distance of the neighbour [rad]."""
    least, largest = NEAR
    if settings.has_fixed_step:  # both make the same errors
        return least
    return min(largest, max(least, ABOVE * max(settings.rtol, settings.atol)))


def _disturbance(states: int, angles: slice, size: float) -> Array:
    """Disturbance of the angles, (states,), of this norm [rad]: half smooth along the rod, half
    rough, as either may be what grows."""
    links = angles.stop - angles.start
    random = np.random.default_rng(1)
    s = (np.arange(links) + 0.5) / links
    smooth = random.standard_normal(WAVES) @ np.cos(np.pi * np.outer(np.arange(WAVES), s))
    rough = random.standard_normal(links)
    shape = smooth / np.linalg.norm(smooth) + rough / np.linalg.norm(rough)
    off = np.zeros(states)
    off[angles] = shape * (size / np.linalg.norm(shape))
    return off
