"""A study: a scene, what of it is varied, what is computed at every point, and what is kept."""

from __future__ import annotations

import hashlib
import inspect
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Self

from rodgen.scene import Scene, SceneError
from rodgen.scene.errors import UNKNOWN, check_type, meant, unknown_key
from rodgen.scene.exchange import with_values
from rodgen.scene.keys import key_place
from rodgen.scene.plain import STUDY, plain, read_table
from rodgen.shown import Told
from rodgen.studies.axis import EXTENDABLE, Axis, Sample, Value, axis
from rodgen.studies.points import points
from rodgen.studies.time_limit import checked_limit

WHAT = ("run", "critical", "modes", "static", "lyapunov", "floquet", "cycle")
# Keys of a file by the tables that they stand in: what each is, and what holds without it; those of
# a key that is varied and of a sample are fields of Range and Sample.
KEYS = {
    "": {
        "name": ("of the study and of its store, a plain identifier", "that of the scene"),
        "scene": ("a file, from the folder of the study, or a table `[scene]`", "required"),
        "vary": ("a table of keys of the scene", "required"),
        "sample": ("a table: points are drawn, not all combinations taken", "absent"),
        "compute": ("a table", "`run`"),
    },
    "compute": {
        "what": ("what is computed of every point", "`run`"),
        "keep": ("a list of what is kept of it", "of a run required, else what is usual"),
        "options": ("a table of what the analysis takes besides", "absent"),
        "time_limit": ("seconds that a point may take", "no limit"),
    },
}
MOST_TRIED = 1000  # points that are made to find one that the scene takes
MANY = 10**8  # points, beyond which a study is asked for twice

Kept = str | Callable[..., Any]


@dataclass(frozen=True, eq=False, repr=False)
class Study(Told):
    """A study. Its checks raise SceneError before anything is computed.

    name: of the study and its store; scene: tables of the scene; axes: keys that are varied, in
    order, with their values; sample: how points are drawn from them, None for a grid; what: the
    analysis; keep: what is kept of every point, texts or functions; options: further arguments of
    the analysis; time_limit: time that a point may take [s], or None.

    Two studies are equal if their ``digest`` is.

    Examples
    --------
    >>> import rodgen
    >>> scene, vary = rodgen.Scene.example("ziegler"), {"loads.follower.force": [1.5, 3.0]}
    >>> study = rodgen.Study.of(scene, vary, what="modes", keep=["stable"])
    >>> study.count, study.shape, study.dims
    (2, (2,), ('loads.follower.force',))
    >>> study.scene_at({"loads.follower.force": 3.0}).loads.follower.force, len(study.digest)
    (3.0, 64)
    """

    name: str
    scene: dict[str, Any]
    axes: tuple[Axis, ...]
    sample: Sample | None = None
    what: str = "run"
    keep: tuple[Kept, ...] = ()
    options: dict[str, Any] = field(default_factory=dict)
    time_limit: float | None = None

    def __repr__(self) -> str:
        points = " x ".join(map(str, self.shape))
        return f"<Study {self.name}: {self.what} at {points} of {', '.join(self.dims)}>"

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Read a study from a TOML file; its scene is a table of it, or a file by its path from
        the folder of the study.

        path: of the file.
        """
        path = Path(path)
        table = read_table(path, STUDY)
        _check_keys("", table)
        given = table.get("scene")
        if isinstance(given, str):
            scene = Scene.from_toml(path.parent / given)
        elif isinstance(given, dict):
            scene = _of_table(given, path.parent)
        else:
            raise SceneError("scene", given, "the path of a scene, or its tables")
        compute = table.get("compute", {})
        if not isinstance(compute, dict):
            raise SceneError("compute", compute, "a table {what, keep, options}")
        _check_keys("compute", compute)
        others = {key: table[key] for key in ("name", "sample") if key in table}
        return cls.of(scene, table.get("vary", {}), **others, **compute)

    @classmethod
    def of(
        cls,
        scene: Scene,
        vary: Mapping[str, Any],
        *,
        what: str = "run",
        keep: Sequence[Kept] | Kept = (),
        sample: Mapping[str, Any] | None = None,
        options: Mapping[str, Any] | None = None,
        time_limit: float | None = None,
        name: str | None = None,
    ) -> Self:
        """A study from Python.

        scene: the scene; vary: for every key its values (a list, an array) or a table {from, to,
        count, scale}, in SI units; what: the analysis; keep: what is kept of every point; sample:
        {method, count, seed}, if points are drawn; options: further arguments of the analysis;
        time_limit: time that a point may take [s]; name: of the study, by default the scene's.
        """
        check_type("scene", scene, Scene, see="Scene.from_toml")
        if name is not None and not (isinstance(name, str) and name.isidentifier()):
            raise SceneError("name", name, "a plain identifier")
        drawn = None if sample is None else Sample.read(plain(dict(sample), "sample"))
        vary = plain(dict(vary) if isinstance(vary, Mapping) else vary, "vary")
        if not isinstance(vary, dict) or not vary:
            raise SceneError("vary", vary, "a table of at least one key of the scene")
        axes = tuple(axis(str(key), table, drawn is not None) for key, table in vary.items())
        if what not in WHAT:
            raise SceneError("compute.what", what, f"one of {', '.join(WHAT)}{meant(what, WHAT)}")
        kept = (keep,) if isinstance(keep, str) or callable(keep) else tuple(keep)
        for at, one in enumerate(kept):
            if not (isinstance(one, str) or callable(one)):
                raise SceneError(f"compute.keep[{at}]", one, "a reduction, or a function")
        chosen = plain(dict(options or {}), "compute.options")
        table = scene.to_dict()
        limit = checked_limit(time_limit)
        made = cls(name or scene.name, table, axes, drawn, what, kept, chosen, limit)
        made._check()
        return made

    def _check(self) -> None:
        """Raise SceneError unless it has keys of its scene, kept quantities with names of their
        own, and a point that its scene takes."""
        from rodgen.studies.keep import variables

        for one in self.axes:
            self._check_axis(one)
        names = {one.name for one in self.axes}
        for kept in variables(self):
            if kept.name in names or "/" in kept.name:
                allowed = "something else than a varied key, without a slash"
                raise SceneError("compute.keep", kept.name, allowed)
            names.add(kept.name)
        first: SceneError | None = None
        for index in _spread(self.count):
            try:
                self.scene_at(points(self, [index])[0])
                return
            except SceneError as error:
                first = first or error
        if first is not None and self.count <= MOST_TRIED:
            why = f"such that the scene takes one point at least (of the first it says: {first})"
            raise SceneError("vary", list(self.places), why)

    def _check_axis(self, one: Axis) -> None:
        """Raise SceneError for a key that the scene does not have, or that takes no value of
        these."""
        self.place(one.name)
        values = one.values or tuple(one.drawn(share) for share in (0.0, 0.5, 1 - 1e-9))
        first: SceneError | None = None
        for at in _spread(len(values)):
            try:
                self.scene_at({one.name: values[at]})
                return
            except SceneError as error:
                if error.allowed.startswith(UNKNOWN):
                    raise SceneError(f"vary.{one.name}", values[at], error.allowed) from None
                if len(self.axes) > 1 and not _is_of(error, self.place(one.name)):
                    return  # another key may be what makes it possible
                first = first or error
        assert first is not None
        raise SceneError(f"vary.{one.name}", first.value, first.allowed)

    @cached_property
    def base(self) -> Scene:
        """The scene as it stands."""
        return Scene.from_dict(self.scene)

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of what comes out: the varied keys of a grid, "point" of a sample."""
        return tuple(one.name for one in self.axes) if self.sample is None else ("point",)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many points there are along them."""
        if self.sample is not None:
            return (self.sample.count,)
        return tuple(len(one.values) for one in self.axes)

    @property
    def count(self) -> int:
        """How many points there are."""
        return math.prod(self.shape)

    @cached_property
    def places(self) -> dict[str, tuple[str, ...]]:
        """Keys of tables and lists of the scene that are varied, by name."""
        values = (one.values for one in self.axes if isinstance(one.values, tuple))
        laws = [value for of in values for value in of if isinstance(value, str)]
        return {one.name: key_place(self.scene, one.name, others=laws) for one in self.axes}

    def place(self, name: str) -> tuple[str, ...]:
        """Keys of tables and lists where a varied key stands in the scene, a body by its place in
        the list.

        name: the dotted name of the key.
        """
        return self.places[name]

    def scene_at(self, point: Mapping[str, Value]) -> Scene:
        """The scene of a point. Another number of links converts damping as `Scene.with_links`
        does.

        point: values of the varied keys, in SI units; it may leave keys as they are.

        Raises SceneError.
        """
        return with_values(self.base, point)

    @cached_property
    def contents(self) -> dict[str, str]:
        """What it consists of, part by part, as text that is equal for equal studies. How many
        points a sample has that can be extended is no part of it."""
        axes = [one.contents for one in self.axes]
        sample = None if self.sample is None else self.sample.model_dump()
        if sample is not None and sample["method"] in EXTENDABLE:
            del sample["count"]
        parts: dict[str, Any] = {
            "scene": self.scene,
            "vary": axes,
            "sample": sample,
            "what": self.what,
            "keep": [_named(one) for one in self.keep],
            "options": self.options,
            "time_limit": self.time_limit,
        }
        return {name: json.dumps(part, sort_keys=True) for name, part in parts.items()}

    @cached_property
    def digest(self) -> str:
        """A hash of the contents, equal for equal studies."""
        return hashlib.sha256("\0".join(self.contents.values()).encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Study) and self._identity == other._identity

    def __hash__(self) -> int:
        return hash(self._identity)

    @property
    def _identity(self) -> tuple[str, int]:
        return self.digest, self.count


def _of_table(table: dict[str, Any], folder: Path) -> Scene:
    from rodgen.scene.files import with_tables

    try:
        return Scene.from_dict(with_tables(table, folder))
    except SceneError as error:
        raise SceneError(f"scene.{error.field}", error.value, error.allowed) from None


def _check_keys(table: str, given: Mapping[str, Any]) -> None:
    known = KEYS[table]
    for key, value in given.items():
        if key not in known:
            name = f"{table}.{key}" if table else key
            raise SceneError(name, value, unknown_key(key, known))


def _is_of(error: SceneError, place: tuple[str, ...]) -> bool:
    """Whether an error speaks of a key."""
    return error.field.replace("[", ".").replace("]", "").startswith(".".join(place))


def _named(kept: Kept) -> str:
    """What is kept, as text; of a function its name and a hash of its source."""
    if isinstance(kept, str):
        return kept
    try:
        text = inspect.getsource(kept)
    except (OSError, TypeError):
        code = getattr(kept, "__code__", None)
        text = repr((code.co_code, code.co_consts)) if code else repr(kept)
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    return f"{getattr(kept, '__name__', type(kept).__name__)} {digest}"


def _spread(count: int) -> Sequence[int]:
    """At most so many whole numbers below a count, as all of it if it is small."""
    if count <= MOST_TRIED:
        return range(count)
    return [at * (count - 1) // (MOST_TRIED - 1) for at in range(MOST_TRIED)]
