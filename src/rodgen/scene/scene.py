"""Scenes: read and written as files, tables and examples, and copied with other values."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, Self, Unpack

import tomli_w

from rodgen.display import Plottable
from rodgen.errors import InputError
from rodgen.model.terms import TERMS
from rodgen.scene.examples import examples, find_example
from rodgen.scene.integration import AUTO, IntegrationSettings, IntegrationTable, with_keywords
from rodgen.scene.keys import (
    NUMBERS,
    check_number_in_use,
    find_unused_names,
    find_value,
    set_values,
)
from rodgen.scene.lookup_table import to_lists
from rodgen.scene.mesh import with_links
from rodgen.scene.plain_tables import get_at, read_toml, to_plain
from rodgen.scene.scene_files import TABLES, read_table_files
from rodgen.scene.scene_tables import SceneTables
from rodgen.scene.term_texts import check_links

LINKS = "rod.links"

# Members that only systems, analyses and the making of modules read.
PARTS = (
    "loads_along_rod link_values_at anchors check_numbers_in_use time_laws distribution "
    "distribution_at expression expressions feedback_loads key_of n_fixed_links "
    "boundary_condition with_checked_settings with_method key_path state_rates "
    "has_no_tangent_stiffness spring_law time_dependent_loads unused_names with_settings "
    "clamp_angle_at given_parameters given_value mesh contacts term_numbers watched_events "
    "obstacles has_places_of_start airflow"
)


class Scene(SceneTables, Plottable):
    """A scene: a rod, its loads, its initial state, and how it is integrated.

    name: of the scene and of the folder of its results; numbers: those of [parameters], by name, in
    the units of the expressions that name them; tables: those of many rows, by the names by which
    expressions call them; rod, loads, initial, integrate: these tables;
    bodies, supports, stops, joint_stops, walls, events: lists of tables; foundation, base, air:
    their tables, or None; states: tables of the states that are added, by name.

    Values are in SI units, as in a file. A scene is checked when it is made, and cannot be changed
    afterwards. InputError names the field that cannot be used.

    Examples
    --------
    >>> import rodgen
    >>> rodgen.Scene.example("becks_column").replace({"rod.links": 10})
    <Scene becks_column: clamped rod of 10 links, follower; t = 0 to 20 s>
    >>> missile = rodgen.Scene.example("missile")
    >>> round(missile.breaks()[0], 12), missile.to_dict()["rod"]["length"]
    (0.5, 5.0)
    >>> missile.structure.n_links, missile.to_toml().splitlines()[0]
    (20, 'name = "missile"')
    """

    def __repr__(self) -> str:
        rod, (start, end) = self.rod, self.integrate.span
        terms = self.structure.loads
        acting = ", ".join(TERMS[name].words for name in terms) or "no loads"
        what = f"{rod.boundary} rod of {rod.links} links, {acting}"
        return f"<Scene {self.name}: {what}; t = {start:g} to {end:g} s>"

    __str__ = __repr__

    def __dir__(self) -> list[str]:
        """Names that editors complete, without those that only extensions of rodgen need."""
        return [name for name in super().__dir__() if name not in PARTS.split()]

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Read a scene from a TOML file, of at most 16 MB, 1e5 keys, and 50 levels; tables of
        numbers that an expression takes from a file are read from the folder of the scene.

        path: of the file.
        """
        path = Path(path)
        if path.stem in examples() and not path.exists():
            copied = f"a file that is there; `rodgen new {path.stem} --like {path.stem}` writes it"
            raise InputError("scene", str(path), copied)
        table = read_toml(path)
        try:
            return cls.from_dict(read_table_files(table, path.parent))
        except InputError as error:
            error.add_note(f"in {path}")
            raise

    @classmethod
    def from_dict(cls, table: dict[str, Any]) -> Self:
        """Make a scene from a dictionary of tables, checked as those of a file.

        table: all of them, by their names.
        """
        if not isinstance(table, dict):
            raise InputError("scene", table, "a table")
        if "numbers" in table:
            raise InputError(
                "numbers", table["numbers"], "absent: [parameters] has numbers by name"
            )
        return cls(**{str(key): value for key, value in table.items()})

    @classmethod
    def example(cls, name: str) -> Self:
        """Load one of the scenes that come with rodgen.

        name: its name, such as "missile"; `rodgen scenes` lists them.

        Raises InputError, which names them all.
        """
        return cls.from_toml(find_example(name))

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary of tables, without absent keys, which `from_dict` reads."""
        made = self.model_dump(exclude_none=True)
        if TABLES in made:
            made[TABLES] = {name: to_lists(table) for name, table in made[TABLES].items()}
        return made

    def to_toml(self) -> str:
        """Write the scene as text of a TOML file, which `from_toml` reads to an equal scene;
        numbers of tables that were read from files stand in it, empty lists and tables do not."""
        return tomli_w.dumps(_without_empty(self.to_dict()))

    def replace(self, changes: Mapping[str, Any] | None = None, /, **others: Any) -> Scene:
        """Copy with other values of keys, by their dotted names, checked as in a file.

        changes: values by names, in SI units; others: none, since dotted names are no keywords.

        Names are those of the tables, such as "loads.follower.force"; bodies go by their names
        ("bodies.payload.mass"), other tables of an array by their numbers from 0 on
        ("supports.0.at"). A value may be a whole table, and None leaves the key out. Another
        number of links ("rod.links") converts damping as `with_links` does. Raises InputError.

            weaker = scene.replace({"loads.follower.force": 300, "initial.phi": "0.1*s"})
        """
        if others or not isinstance(changes, Mapping):
            allowed = 'a dictionary of values by dotted names, such as {"rod.length": 3}'
            raise InputError("changes", others or changes, allowed)
        given = {str(name): to_plain(value, str(name)) for name, value in changes.items()}
        made = with_values(self, given)
        made.check_numbers_in_use(given)
        return made

    @cached_property
    def unused_names(self) -> tuple[str, ...]:
        """Sentences on the numbers and tables that no expression names."""
        if not (self.numbers or self.tables):
            return ()
        given = self.model_dump(exclude_none=True)
        return tuple(find_unused_names(given, self.numbers, self.tables))

    def check_numbers_in_use(self, given: Mapping[str, Any]) -> None:
        """Raise InputError for values, by their keys, of numbers that no expression names.

        given: values by dotted names.
        """
        for name, value in given.items():
            if name.startswith(f"{NUMBERS}.") and value is not None:
                check_number_in_use(
                    self.model_dump(exclude_none=True), name.split("."), (name, value)
                )

    def value_of(self, key: str, field: str = "vary") -> Any:
        """The value of a key, None where it is left out.

        key: its dotted name; field: what messages call it.

        Raises InputError for what is no key with one value.
        """
        keys, value = find_value(self.model_dump(exclude_none=True), key, field)
        if not isinstance(value, str):
            return value
        # What is a text in a file may be a number.
        return get_at(self.numbers if keys[0] == NUMBERS else getattr(self, keys[0]), *keys[1:])

    @with_keywords
    def with_integrate(self, **given: Unpack[IntegrationSettings]) -> Self:
        """Copy with other values in [integrate]; None keeps a value.

        A tolerance replaces a step of the scene where the method can use either, and output_every
        replaces t_eval.
        """
        settings = self.integrate.with_values(**given)
        if settings is self.integrate:
            return self
        return self.with_checked_settings(settings)

    def with_checked_settings(self, settings: IntegrationTable) -> Self:
        """Copy with other settings, checked as far as it depends on them.

        settings: all of [integrate].

        Raises InputError for what cannot be so within the span.
        """
        made = self.with_settings(settings)
        if settings.span != self.integrate.span:
            made._check_span()
        return made

    def with_settings(self, settings: IntegrationTable) -> Self:
        """Copy with settings that were checked already; nothing else is checked.

        settings: all of [integrate].
        """
        made = self.model_copy(update={"integrate": settings})
        made.__dict__.pop("time_laws", None)
        return made

    def with_method(self, method: str) -> Scene:
        """Copy with the method that was chosen for it. What `auto` chooses takes no equal steps,
        whatever the step in the scene.

        method: its name.
        """
        found: dict[str, Any] = {"method": method}
        if self.integrate.method == AUTO:
            found["step"] = None
        return self.with_settings(self.integrate.model_copy(update=found))

    def with_links(self, links: int) -> Self:
        """Copy with another number of links: coefficients of damping that depend on the number of
        links are converted, c_int by (n'/n)^2, a fin by n'/n.

        links: how many.

        Raises InputError for a number that is not allowed, and for a scene that has a list of a
        value for every link or watches one of its links.
        """
        return self.from_dict(with_links(self, links))


def _without_empty(table: dict[str, Any]) -> dict[str, Any]:
    """Copy of a table without lists and tables that are empty, at any depth."""
    made = {k: _without_empty(v) if isinstance(v, dict) else v for k, v in table.items()}
    return {key: value for key, value in made.items() if value not in ({}, [])}


def with_values(scene: Scene, given: Mapping[str, Any]) -> Scene:
    """Copy of a scene with plain values of keys, as by `Scene.replace`; also of numbers that no
    expression names. Raises InputError."""
    table, links = scene.model_dump(exclude_none=True), given.get(LINKS)
    if links not in (None, scene.rod.links):
        check_links(links, scene.rod.boundary, LINKS)
        table = scene.with_links(links).model_dump(exclude_none=True)
        given = {name: value for name, value in given.items() if name != LINKS}
    set_values(table, given, type(scene))
    return scene.from_dict(table)
