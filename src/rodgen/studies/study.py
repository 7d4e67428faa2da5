"""Studies, read from a file or made in Python, and their checks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

from rodgen.arrays import even_indices
from rodgen.errors import UNKNOWN, InputError, did_you_mean, unknown_key_message
from rodgen.result import Result, Row
from rodgen.scene import Scene
from rodgen.scene.plain_tables import STUDY, read_toml, to_plain
from rodgen.scene.scene_files import read_table_files
from rodgen.studies.analysis_results import ANALYSES
from rodgen.studies.axis import Axis, Sample, read_axis
from rodgen.studies.kept_quantities import RUN, variables
from rodgen.studies.sampling import MOST_TRIED, reference_point
from rodgen.studies.specification import Kept, Specification
from rodgen.studies.time_limit import check_limit
from rodgen.system import System

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
        "analysis": ("what is computed of every point", "`run`"),
        "keep": ("a list of what is kept of it", "of a run required, else what is usual"),
        "options": ("a table of what the analysis takes besides", "absent"),
        "time_limit": ("seconds that a point may take", "no limit"),
    },
}
MANY = 10**8  # points, beyond which a study is asked for twice


class Study(Specification, Result):
    """A scene at many values of its keys. Its checks raise InputError before any computing.

    name: of the study and its store; scene: tables of the scene; axes: keys that are varied, in
    order, with their values; sample: how points are drawn from them, None for a grid; analysis:
    its name; keep: what is kept of every point, texts or functions; options: further arguments of
    the analysis; time_limit: time that a point may take [s], or None.

    Two studies are equal if their ``digest`` is.

    Examples
    --------
    >>> import rodgen
    >>> scene, vary = rodgen.Scene.example("ziegler"), {"loads.follower.force": [1.5, 3.0]}
    >>> study = rodgen.Study.of(scene, vary, analysis="modes", keep=["stable"])
    >>> study.count, study.shape, study.dims
    (2, (2,), ('loads.follower.force',))
    >>> study.scene_at({"loads.follower.force": 3.0}).loads.follower.force, len(study.digest)
    (3.0, 64)
    """

    ROWS = (
        Row("name", "study"),
        Row("analysis", "what is computed"),
        Row("count", "points"),
        Row("keys", "key", along="axis", of=lambda study: [one.name for one in study.axes]),
        Row(
            "values", "values", along="axis", of=lambda study: [_values_text(a) for a in study.axes]
        ),
        Row("first", "first", along="axis", of=lambda study: [one.bounds[0] for one in study.axes]),
        Row("last", "last", along="axis", of=lambda study: [one.bounds[1] for one in study.axes]),
    )

    def __repr__(self) -> str:
        points = " x ".join(map(str, self.shape))
        return f"<Study {self.name}: {self.analysis} at {points} of {', '.join(self.dims)}>"

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Read a study from a TOML file. Its scene is a table of that file, or the path of a file,
        relative to the folder of the study.

        path: of the file.
        """
        path = Path(path)
        table = read_toml(path, STUDY)
        _check_keys("", table)
        given = table.get("scene")
        if isinstance(given, str):
            scene = Scene.from_toml(path.parent / given)
        elif isinstance(given, dict):
            scene = _scene_from_table(given, path.parent)
        else:
            raise InputError("scene", given, "the path of a scene, or its tables")
        compute = table.get("compute", {})
        if not isinstance(compute, dict):
            raise InputError("compute", compute, "a table {analysis, keep, options}")
        _check_keys("compute", compute)
        others = {key: table[key] for key in ("name", "sample") if key in table}
        return cls.of(scene, table.get("vary", {}), **others, **compute)

    @classmethod
    def of(
        cls,
        system: System | Scene,
        vary: Mapping[str, Any],
        *,
        analysis: str = "run",
        keep: Sequence[Kept] | Kept = (),
        sample: Mapping[str, Any] | None = None,
        options: Mapping[str, Any] | None = None,
        time_limit: float | None = None,
        name: str | None = None,
    ) -> Self:
        """Make a study of a scene.

        system: the scene; vary: for every key its values (a list, an array) or a table {bounds,
        count, scale}, in SI units; analysis: its name; keep: what is kept of every point; sample:
        {method, count, seed}, if points are drawn; options: further arguments of the analysis;
        time_limit: time that a point may take [s]; name: of the study, by default the scene's.
        """
        scene = System.of(system).scene
        if name is not None and not (isinstance(name, str) and name.isidentifier()):
            raise InputError("name", name, "a plain identifier")
        drawn = None if sample is None else Sample.read(to_plain(dict(sample), "sample"))
        vary = to_plain(dict(vary) if isinstance(vary, Mapping) else vary, "vary")
        if not isinstance(vary, dict) or not vary:
            raise InputError("vary", vary, "a table of at least one key of the scene")
        axes = tuple(read_axis(str(key), table, drawn is not None) for key, table in vary.items())
        kinds = (RUN, *ANALYSES)
        if analysis not in kinds:
            raise InputError(
                "compute.analysis",
                analysis,
                f"one of {', '.join(kinds)}{did_you_mean(analysis, kinds)}",
            )
        kept = (keep,) if isinstance(keep, str) or callable(keep) else tuple(keep)
        for at, one in enumerate(kept):
            if not (isinstance(one, str) or callable(one)):
                raise InputError(f"compute.keep[{at}]", one, "a reduction, or a function")
        chosen = to_plain(dict(options or {}), "compute.options")
        table = scene.to_dict()
        limit = check_limit(time_limit)
        made = cls(name or scene.name, table, axes, drawn, analysis, kept, chosen, limit)
        made._check()
        return made

    def _check(self) -> None:
        """Raise InputError unless the scene has all varied keys, kept quantities have names of
        their own, and the scene accepts at least one point."""
        for one in self.axes:
            self._check_axis(one)
        names = {one.name for one in self.axes}
        for kept in variables(self):
            if kept.name in names or "/" in kept.name:
                allowed = "something else than a varied key, without a slash"
                raise InputError("compute.keep", kept.name, allowed)
            names.add(kept.name)
        try:
            reference_point(self)
        except InputError as first:
            if self.count <= MOST_TRIED:
                why = "such that the scene takes one point at least"
                why = f"{why} (of the first it says: {first})"
                raise InputError("vary", list(self.places), why) from None

    def _check_axis(self, one: Axis) -> None:
        """Raise InputError for a key that the scene does not have, or that takes none of these
        values."""
        self.place(one.name)
        values = one.values or tuple(one.value_at(share) for share in (0.0, 0.5, 1 - 1e-9))
        first: InputError | None = None
        for at in even_indices(0, len(values) - 1, min(len(values), MOST_TRIED)):
            try:
                self.system_at({one.name: values[at]})
                return
            except InputError as error:
                if error.allowed.startswith(UNKNOWN):
                    raise InputError(f"vary.{one.name}", values[at], error.allowed) from None
                if len(self.axes) > 1 and not _is_about(error, self.place(one.name)):
                    return  # another key may be what makes it possible
                first = first or error
        assert first is not None
        raise InputError(f"vary.{one.name}", first.value, first.allowed)


def _scene_from_table(table: dict[str, Any], folder: Path) -> Scene:
    try:
        return Scene.from_dict(read_table_files(table, folder))
    except InputError as error:
        raise InputError(f"scene.{error.field}", error.value, error.allowed) from None


def _check_keys(table: str, given: Mapping[str, Any]) -> None:
    known = KEYS[table]
    for key, value in given.items():
        if key not in known:
            name = f"{table}.{key}" if table else key
            raise InputError(name, value, unknown_key_message(key, known))


def _is_about(error: InputError, place: tuple[str, ...]) -> bool:
    """Whether an error is about a key."""
    return error.field.replace("[", ".").replace("]", "").startswith(".".join(place))


def _values_text(axis: Axis) -> str:
    """Return the number of values as text, or the scale of the range from which they are drawn."""
    return f"{len(axis.values)}" if len(axis.values) else axis.scale
