"""What came out of a run, and the exceptions that carry what there is of it."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.dense_output import DenseOutput
from rodgen.integrate.files import storage
from rodgen.integrate.stepper import StepError
from rodgen.integrate.trajectory import Trajectory
from rodgen.shown import Shown, appearance

if TYPE_CHECKING:
    import pandas
    import xarray

    from rodgen.shown import Video


class Solution(Trajectory, Shown):
    """States of a scene over time.

    system: what was run; t: times [s], (T,); y: states in SI units and the order of the module's
    STATE, (T, states); stats: numbers of steps and of calls, and the seconds; work: work done
    by each load without potential since the start [J], by term, each (T,); status: "finished",
    "failed", "chatters" or "interrupted"; message: how the run ended; model: the generated module,
    built when it is first used if the solution comes from a file; events: that happened; changes:
    parameters at each sample of a live run whose values were changed, else None; errors: how fast
    errors grow, if that was asked for (a file does not keep it).

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

    def __repr__(self) -> str:
        span = f", t = {self.t[0]:g} to {self.t[-1]:g} s" if len(self.t) else ""
        said = f" ({self.message})" if self.message else ""
        what = f"{len(self.t)} samples of {self.y.shape[-1]} states{span}"
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
            states = self._between.at(np.atleast_1d(times).astype(float)).T
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
        start: float | None = None,
        end: float | None = None,
    ) -> Video:
        """A video of the run, which notebooks play and `save` writes to a file.

        fps: frames a second [1/s]; speed: simulated seconds in a second of film, dimensionless, by
        default 1 where that takes 3 to 60 s; view: "fixed", "centre" (moves with the centre of
        gravity) or "axes" (turns with the principal axes, too), by default fixed where the rod is
        then large enough; width, height: of a frame [pixels], even; start, end: simulated times
        [s].

        It is MP4 where there is an ffmpeg or the package imageio-ffmpeg, else GIF. Raises
        InputError for what cannot be used.
        """
        settings = {"fps": fps, "speed": speed, "view": view, "start": start, "end": end}
        video: Video = appearance().video(self, width=width, height=height, **settings)
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
        """That of the solution."""
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
