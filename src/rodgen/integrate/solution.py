"""What came out of a run: states, and every quantity that follows from them when asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.catalogue import Motion, PrincipalAxes, joined
from rodgen.integrate.samples import Changes
from rodgen.integrate.stepper import Array, Counts
from rodgen.loading import build, build_fastest
from rodgen.loading.module import Asked, asked
from rodgen.model.rod import Boundary
from rodgen.scene import Scene, SceneError
from rodgen.shown import Shown, appearance

if TYPE_CHECKING:
    import pandas
    import xarray

    from rodgen.integrate.dense_output import DenseOutput
    from rodgen.shown import Video


class Energy(NamedTuple):
    """Energies [J], each (T,)."""

    kinetic: Array
    spring: Array
    gravity: Array

    @property
    def total(self) -> Array:
        """Their sum."""
        return self.kinetic + self.spring + self.gravity


class Inertia(NamedTuple):
    """Moments of inertia about the x and y axes through the centre of gravity and the product
    of inertia [kg m^2], each (T,)."""

    x: Array
    y: Array
    xy: Array


class Event(NamedTuple):
    """An event of a run.

    name: as in the scene; t: its time [s]; y: the state then, (states,), in SI units.

    Examples
    --------
    >>> import rodgen
    >>> watched = [{"quantity": "tip_y", "value": 30.0, "name": "30 m"}]
    >>> scene = rodgen.Scene.example("missile").replace({"events": watched})
    >>> event = rodgen.simulate(scene, progress=False).events[0]
    >>> event.name, event.y.shape
    ('30 m', (44,))
    """

    name: str
    t: float
    y: Array

    def __repr__(self) -> str:
        return f"<Event {self.name}: t = {self.t:g} s, {len(self.y)} states>"


@dataclass(frozen=True)
class Stats:
    """Cost of a run; rejected is None where the method does not tell; target: of the module that
    ran, "c" or "numpy", empty where it is not known."""

    steps: int
    rejected: int | None
    rhs: int
    jacobian: int
    factorisations: int
    wall_seconds: float
    target: str = ""

    @classmethod
    def of(cls, counts: Counts, seconds: float, target: str = "") -> Stats:
        """What the steppers have counted, and the wall time."""
        return cls(**asdict(counts), wall_seconds=seconds, target=target)


class ErrorGrowth(NamedTuple):
    """How fast errors grow in a run. factor: how many times its size a small error in the angles
    has at most, whenever it was made, infinite beyond all doubles; tenfold: time in which it grew
    tenfold, on the average of the run [s], infinite where nothing grew; visible: when an error of
    the size of rtol may have grown to 1e-3 rad and a hundredfold [s], infinite where none has and
    for fixed steps. Not a number where they could not be found."""

    factor: float
    tenfold: float
    visible: float


class _Module:
    """The module of a solution: that of its run, or one that is built when it is asked for."""

    def __get__(self, solution: Solution | None, _: object = None) -> ModuleType:
        if solution is None:
            return None  # type: ignore[return-value]  # the default of the field
        kept = solution.__dict__
        if kept["model"] is None:
            native = solution.stats.target == "c"
            kept["model"] = (build_fastest if native else build)(solution.scene)
        module: ModuleType = kept["model"]
        return module

    def __set__(self, solution: Solution, module: ModuleType | None) -> None:
        solution.__dict__["model"] = module


@dataclass(repr=False)
class Solution(Motion, Shown):
    """States of a scene over time.

    scene: what was run; t: times [s], (T,); y: states in SI units and the order of the module's
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

    scene: Scene
    t: Array
    y: Array
    work: dict[str, Array]
    stats: Stats
    status: str = "finished"
    message: str = ""
    model: _Module = _Module()
    events: tuple[Event, ...] = ()
    changes: Changes | None = None
    errors: ErrorGrowth | None = None

    def __repr__(self) -> str:
        span = f", t = {self.t[0]:g} to {self.t[-1]:g} s" if len(self.t) else ""
        said = f" ({self.message})" if self.message else ""
        what = f"{len(self.t)} samples of {self.y.shape[-1]} states{span}"
        return f"<Solution of {self.scene.name}: {what}; {self.status}{said}>"

    def __getstate__(self) -> dict[str, Any]:
        """What cannot be made again: neither the module nor what follows from the states."""
        kept = {field.name for field in fields(self)} | {"energy_error"}  # which `load` may know
        return {k: v for k, v in self.__dict__.items() if k in kept} | {"model": None}

    def __call__(self, t: float | Array) -> Array:
        """States between samples: (states,) at a time t [s], (states, K) at times (K,).

        The run is taken up from the sample before, by its method and with its tolerance; at a
        sample it is the sample. Raises SceneError for times that the run has not reached and for a
        run that was changed while it went on, RunError where a step fails.
        """
        times = np.asarray(t)
        if times.dtype.kind not in "iuf" or times.ndim > 1:
            raise SceneError("t", t, "a time in seconds, or an array (K,) of them")
        states = self._between.at(np.atleast_1d(times).astype(float)).T
        return states if times.ndim else states[:, 0]

    @cached_property
    def _between(self) -> DenseOutput:
        from rodgen.integrate.dense_output import DenseOutput  # which is made of methods

        return DenseOutput(self)

    @cached_property
    def _p(self) -> Array:
        p: Array = self.model.parameters(**self.scene.parameters)
        return p

    @cached_property
    def hold(self) -> Boundary:
        """How the start of the rod is held."""
        return self.scene.hold

    @cached_property
    def added(self) -> tuple[str, ...]:
        """Names of the states that are neither positions nor velocities."""
        return tuple(self.scene.states)

    @cached_property
    def follows(self) -> bool:
        """Whether the module has sensors or loads that follow the motion."""
        return self.scene.structure.follows

    @cached_property
    def timed(self) -> Mapping[str, Callable[[Any], Any]]:
        """Loads that change with time, by the names of their parameters, each a function of the
        time [s]."""
        return self.scene.timed

    @cached_property
    def given(self) -> Array | float:
        """Energy that changes and kicks have put in since the start [J], (T,) or a number."""
        return 0.0 if self.changes is None else self.changes.given

    def called(self, function: str | Asked, *arrays: Array) -> Any:
        """What a function of the module makes of every sample and of the parameters then: an array,
        (T, parts) where it makes several, or a dictionary of arrays by term.

        function: its name, or one of the functions that ask for it; arrays: what it takes between
        the time and the parameters, such as the states, in SI units.
        """

        def made(t: Array, *of: Array) -> Any:
            return joined(asked(self.model, function, t, *of))

        if self.changes is None:
            return made(self.t, *arrays, self._p)
        return self.changes.follow(made, (self.t, *arrays))

    def parameter(self, name: str) -> Array:
        """A parameter of the module at every sample, (T,) in SI units; of several numbers, (T, K).

        name: as in `Scene.parameters`.
        """
        structure = self.scene.structure
        if self.changes is None:
            value = np.array(self.scene.parameters[name], dtype=float)
            return np.full((len(self.t), *value.shape), value)
        place = structure.places[name]
        columns: Array = self.changes.p[:, place if name in structure.spans else place.start]
        return columns

    @property
    def phi(self) -> Array:
        """Angles of all n links [rad], held ones included, (T, n)."""
        return self._array("phi")

    @property
    def omega(self) -> Array:
        """Rates of all n links [rad/s], (T, n)."""
        return self._array("omega")

    @property
    def joints(self) -> Array:
        """Positions of the joints [m], nose to tail, (T, n+1, 2)."""
        return self._array("joints")

    @property
    def tip(self) -> Array:
        """Position of the tail [m], (T, 2)."""
        return self._array("tip")

    @property
    def centre_of_gravity(self) -> Array:
        """Centre of gravity [m], (T, 2)."""
        return self._array("centre_of_gravity")

    @property
    def bending_moments(self) -> Array:
        """Bending moments in the joints, those of the springs [N m], (T, n+1); positive where the
        angle grows from link to link."""
        return self._array("bending_moments")

    @property
    def forces(self) -> dict[str, Array]:
        """Forces of the loads on the joints [N], by term, each (T, n+1, 2). Gravity, which acts on
        all mass, is not among them."""
        forces: dict[str, Array] = self.values("forces")
        return forces

    @property
    def inertia(self) -> Inertia:
        """Moments and product of inertia about the centre of gravity [kg m^2]."""
        return Inertia(*np.moveaxis(self.values("inertia"), -1, 0))

    @property
    def principal_axes(self) -> PrincipalAxes:
        """Principal axes of inertia [rad], and the moments about them [kg m^2]: the axis of the
        smaller moment runs along a straight rod."""
        axes: PrincipalAxes = self.values("principal_axes")
        return axes

    @property
    def energy(self) -> Energy:
        """Kinetic, spring and gravity energy [J]."""
        return Energy(*np.moveaxis(self.values("energy"), -1, 0))

    @property
    def total_work(self) -> Array:
        """Work of all loads without potential since the start [J], (T,)."""
        return self._array("total_work")

    @property
    def energy_balance(self) -> Array:
        """Energy gained since the start less the work done, and less what changes have put in [J],
        (T,): zero but for errors."""
        return self._array("energy_balance")

    def _array(self, name: str) -> Array:
        values: Array = self.values(name)
        return values

    @cached_property
    def start_energy(self) -> float:
        """Energy at the start of the run [J]: that of the first sample, less the work done until
        then where samples need not begin at the start; zero without samples."""
        first = self.taken(slice(1))
        first.start_energy = 0.0
        late = self.scene.integrate.t_eval is not None
        return float((first.energy_balance if late else first.energy.total).sum())

    @cached_property
    def energy_error(self) -> float:
        """Largest error of the energy balance [J]."""
        return float(np.abs(self.energy_balance).max(initial=0.0))

    @property
    def error_growth(self) -> float:
        """How many times its size a small error in the angles has at most by the end of the run,
        dimensionless: large where a run is chaotic, and its late angles are not to be trusted.

        Raises SceneError unless `simulate` was asked for it.
        """
        if self.errors is None:
            raise SceneError("error_growth", None, "asked for: simulate(..., error_growth=True)")
        return self.errors.factor

    def until(self, count: int) -> Solution:
        """The run with its first samples alone.

        count: how many samples.
        """
        first = self.taken(slice(count))
        end = first.t[-1] if len(first.t) else -np.inf
        first.events = tuple(event for event in self.events if event.t <= end)
        return first

    def taken(self, kept: NDArray[np.intp] | slice) -> Solution:
        """The run with some of its samples alone, and without events.

        kept: their indices, or a slice.
        """
        work = {term: values[kept] for term, values in self.work.items()}
        changes = self.changes and self.changes.taken(kept)
        rest = {"work": work, "events": (), "changes": changes, "model": self.__dict__["model"]}
        return replace(self, t=self.t[kept], y=self.y[kept], **rest)

    def to_xarray(self) -> xarray.Dataset:
        """All quantities with names, dimensions and units."""
        from rodgen.integrate.files.storage import to_xarray

        return to_xarray(self)

    def to_pandas(self) -> pandas.DataFrame:
        """One row a sample, over the time t [s], with a column for every number, named as events
        and studies name them: phi_0, tip_x, joint_3_y; units are in `attrs["units"]`, by name."""
        from rodgen.integrate.files.frame import to_pandas

        return to_pandas(self)

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
        SceneError for what cannot be used.
        """
        settings = {"fps": fps, "speed": speed, "view": view, "start": start, "end": end}
        video: Video = appearance().video(self, width=width, height=height, **settings)
        return video

    def save(self, path: str | Path) -> None:
        """Write everything to a NetCDF file, whole or not at all.

        path: of the file, which `rodgen.load` reads.
        """
        from rodgen.integrate.files.storage import save

        save(self, Path(path))
