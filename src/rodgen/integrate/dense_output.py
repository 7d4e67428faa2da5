"""States between the samples of a run: integrated anew, from the sample before."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.catalogue import loads_at_work
from rodgen.integrate.endings import FINISHED
from rodgen.integrate.events import Watch
from rodgen.integrate.methods.choose import LEAST_NEWTON, choose, machine
from rodgen.integrate.samples import Recorder
from rodgen.integrate.stepper import StepError
from rodgen.integrate.stretches import STRIDE, Stretches, inside, window
from rodgen.integrate.trajectory import Trajectory
from rodgen.scene.integration import AUTO, Integrate

SHARE = 0.1  # of the tolerance


class DenseOutput:
    """The run of a trajectory from any of its samples to the next, by its method and tolerance.

    So the error is that of the run, whatever the spacing of the samples, and there is nothing to
    keep of its steps. share: of the tolerance of the run, that of its repetition. first, last: from
    when to when [s] it can be asked; settings: how it steps.
    """

    def __init__(self, trajectory: Trajectory, share: float = SHARE):
        self._model = trajectory.model
        if trajectory.changes is not None:
            allowed = "of a run whose values were not changed while it went on"
            raise InputError("solution", trajectory, allowed)
        self.t, self.y = _known(trajectory)
        self.first, self.last = _reach(trajectory, self.t)
        scene = window(trajectory.scene, self.first, self.last)
        if scene.integrate.method == AUTO:  # of a run without an end
            scene = scene.with_integrate(method=choose(scene, self._model).method)
        self.settings = _tightened(scene.integrate, share)
        stretches = Stretches.of(scene.course, scene.integrate.fixed)
        self._swing, self._ends = stretches.swing, np.array(stretches.ends)
        self._switches = () if scene.integrate.fixed else scene.course.switches()
        self._p = trajectory.system.p
        self._works = loads_at_work(self._model)

    def at(self, times: NDArray[Any]) -> Array:
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
            states[here] = self._from(int(sample), asked[here])
        return states[place]

    def _from(self, sample: int, times: Array) -> Array:
        """States at times, ascending, from one sample on up to the next."""
        t, y = float(self.t[sample]), self.y[sample]
        states = np.empty((len(times), len(y)))
        known = int(times[0] == t)
        states[:known] = y
        if known < len(times):
            states[known:] = self.after(t, y, times[known:])
        return states

    def after(self, t: float, y: Array, times: Array) -> Array:
        """States (K, states) at times (K,) [s], ascending, of the motion that is in a state y at a
        time t [s] before them. Events are not looked for. Raises StepError."""
        last = float(times[-1])
        met = self._ends[(self._ends > t) & (self._ends < last)]
        try:
            with np.errstate(all="ignore"):
                run = machine(self._model, self._p, self.settings, t, y.copy())
                recorder = Recorder(times, len(y), self._works)
                watch = Watch([], self._model, self._p, self._switches)
                for end in [*map(float, met), last]:
                    run.begin(end, *inside(run.t, end), self._swing)
                    while not run.advance(recorder, watch, STRIDE):
                        if run.counts.nsteps > self.settings.budget:
                            raise StepError("the budget of steps is used up")
        except (StepError, OverflowError) as error:
            message = f"no states between samples after t = {t:.9g} s: {error}"
            raise StepError(message) from None
        return recorder.kept()[1]


def _tightened(settings: Integrate, share: float) -> Integrate:
    """A method that begins anew adds its error to that of the sample: it is to be the smaller."""
    rtol = min(settings.rtol, max(share * settings.rtol, LEAST_NEWTON))
    return settings.model_copy(update={"rtol": rtol, "atol": share * settings.atol})


def _known(trajectory: Trajectory) -> tuple[Array, Array]:
    """The samples, and the start of the run where it comes before the first of them."""
    start = trajectory.scene.integrate.span[0]
    if trajectory.scene.integrate.t_eval is None or (
        len(trajectory.t) and trajectory.t[0] == start
    ):
        return trajectory.t, trajectory.y
    y0 = trajectory.scene.initial_state()
    return np.append(start, trajectory.t), np.concatenate((y0[None], trajectory.y))


def _reach(trajectory: Trajectory, t: Array) -> tuple[float, float]:
    """From when to when the run has been; t: times at which its state is known."""
    if not len(t):
        raise InputError("solution", trajectory, "one with samples")
    settings = trajectory.scene.integrate
    # One that an event has ended says so.
    whole = trajectory.status == FINISHED and not trajectory.message
    last = settings.span[1] if whole and settings.t_eval is not None else t[-1]
    return float(t[0]), float(last)
