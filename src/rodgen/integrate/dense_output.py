"""Dense output of a run: states between its samples, integrated anew from the sample before."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.events import EventDetector
from rodgen.integrate.methods.method_choice import LEAST_NEWTON, choose, make_integrator
from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.integrate.recorder import Recorder
from rodgen.integrate.run_status import FINISHED
from rodgen.integrate.stepper import StepError
from rodgen.integrate.stretches import Stretches, with_span
from rodgen.integrate.trajectory import Trajectory
from rodgen.scene.integration import AUTO, IntegrationTable

SHARE = 0.1  # of the tolerance


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
        self._stretches = Stretches.of(scene.time_functions, scene.integrate.has_fixed_step)
        self._switches = () if scene.integrate.has_fixed_step else scene.time_functions.switches()
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
                stretches = self._stretches.until(float(times[-1]))
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
    start = trajectory.scene.integrate.span[0]
    if trajectory.scene.integrate.t_eval is None or (
        len(trajectory.t) and trajectory.t[0] == start
    ):
        return trajectory.t, trajectory.y
    y0 = trajectory.scene.initial_state()
    return np.append(start, trajectory.t), np.concatenate((y0[None], trajectory.y))


def _time_bounds(trajectory: Trajectory, t: Array) -> tuple[float, float]:
    """Bounds of the time that the run has covered [s]; t: times at which its state is known."""
    if not len(t):
        raise InputError("solution", trajectory, "one with samples")
    settings = trajectory.scene.integrate
    # One that an event has ended says so.
    whole = trajectory.status == FINISHED and not trajectory.message
    last = settings.span[1] if whole and settings.t_eval is not None else t[-1]
    return float(t[0]), float(last)
