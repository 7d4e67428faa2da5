"""Samples of a run as plain data, and the quantities that follow from them, computed on demand."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from types import ModuleType
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.quantity_formulas import Motion, PrincipalAxes, stack_parts
from rodgen.integrate.stepper import Stats
from rodgen.loading import build, build_fastest
from rodgen.loading.generated_module import ModuleFunction, call_module
from rodgen.model.rod import Boundary
from rodgen.result import Note
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.system import System


class Energy(NamedTuple):
    """Energies [J], each (T,)."""

    kinetic: Array
    spring: Array
    gravity: Array

    @property
    def total(self) -> Array:
        """Sum of the three [J]."""
        return self.kinetic + self.spring + self.gravity


class MomentsOfInertia(NamedTuple):
    """Moments of inertia about the x and y axes through the centre of gravity and the product
    of inertia [kg m^2], each (T,)."""

    x: Array
    y: Array
    xy: Array


class Event(NamedTuple):
    """An event that happened in a run.

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


class ErrorGrowth(NamedTuple):
    """Growth of small errors in a run. factor: how many times its size a small error in the angles
    has at most, whenever it was made, infinite beyond all doubles; tenfold: time in which it grew
    tenfold, on the average of the run [s], infinite where nothing grew; visible: when an error of
    the size of rtol may have grown to 1e-3 rad and a hundredfold [s], infinite where none has and
    for fixed steps. Not-a-number where they could not be found."""

    factor: float
    tenfold: float
    visible: float


@dataclass(frozen=True)
class Changes:
    """Values at each of T samples of a run that was changed. p: parameters of the module, (T,
    parameters); given: energy [J] that changes and kicks have put in since the start, (T,)."""

    p: Array
    given: Array

    def isel(self, kept: NDArray[np.intp] | slice) -> Changes:
        """Values at some of the samples."""
        return Changes(self.p[kept], self.given[kept])

    def call_piecewise(self, made: Callable[..., Any], of: Sequence[Array]) -> Any:
        """Call a function on slices of arrays over the samples between two changes of p, and on p
        there, and join the results: an array (T, ...), or several by name."""
        changed = np.any(self.p[1:] != self.p[:-1], axis=1)
        edges = [0, *(np.flatnonzero(changed) + 1), len(self.p)]
        parts = [
            made(*(values[a:b] for values in of), self.p[a]) for a, b in itertools.pairwise(edges)
        ]
        if isinstance(parts[0], dict):
            return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        return np.concatenate(parts)


class _LazyModule:
    """Descriptor of the module of a run: the one given, or one that is built on first use."""

    def __get__(self, trajectory: Trajectory | None, _: object = None) -> ModuleType:
        if trajectory is None:
            return None  # type: ignore[return-value]  # the default of the field
        kept = trajectory.__dict__
        if kept["model"] is None:
            native = trajectory.stats.target == "c"
            kept["model"] = (build_fastest if native else build)(trajectory.system.structure)
        module: ModuleType = kept["model"]
        return module

    def __set__(self, trajectory: Trajectory, module: ModuleType | None) -> None:
        trajectory.__dict__["model"] = module


@dataclass(repr=False)
class Trajectory(Motion):
    """Samples of a run and how it went, with the quantities of every sample: the fields of a
    Solution."""

    system: System
    t: Array
    y: Array
    work: dict[str, Array]
    stats: Stats
    status: str = "finished"
    message: str = ""
    model: _LazyModule = _LazyModule()
    events: tuple[Event, ...] = ()
    changes: Changes | None = None
    errors: ErrorGrowth | None = None
    run_notes: tuple[Note, ...] = ()

    def __getstate__(self) -> dict[str, Any]:
        """Fields for pickling: neither the module nor what follows from the states."""
        kept = {field.name for field in fields(self)} | {"energy_error"}  # which `load` may know
        return {k: v for k, v in self.__dict__.items() if k in kept} | {"model": None}

    @property
    def scene(self) -> Scene:
        """The scene that was run."""
        return self.system.scene

    @cached_property
    def boundary_condition(self) -> Boundary:  # type: ignore[override]
        """Boundary of the rod: how its start is held."""
        return self.system.boundary_condition

    @cached_property
    def extra_states(self) -> tuple[str, ...]:  # type: ignore[override]
        """Names of the states that are neither positions nor velocities."""
        return self.system.structure.state_names

    @cached_property
    def has_feedback(self) -> bool:  # type: ignore[override]
        """Whether the module has sensors or loads that follow the motion."""
        return self.system.structure.has_feedback

    @cached_property
    def time_dependent_loads(self) -> Mapping[str, Expression]:  # type: ignore[override]
        """Loads that change with time, by the names of their parameters, each a function of the
        time [s]."""
        return self.system.time_dependent_loads

    @cached_property
    def energy_input(self) -> Array | float:  # type: ignore[override]
        """Energy that changes and kicks have put in since the start [J], (T,) or a number."""
        return 0.0 if self.changes is None else self.changes.given

    def evaluate(self, function: str | ModuleFunction, *arrays: Array) -> Any:
        """Call a function of the module on every sample and the parameters then: an array, (T,
        parts) of several results, or a dictionary of arrays by term.

        function: its name, or a function that calls it; arrays: arguments between the time and the
        parameters, such as the states, in SI units.
        """

        def made(t: Array, *of: Array) -> Any:
            return stack_parts(call_module(self.model, function, t, *of))

        if self.changes is None:
            return made(self.t, *arrays, self.system.p)
        return self.changes.call_piecewise(made, (self.t, *arrays))

    def has_parameter(self, name: str) -> bool:
        """Whether the module has a parameter of this name.

        name: as in `Scene.parameters`.
        """
        return name in self.system.structure.slices

    def parameter(self, name: str) -> Array:
        """A parameter of the module at every sample, (T,) in SI units; of several numbers, (T, K).

        name: as in `Scene.parameters`.
        """
        structure = self.system.structure
        if self.changes is None:
            value = np.array(self.system.parameter(name), dtype=float)
            return np.full((len(self.t), *value.shape), value)
        place = structure.slices[name]
        columns: Array = self.changes.p[:, place if name in structure.index_ranges else place.start]
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
    def inertia(self) -> MomentsOfInertia:
        """Moments and product of inertia about the centre of gravity [kg m^2]."""
        return MomentsOfInertia(*np.moveaxis(self.values("inertia"), -1, 0))

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
        """Energy gained since the start, less the work done and what changes and kicks have put in
        [J], (T,): zero but for errors."""
        return self._array("energy_balance")

    def _array(self, name: str) -> Array:
        values: Array = self.values(name)
        return values

    @cached_property
    def start_energy(self) -> float:  # type: ignore[override]
        """Energy at the start of the run [J]: that of the first sample, less the work done until
        then where samples need not begin at the start; zero without samples."""
        first = self.isel(slice(1))
        first.start_energy = 0.0
        late = self.scene.integrate.t_eval is not None
        return float((first.energy_balance if late else first.energy.total).sum())

    @cached_property
    def energy_error(self) -> float:
        """Largest error of the energy balance [J]."""
        return float(np.abs(self.energy_balance).max(initial=0.0))

    @property
    def error_growth(self) -> float:
        """Factor by which a small error in the angles has grown at most by the end of the run,
        dimensionless: large where a run is chaotic, and its late angles are not to be trusted.

        Raises InputError unless `simulate` was asked for it.
        """
        if self.errors is None:
            raise InputError("error_growth", None, "asked for: simulate(..., error_growth=True)")
        return self.errors.factor

    def head(self, count: int) -> Self:
        """First samples of the run, with the events up to the last of them.

        count: how many samples.
        """
        first = self.isel(slice(count))
        end = first.t[-1] if len(first.t) else -np.inf
        first.events = tuple(event for event in self.events if event.t <= end)
        return first

    def isel(self, kept: NDArray[np.intp] | slice) -> Self:
        """Some samples of the run, without events.

        kept: their indices, or a slice.
        """
        work = {term: values[kept] for term, values in self.work.items()}
        changes = self.changes and self.changes.isel(kept)
        rest = {"work": work, "events": (), "changes": changes, "model": self.__dict__["model"]}
        return replace(self, t=self.t[kept], y=self.y[kept], **rest)
