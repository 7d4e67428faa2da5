"""Result of a run, and the exceptions that carry the result of one that did not finish."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property, partial
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.arrays import Array
from rodgen.display import Plottable, result_drawing
from rodgen.errors import InputError
from rodgen.integrate.air_doubts import air_doubts
from rodgen.integrate.dense_output import DenseOutput
from rodgen.integrate.files import storage
from rodgen.integrate.stepper import StepError
from rodgen.integrate.trajectory import Trajectory
from rodgen.result import REMARK, Note, Result, ResultTable, Row, doubt, omit_from_tables

if TYPE_CHECKING:
    import pandas
    import xarray

    from rodgen.display import VideoData

SHOWN = 10  # events
# Members that only quantities and studies read.
PARTS = {
    *("extra_states", "evaluate", "has_feedback", "energy_input", "boundary_condition"),
    *("names", "run_notes", "isel", "time_dependent_loads", "head", "has_parameter"),
}
COUNTED = (
    ("nsteps", "steps"),
    ("rejected", "rejected steps"),
    ("nfev", "evaluations of the rates"),
    ("njev", "evaluations of their Jacobian"),
    ("nlu", "factorisations of matrices"),
)


# A row that tables leave out.
_hidden_row = partial(Row, text=omit_from_tables)


def _span_text(run: Solution) -> str:
    return f", t = {run.t[0]:g} to {run.t[-1]:g} s" if len(run.t) else ""


def _method_text(run: Solution) -> str:
    stats = run.stats
    rejected = f" ({stats.rejected} rejected)" if stats.rejected else ""
    return f"{run.method}, {stats.nsteps} steps{rejected}, {stats.nfev} evaluations"


def _time_taken(run: Solution) -> str:
    target = f", target {run.stats.target}" if run.stats.target else ""
    return f"{run.stats.wall_seconds:.3g} s{target}"


def _events_text(run: Solution) -> str | None:
    shown = [f"{event.name} at {event.t:.6g} s" for event in run.events[:SHOWN]]
    left = len(run.events) - len(shown)
    return ", ".join(shown) + f" and {left} more" * bool(left) or None


def _tip(run: Solution) -> Array | None:
    return run.tip[-1] if len(run.t) else None


def _tip_text(run: Solution) -> str | None:
    at = _tip(run)
    return None if at is None else f"({at[0]:.6g}, {at[1]:.6g}) m"


class Solution(Trajectory, Result, Plottable):
    """States of a scene over time.

    system: what was run; t: times [s], (T,); y: states in SI units and the order of the module's
    STATE, (T, states); stats: numbers of steps and of calls, and the seconds; work: work done by
    each load without potential since the start [J], by term, each (T,); status: "finished",
    "failed", "chatters", "bounces" or "interrupted"; message: how the run ended; model: the
    generated module, built when it is first used if the solution comes from a file; events: that
    happened; changes: parameters at each sample of a live run whose values were changed, else None;
    errors: growth of small errors, if that was asked for (a file does not keep it); run_notes: what
    was doubtful before the first step.

    Examples
    --------
    >>> import rodgen
    >>> sol = rodgen.simulate(rodgen.Scene.example("missile"), progress=False)
    >>> sol.y.shape == (len(sol.t), 44), sol.centre_of_gravity.shape == (len(sol.t), 2)
    (True, True)
    >>> sol.values("axial_force").shape[1], float(sol.parameter("mass")[0])
    (19, 20.0)
    >>> thrust, axes = sol.forces["follower"], sol.principal_axes
    >>> thrust.shape == (len(sol.t), 21, 2), axes.moments.shape == (len(sol.t), 2)
    (True, True)
    >>> gained = sol.energy.total - sol.start_energy
    >>> float(abs(gained - sol.total_work - sol.energy_balance).max()) < 1e-9
    True
    >>> early = rodgen.simulate(sol.scene, span=(0, 1), error_growth=True, progress=False)
    >>> early.error_growth > 1, len(early.inertia)
    (True, 3)
    """

    ROWS = (
        _hidden_row("name", "scene", of=lambda run: run.scene.name),
        Row(
            "status",
            "status",
            text=lambda run: f"{run.status}: {run.message}" if run.message else run.status,
        ),
        _hidden_row("message", "message"),
        Row(
            "samples",
            "samples",
            of=lambda run: len(run.t),
            text=lambda run: f"{len(run.t)} of {run.y.shape[-1]} states{_span_text(run)}",
        ),
        _hidden_row("states", "states", of=lambda run: run.y.shape[-1]),
        _hidden_row("end", "end", "s", of=lambda run: run.t[-1] if len(run.t) else None),
        Row("method", "method", text=_method_text),
        *(_hidden_row(name, words, of=attrgetter(f"stats.{name}")) for name, words in COUNTED),
        Row("seconds", "time taken", "s", of=attrgetter("stats.wall_seconds"), text=_time_taken),
        _hidden_row("target", "module", of=attrgetter("stats.target")),
        Row(
            "events",
            "events",
            of=lambda run: [{"name": event.name, "t": event.t} for event in run.events],
            text=_events_text,
        ),
        Row("tip", "tail at the end", "m", of=_tip, text=_tip_text),
        _hidden_row(
            *("work", "work of {} until the end", "J", ".6g"),
            of=lambda run: {name: float(work[-1]) for name, work in run.work.items() if len(work)},
        ),
        Row(
            *("energy_error", "energy balances to", "J"),
            of=lambda run: run.energy_error if len(run.t) else None,
            text=lambda run: f"{run.energy_error:.2e} J" if len(run.t) else None,
        ),
        _hidden_row(
            *("errors", "growth of small errors"),
            of=lambda run: None if run.errors is None else run.errors._asdict(),
        ),
    )

    @property
    def notes(self) -> tuple[Note, ...]:  # type: ignore[override]  # a field of other results
        """Notes on the numbers: doubts before the first step, on the air and, if asked for, on the
        growth of errors."""
        return (*self.run_notes, *self._air_notes, *self._growth_notes)

    @cached_property
    def _air_notes(self) -> tuple[Note, ...]:
        """Doubts about what the air does."""
        return tuple(air_doubts(self.scene, self))

    def to_dict(self) -> dict[str, Any]:
        """Rows by name and notes, as plain data for JSON."""
        with np.errstate(all="ignore"):  # of a run that blew up
            return super().to_dict()

    def tables(self) -> list[ResultTable]:
        """Tables of the rows in words."""
        with np.errstate(all="ignore"):
            return super().tables()

    @property
    def method(self) -> str:
        """Name of the method."""
        return self.system.settings.method

    @property
    def _growth_notes(self) -> Iterator[Note]:
        """Note that late angles are not to be trusted, or that this is not known."""
        if self.errors is None:
            return
        if math.isnan(self.errors.factor):
            yield Note(REMARK, "how fast errors grow is not known: a motion beside the run failed")
        elif self.errors.visible < math.inf:
            words = f"angles after t = {self.errors.visible:.3g} s are not to be trusted: errors "
            words += f"grow tenfold in {self.errors.tenfold:.2g} s"
            yield doubt(words, **self.errors._asdict())

    def __dir__(self) -> list[str]:
        """Names that an editor offers: all but those which only extensions of rodgen need."""
        return [name for name in super().__dir__() if name not in PARTS]

    def __repr__(self) -> str:
        said = f" ({self.message})" if self.message else ""
        what = f"{len(self.t)} samples of {self.y.shape[-1]} states{_span_text(self)}"
        return f"<Solution of {self.scene.name}: {what}; {self.status}{said}>"

    def __call__(self, t: float | Array) -> Array:
        """States between samples: (states,) at a time t [s], (states, K) at times (K,).

        The run is taken up from the sample before, by its method and with its tolerance; at a
        sample it is the sample. Raises InputError for times that the run has not reached and for a
        run that was changed while it went on, RunError where a step fails.
        """
        times = np.asarray(t)
        if times.dtype.kind not in "iuf" or times.ndim > 1:
            raise InputError("t", t, "a time in seconds, or an array (K,) of them")
        try:
            states = self._between.states_at(np.atleast_1d(times).astype(float)).T
        except StepError as error:
            raise RunError(str(error), self) from None
        return states if times.ndim else states[:, 0]

    @cached_property
    def _between(self) -> DenseOutput:
        return DenseOutput(self)

    def to_xarray(self) -> xarray.Dataset:
        """All quantities with names, dimensions and units."""
        return storage.to_xarray(self)

    def to_pandas(self) -> pandas.DataFrame:
        """One row a sample, over the time t [s], with a column for every number, named as events
        and studies name them: phi_0, tip_x, joint_3_y; units are in `attrs["units"]`, by name."""
        return storage.to_pandas(self)

    def animate(
        self,
        *,
        fps: float = 30.0,
        speed: float | None = None,
        view: str | None = None,
        width: int = 640,
        height: int = 360,
        bounds: tuple[float | None, float | None] = (None, None),
    ) -> VideoData:
        """A video of the run, which notebooks play and `save` writes to a file.

        fps: frames a second [1/s]; speed: simulated seconds in a second of film, dimensionless, by
        default 1 where that takes 3 to 60 s; view: "fixed", "centre" (moves with the centre of
        gravity) or "axes" (turns with the principal axes, too), by default fixed where the rod is
        then large enough; width, height: of a frame [pixels], even; bounds: simulated times
        (a, b) [s] between which the run is shown, by default all.

        It is MP4 where there is an ffmpeg or the package imageio-ffmpeg, else GIF. Raises
        InputError for what cannot be used.
        """
        settings = {"fps": fps, "speed": speed, "view": view, "bounds": bounds}
        video: VideoData = result_drawing().video(self, width=width, height=height, **settings)
        return video

    def save(self, path: str | Path) -> None:
        """Write everything to a NetCDF file, whole or not at all.

        path: of the file, which `rodgen.load` reads.
        """
        storage.save(self, Path(path))


class RunError(ArithmeticError):
    """A run could not be finished.

    solution: all samples so far.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("missile")
    >>> rodgen.simulate(scene, max_steps=10, progress=False)  # doctest: +IGNORE_EXCEPTION_DETAIL
    Traceback (most recent call last):
    rodgen.integrate.solution.RunError: stopped at t = 0.0119 s: the budget is used up
    """

    def __init__(self, message: str, solution: Solution):
        super().__init__(message)
        self.solution = solution

    @property
    def status(self) -> str:
        """Status of the solution."""
        return self.solution.status

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.solution)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run.

    solution: all samples so far.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("missile")
    >>> try:
    ...     sol = rodgen.simulate(scene, progress=False)
    ... except rodgen.Interrupted as stopped:
    ...     sol = stopped.solution
    """

    def __init__(self, solution: Solution):
        super().__init__(solution.message)
        self.solution = solution

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.solution,)
