"""Systems: scenes prepared for computation, and copies of them with other numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from types import ModuleType
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from rodgen.arrays import Array
from rodgen.errors import InputError, check_type
from rodgen.loading import build, build_fastest
from rodgen.model.rod import Boundary
from rodgen.native.library import library_environment
from rodgen.result import Note, doubt
from rodgen.scene import Scene, Structure
from rodgen.scene.expression import Expression
from rodgen.scene.integration import EventTable, IntegrationSettings, IntegrationTable
from rodgen.scene.plain_tables import to_plain
from rodgen.scene.scene import with_values
from rodgen.scene.time_laws import TimeLaws
from rodgen.system.freezing import freeze, load_time
from rodgen.system.link_inertia import check_masses
from rodgen.system.packing import initial_values, make_read_only, merge_changes, pack
from rodgen.system.parameter_map import ParameterMap
from rodgen.system.plausibility import angle_doubts, initial_angle_doubts

SETTINGS = "integrate."
# Cached properties: scenes with all its numbers, and the one that has its expressions in time.
SCENES, LAWS = ("scene", "source"), ("_time_law_scene",)


PLAIN = ("structure", "settings", "p", "y0")  # of a system, as they are


class System:
    """A scene prepared for computation, and copied with other numbers at little cost.

    structure: what its module is specialised to; p: parameters of the module, (width,) in SI units;
    y0: the state at the start, (states,) in SI units; t: the time whose loads and masses hold all
    along [s], None where they change as the scene has it; settings: how it is integrated; scene:
    all of it as a scene. None of them is changed: `at` makes another system.

    Examples
    --------
    >>> import rodgen
    >>> column = rodgen.System(rodgen.Scene.example("ziegler"))
    >>> pushed = column.at({"loads.follower.force": 2.5})
    >>> [one.parameter("follower_force") for one in (column, pushed)], column.parameter("mass")
    ([2.0, 2.5], 6.0)
    >>> p, y0 = column.batch_arrays({"loads.follower.force": [2.0, 2.5, 3.0]})
    >>> p.shape, y0.shape
    ((3, 6), (3, 4))
    >>> rodgen.simulate(pushed, span=(0, 0.1), progress=False).scene.loads.follower.force
    2.5
    """

    structure: Structure
    p: Array
    y0: Array
    t: float | None
    settings: IntegrationTable

    def __init__(self, scene: Scene):
        """Prepare a scene. Raises TypeError for anything else."""
        if not isinstance(scene, Scene):
            check_type("scene", scene, Scene, see="Scene.from_toml")
        self._set_up(scene, scene, None)

    def _set_up(self, source: Scene, base: Scene, t: float | None) -> None:
        """Set all attributes. source: the scene; base: the same with its loads at t, if given."""
        self._source, self._base, self.t = source, base, t
        self._changes: dict[str, Any] = {}
        self._has_own_start = True  # that of a scene, not a state from elsewhere
        self._models: dict[Any, ModuleType] = {}
        self._map = ParameterMap(base, source)
        self.structure, self.settings = base.structure, base.integrate
        given, y0 = base.parameters, base.initial_state()
        self.p, self.y0 = make_read_only(pack(self.structure, given)), make_read_only(y0)

    @classmethod
    def of(cls, given: System | Scene) -> System:
        """Return a system as it is, or the system of a scene.

        given: a system or a scene.

        Raises TypeError for what is neither.
        """
        if not isinstance(given, System | Scene):
            check_type("system", given, System, Scene, see="Scene.from_toml")
        return given if isinstance(given, System) else cls(given)

    def __repr__(self) -> str:
        at = "" if self.t is None else f", loads as at t = {self.t:g} s"
        return f"<System of {self.scene!r}{at}>"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, System):
            return NotImplemented
        return (self.t, self.source) == (other.t, other.source)

    def __hash__(self) -> int:
        return hash((self.t, self.source))

    def __getstate__(self) -> dict[str, Any]:
        """State for pickling, without caches."""
        own = ("_source", "_base", "_changes", "_has_own_start")
        return {
            name: self.__dict__[name] for name in (*own, "t", "structure", "settings", "p", "y0")
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        for array in (state["p"], state["y0"]):
            array.flags.writeable = False
        self.__dict__.update(state, _map=ParameterMap(state["_base"], state["_source"]), _models={})

    # The same with other numbers ----------------------------------------------------------------

    def at(
        self,
        changes: Mapping[str, Any] | None = None,
        /,
        *,
        t: float | None = None,
        y0: ArrayLike | None = None,
        unused: bool = False,
    ) -> System:
        """The system with other values of keys of its scene, by their dotted names.

        Parameters
        ----------
        changes
            Values by names such as "loads.follower.force" or "integrate.rtol", as `Scene.replace`
            takes them, in SI units.
        t
            Time in the span [s] whose loads and masses hold all along, by default that of the
            system.
        y0
            State (states,) at the start in SI units, in the order of the module's STATE. Unlike
            angles of a scene, those of a state are not doubted to be radians.
        unused
            Whether numbers of [parameters] that no expression names may be among the changes.

        Returns
        -------
        System
            It shares all that it can: numbers that go into p alone make no other scene.

        Raises
        ------
        InputError
            For what the scene refuses.

        Examples
        --------
        >>> import rodgen
        >>> rod = rodgen.System(rodgen.Scene.example("missile"))
        >>> rod.at({"rod.mass": 18.0, "loads.gravity.g": 0.0}, t=1.0).scene.rod.mass
        18.0
        """
        made = self
        if changes is not None and not isinstance(changes, Mapping):
            allowed = 'a dictionary of values by dotted names, such as {"rod.length": 3}'
            raise InputError("changes", changes, allowed)
        if changes:
            given = {  # most values are plain already
                str(k): v if type(v) is float else to_plain(v, str(k)) for k, v in changes.items()
            }
            made = made._with_values(given)
            if not unused and made.structure is not self.structure:
                made.source.check_numbers_in_use(given)
        if t is not None:
            made = made.steady(t)
        return made if y0 is None else made._from_state(y0)

    def batch_arrays(self, values: Mapping[str, ArrayLike]) -> tuple[Array, Array]:
        """Arrays p (rods, width) and y0 (rods, states) of many copies of this rod.

        values: by keys of the scene, each a number or (rods,), in SI units. Raises InputError for a
        key of which more than p and y0 follows, such as the number of links, for values that the
        scene refuses, and for arrays of different lengths.
        """
        columns = {key: _to_column(key, value) for key, value in values.items()}
        counts = {len(one) for one in columns.values() if one.shape != (1,)}
        if len(counts) > 1 or any(one.ndim != 1 for one in columns.values()):
            shapes = {key: one.shape for key, one in columns.items()}
            raise InputError("p", shapes, "for every key a number, or as many as there are rods")
        count = counts.pop() if counts else 1
        p, y0 = np.tile(self.p, (count, 1)), np.tile(self.y0, (count, 1))
        for key, column in columns.items():
            slot = self._map.slot(key)
            if slot is None or slot.anchor:
                self.at({key: np.ravel(values[key])[0]})  # which says whether there is such a key
                allowed = "a key of which p or y0 alone follows; `rodgen.study` varies others"
                raise InputError("p", key, allowed)
            for value in np.unique(column).tolist():
                if not slot.accepts(value):
                    self.at({key: value})  # which says why, unless that is another module
                    raise InputError(f"p.{key}", value, "a number for which the module stays")
            p[:, slot.p], y0[:, slot.y] = column[:, None], column[:, None]
        return p, y0

    def steady(self, t: float | None = None) -> System:
        """Copy with loads and masses that are constant in time.

        t: those of this time [s], by default those of the system, else of the start of the span.

        Raises InputError for a time outside the span, and where none is given and masses change.
        """
        return self if self.t is not None and t in (None, self.t) else self._freeze(t)

    def with_settings(self, **given: Unpack[IntegrationSettings]) -> System:
        """Copy with other values in [integrate]; None keeps a value.

        given: values by the names in [integrate].

        A tolerance replaces a step of the scene where the method can use either, and output_every
        replaces t_eval. Raises InputError.
        """
        if all(value is None for value in given.values()):
            return self
        return self._with_integrate(self.settings.with_values(**given))

    def _with_integrate(self, settings: IntegrationTable) -> System:
        if self.t is not None:  # its numbers stay, whatever its laws do in another span
            base = self._base.with_checked_settings(settings)
            return self._copy(LAWS, _source=base, _base=base, settings=settings)
        source = self._source.with_checked_settings(settings)
        moved = settings.span[0] != self.settings.span[0]
        at_start = source.loads_along_rod or source.distribution.changing_masses or source.base
        if moved and at_start:
            return self._from_source(
                with_values(source, self._changes) if self._changes else source
            )
        return self._copy(LAWS, _source=source, _base=source, settings=settings)

    def with_method(self, method: str) -> System:
        """Copy with the method that was chosen for it.

        method: its name.
        """
        source, base = (one.with_method(method) for one in (self._source, self._base))
        return self._copy(LAWS, _source=source, _base=base, settings=base.integrate)

    def _copy(self, dropped: tuple[str, ...] = (), **others: Any) -> System:
        """Copy with other attributes; dropped: caches that do not hold for it."""
        made = object.__new__(type(self))
        made.__dict__.update(self.__dict__, **others)
        for name in (*SCENES, *dropped):
            made.__dict__.pop(name, None)
        return made

    def _with_values(self, given: dict[str, Any]) -> System:
        slots = {key: self._map.slot(key) for key in given}
        p, y0, anchored = self.p.copy(), self.y0.copy(), False
        dropped: tuple[str, ...] = ()
        for key, slot in slots.items():
            if slot is None or not slot.accepts(given[key]):
                return self._with_other_scene(given)
            if not slot.anchor:
                p[slot.p], y0[slot.y] = given[key], given[key]
            anchored = anchored or slot.anchor
            dropped = LAWS if slot.timed else dropped
        changes = merge_changes(self._changes, given)
        if any(_overlaps(key, changes) for key in given):
            return self._with_other_scene(given)
        if anchored:
            self._map.set_anchors(changes, p)
        return self._copy(dropped, _changes=changes, p=make_read_only(p), y0=make_read_only(y0))

    def _with_other_scene(self, given: dict[str, Any]) -> System:
        """Make the system by another scene, for values that p and y0 cannot take."""
        settings = {k.removeprefix(SETTINGS): v for k, v in given.items() if k.startswith(SETTINGS)}
        known = settings.keys() <= IntegrationSettings.__annotations__.keys()
        if known and len(settings) == len(given) and None not in settings.values():
            return self._with_integrate(self.settings.replace(settings))
        return self._from_source(with_values(self.source, given))

    def _from_source(self, source: Scene) -> System:
        made = object.__new__(type(self))
        made._set_up(source, source if self.t is None else freeze(source, self.t), self.t)
        return made

    @cached_property
    def source(self) -> Scene:
        """Scene with its loads as functions of time, whatever the time of the system is."""
        return with_values(self._source, self._changes) if self._changes else self._source

    def _freeze(self, t: float | None) -> System:
        source = self.source
        t = load_time(source, t)
        base = freeze(source, t)
        if base is source:
            return self._copy(t=t)
        made = object.__new__(type(self))
        made._set_up(source, base, t)
        return made

    def _from_state(self, y: ArrayLike) -> System:
        states = len(self.y0)
        state = np.asarray(to_plain(y, "y0"))
        real = state.dtype.kind in "iuf" and state.shape == (states,)
        if not (real and np.isfinite(state).all()):
            allowed = f"{states} finite numbers, as the module's STATE has them"
            raise InputError("y0", y, allowed)
        values = initial_values(self._base, state.astype(float))
        if self.boundary_condition.translates and self._base.has_places_of_start:
            made = self._with_other_scene(values)  # which rest where the rod begins
        else:
            y0, changes = make_read_only(state.astype(float)), merge_changes(self._changes, values)
            made = self._copy(_changes=changes, y0=y0)
        made._has_own_start = False
        return made

    def value_of(self, key: str, field: str = "vary") -> Any:
        """The value of a key of the scene, None where it is left out.

        key: its dotted name; field: what messages call it.

        Raises InputError for what is no key with one value.
        """
        return self.source.value_of(key, field)

    # What it is ---------------------------------------------------------------------------------

    @property
    def parameter_map(self) -> ParameterMap:
        """Map from keys of the scene to numbers of p and of y0."""
        return self._map

    @cached_property
    def scene(self) -> Scene:
        """The system as a scene, which is checked when it is first asked for."""
        if not self._changes:
            return self._base
        return self.source if self.t is None else freeze(self.source, self.t)

    @property
    def time_laws(self) -> TimeLaws:
        """Functions of time of the system, over the span."""
        return self._time_law_scene.time_laws

    @property
    def expressions(self) -> dict[str, Expression]:
        """Parameters that change with time or with the motion, by name."""
        return self._time_law_scene.expressions

    @property
    def time_dependent_loads(self) -> dict[str, Expression]:
        """Parameters that change with time alone, by name."""
        return self._time_law_scene.time_dependent_loads

    @cached_property
    def _time_law_scene(self) -> Scene:
        """Scene that has its expressions in time: the one before numbers were put into p, where
        none of these is in an expression."""
        slots = (self._map.slot(key) for key in self._changes)
        return self.scene if any(slot and slot.timed for slot in slots) else self._base

    @property
    def unused_names(self) -> tuple[str, ...]:
        """Sentences on the numbers and tables of the scene that no expression names."""
        return self._source.unused_names

    @property
    def doubts(self) -> tuple[Note, ...]:
        """Doubts about its numbers: unused names, and angles that look like degrees."""
        unused = (doubt(words) for words in self.unused_names)
        doubts = (*unused, *angle_doubts(self.structure, self.p, self.key_of))
        if not self._has_own_start:
            return doubts
        start = initial_angle_doubts(
            self.structure, self.p, self.y0, lambda: self.scene.initial.given_angles
        )
        return (*doubts, *start)

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self._base.name

    @property
    def boundary_condition(self) -> Boundary:
        """Boundary condition at the start of the rod, which a base moves or not."""
        return self.structure.boundary_condition

    @cached_property
    def events(self) -> tuple[EventTable, ...]:
        """Events that runs look out for."""
        return self._base.watched_events

    @cached_property
    def load_terms(self) -> tuple[str, ...]:
        """Names of its loads."""
        return self._base.loads.terms

    def parameter(self, name: str) -> Any:
        """A parameter of the module, in SI units: a number, or an array of several.

        name: its name in the module.
        """
        place = self.structure.slices[name]
        return self.p[place] if name in self.structure.index_ranges else float(self.p[place.start])

    @property
    def parameters(self) -> dict[str, Any]:
        """All parameters of the module by name, in SI units."""
        return {name: self.parameter(name) for name in self.structure.slices}

    def key_of(self, name: str) -> str:
        """Dotted name of the place in the scene where a parameter of the module stands.

        name: its name in the module.
        """
        return self._base.key_of(name)

    def model(self, target: str | None = None, parts: Iterable[str] = ("rhs",)) -> ModuleType:
        """Generated module of the system, whose parts are made when they are asked for.

        target: "c" or "numpy", by default C where it can be built; parts: what is made at once.
        Raises InputError and BuildError.
        """
        if "rhs" in parts:
            check_masses(self)
        key = target, tuple(parts), library_environment()
        if key not in self._models:
            made = build_fastest(self.structure, parts) if target is None else None
            self._models[key] = made or build(self.structure, target or "", parts=parts)
        return self._models[key]


def _to_column(key: str, value: ArrayLike) -> Array:
    """Values of a key as an array (rods,) or (1,). Raises InputError for what are no numbers."""
    try:
        array = np.atleast_1d(np.asarray(value))
    except ValueError:  # of lists of different lengths
        array = np.array([None])
    if isinstance(value, np.ma.MaskedArray) or array.dtype.kind not in "iuf":
        raise InputError(f"p.{key}", value, "real numbers")
    return array.astype(float)


def _overlaps(key: str, others: Mapping[str, Any]) -> bool:
    """Whether a key lies within one of others, or one of these within it."""
    return any(other.startswith(f"{key}.") or key.startswith(f"{other}.") for other in others)
