"""What came out of a run: states, and every quantity that follows from them when asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.changes import Changes
from rodgen.integrate.stepper import Array, Counts
from rodgen.loading import build, build_fastest
from rodgen.scene import Scene, SceneError

if TYPE_CHECKING:
    import xarray

    from rodgen.integrate.between import Between


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


class PrincipalAxes(NamedTuple):
    """angle: from the x axis to the axis of the smaller moment [rad], in (-pi/2, pi/2], (T,);
    moments: the smaller and the larger principal moment of inertia [kg m^2], (T, 2)."""

    angle: Array
    moments: Array


def principal_axes(x: Array, y: Array, xy: Array) -> PrincipalAxes:
    """Of moments about x and y and the product of inertia [kg m^2], each (...)."""
    tensor = np.stack((np.stack((x, -xy), -1), np.stack((-xy, y), -1)), -2)
    moments, axes = np.linalg.eigh(tensor)
    angle = np.arctan2(axes[..., 1, 0], axes[..., 0, 0])
    # An axis has no direction: of its two angles the one in (-pi/2, pi/2].
    angle = np.where(angle > np.pi / 2, angle - np.pi, angle)
    angle = np.where(angle <= -np.pi / 2, angle + np.pi, angle)
    return PrincipalAxes(angle, moments)


class Event(NamedTuple):
    """Something that a scene looks out for has happened: its name, when [s], and the state then,
    (states,)."""

    name: str
    t: float
    y: Array


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
        """From the counts of the steppers and the wall time."""
        # Some methods count in NumPy's integers, which JSON does not know.
        whole = {name: int(n) for name, n in asdict(counts).items() if n is not None}
        rejected = whole.pop("rejected", None)
        return cls(rejected=rejected, **whole, wall_seconds=seconds, target=target)


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
class Solution:
    """States of a scene over time.

    t: times [s], (T,); y: states in the order of the module's STATE, (T, states); work: work done
    by each load without potential since the start [J], by term, each (T,); status: finished,
    failed or interrupted, with a message where there is something to say; model: the generated
    module, built when it is asked for where the solution was read, unpickled or copied; events:
    those of the scene that happened; changes: what held at each sample, where that is not the same
    all along; errors: how fast they grow, where that was asked for. A file does not keep it.
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
    def _between(self) -> Between:
        from rodgen.integrate.between import Between  # which is made of methods

        return Between(self)

    @cached_property
    def _p(self) -> Array:
        p: Array = self.model.parameters(**self.scene.parameters)
        return p

    def _follow(self, made: Callable[..., Any], *of: Array, axis: int = 0) -> Any:
        """What is made of arrays over the samples and of the parameters that held there; axis: its
        axis of time."""
        if self.changes is None:
            return made(*of, self._p)
        return self.changes.follow(made, of, axis)

    def parameter(self, name: str) -> Array:
        """A parameter of the scene that is a number, at every sample, (T,)."""
        if self.changes is None:
            return np.full(len(self.t), float(self.scene.parameters[name]))
        column: Array = self.changes.p[:, self.scene.structure.parameters.index(name)]
        return column

    def _links(self, half: int, held: Array) -> Array:
        states = np.array_split(self.y, 2, axis=1)[half]
        moving = states[:, 2:] if self.scene.hold.translates else states
        first = np.repeat(held[:, None], self.scene.held, axis=1)
        return np.concatenate((first, moving), axis=1)

    @cached_property
    def phi(self) -> Array:
        """Angles of all n links [rad], held ones included, (T, n)."""
        zero = np.zeros(len(self.t))
        return self._links(0, self.parameter("clamp_angle") if self.scene.held else zero)

    @cached_property
    def omega(self) -> Array:
        """Rates of all n links [rad/s], (T, n)."""
        return self._links(1, np.zeros(len(self.t)))

    @cached_property
    def joints(self) -> Array:
        """Positions of the joints [m], nose to tail, (T, n+1, 2)."""
        positions: Array = self._follow(self.model.joints, self.y)
        return positions

    @property
    def tip(self) -> Array:
        """Position of the tail [m], (T, 2)."""
        return self.joints[:, -1]

    @cached_property
    def energy(self) -> Energy:
        """Kinetic, spring and gravity energy [J]."""
        return Energy(*self._follow(self.model.energy, self.y, axis=1))

    @cached_property
    def total_work(self) -> Array:
        """Work of all loads without potential since the start [J], (T,)."""
        total: Array = sum(self.work.values(), start=np.zeros(len(self.t)))
        return total

    @cached_property
    def energy_balance(self) -> Array:
        """Energy gained since the start less the work done, and less what changes have put in [J],
        (T,): zero but for errors."""
        return self.balance(self.start_energy)

    @property
    def start_energy(self) -> float:
        """Energy at the start of the run [J]: that of the first sample, less the work done until
        then where samples need not begin at the start; zero without samples."""
        first = self.taken(slice(1))
        late = self.scene.integrate.t_eval is not None
        return float((first.balance(0.0) if late else first.energy.total).sum())

    def balance(self, start: float) -> Array:
        """The same, of a run that began with this energy [J]."""
        balance: Array = self.energy.total - start - self.total_work
        return balance if self.changes is None else balance - self.changes.given

    @cached_property
    def energy_error(self) -> float:
        """Largest error of the energy balance [J]."""
        return float(np.abs(self.energy_balance).max(initial=0.0))

    @property
    def error_growth(self) -> float:
        """How many times its size a small error in the angles has at most by the end of the run:
        large where a run is chaotic, and its late angles are not to be trusted.

        Raises SceneError unless `simulate` was asked for it.
        """
        if self.errors is None:
            raise SceneError("error_growth", None, "asked for: simulate(..., error_growth=True)")
        return self.errors.factor

    @cached_property
    def centre_of_gravity(self) -> Array:
        """Centre of gravity [m], (T, 2)."""
        centre: Array = self._follow(self.model.centre_of_gravity, self.y)
        return centre

    @cached_property
    def inertia(self) -> Inertia:
        """Moments and product of inertia about the centre of gravity [kg m^2]."""
        return Inertia(*self._follow(self.model.inertia, self.y, axis=1))

    @cached_property
    def principal_axes(self) -> PrincipalAxes:
        """Principal axes of inertia: that of the smaller moment runs along a straight rod."""
        return principal_axes(*self.inertia)

    @cached_property
    def bending_moments(self) -> Array:
        """Bending moments in the joints, those of the springs [N m], (T, n+1); positive where the
        angle grows from link to link."""
        moments: Array = self._follow(self.model.bending_moments, self.y)
        return moments

    @cached_property
    def forces(self) -> dict[str, Array]:
        """Forces of the loads on the joints [N], by term, each (T, n+1, 2). Gravity, which acts on
        all mass, is not among them."""

        def of(term: str) -> Array:
            forces = self.model.forces
            acting: Array = self._follow(lambda *of: forces(*of)[term], self.t, self.y)
            return acting

        return {term: of(term) for term in self.model.forces(self.t[:1], self.y[:1], self._p)}

    def until(self, count: int) -> Solution:
        """The same run with its first ``count`` samples alone."""
        first = self.taken(slice(count))
        end = first.t[-1] if len(first.t) else -np.inf
        first.events = tuple(event for event in self.events if event.t <= end)
        return first

    def taken(self, kept: NDArray[np.intp] | slice) -> Solution:
        """The same run with some of its samples alone, and without events."""
        work = {term: values[kept] for term, values in self.work.items()}
        changes = self.changes and self.changes.taken(kept)
        rest = {"work": work, "events": (), "changes": changes, "model": self.__dict__["model"]}
        return replace(self, t=self.t[kept], y=self.y[kept], **rest)

    def to_xarray(self) -> xarray.Dataset:
        """All quantities with names, dimensions and units."""
        from rodgen.integrate.files.storage import to_xarray

        return to_xarray(self)

    def save(self, path: str | Path) -> None:
        """Write everything to a NetCDF file, whole or not at all."""
        from rodgen.integrate.files.storage import save

        save(self, Path(path))
