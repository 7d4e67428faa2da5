"""How scenes come in and go out: files, tables, examples, and scenes made of scenes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

import tomli_w

from rodgen.scene.errors import SceneError
from rodgen.scene.examples import example, examples
from rodgen.scene.files import TABLES, with_tables
from rodgen.scene.keys import check_named, put_values
from rodgen.scene.lookup_table import to_lists
from rodgen.scene.plain import plain, read_table
from rodgen.scene.structure import check_links
from rodgen.scene.tables import Rod, Table

LINKS = "rod.links"


class Exchange(Table):
    """What makes scenes, and what is made of them; its one subclass is Scene."""

    if TYPE_CHECKING:  # which has the rod
        rod: Rod

        def with_links(self, links: int) -> Self: ...

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Read a scene from a TOML file, of at most 16 MB, 1e5 keys, and 50 levels; tables of
        numbers that an expression takes from a file are read from the folder of the scene.

        path: of the file.
        """
        path = Path(path)
        if path.stem in examples() and not path.exists():
            copied = f"a file that is there; `rodgen new {path.stem} --from {path.stem}` writes it"
            raise SceneError("scene", str(path), copied)
        table = read_table(path)
        try:
            return cls.from_dict(with_tables(table, path.parent))
        except SceneError as error:
            error.add_note(f"in {path}")
            raise

    @classmethod
    def from_dict(cls, table: dict[str, Any]) -> Self:
        """A scene of tables that are there already, checked as those of a file.

        table: all of them, by their names.
        """
        if not isinstance(table, dict):
            raise SceneError("scene", table, "a table")
        if "numbers" in table:
            raise SceneError(
                "numbers", table["numbers"], "absent: [parameters] has numbers by name"
            )
        return cls(**{str(key): value for key, value in table.items()})

    @classmethod
    def example(cls, name: str) -> Self:
        """One of the scenes that come with rodgen.

        name: its name, such as "missile"; `rodgen scenes` lists them.

        Raises SceneError, which names them all.
        """
        return cls.from_toml(example(name))

    def to_dict(self) -> dict[str, Any]:
        """The tables of the scene, without what it leaves out; `from_dict` makes it of them."""
        made = self.model_dump(exclude_none=True)
        if TABLES in made:
            made[TABLES] = {name: to_lists(table) for name, table in made[TABLES].items()}
        return made

    def to_toml(self) -> str:
        """The text of a TOML file from which `from_toml` makes a scene equal to this one; numbers
        of tables that were read from files stand in it."""
        return tomli_w.dumps(self.to_dict())

    def replace(self, changes: Mapping[str, Any] | None = None, /, **others: Any) -> Self:
        """A scene with other values of keys, by their dotted names, checked as in a file.

        changes: values by names, in SI units; others: none, since dotted names are no keywords.

        Names are those of the tables, such as "loads.follower.force"; bodies go by their names
        ("bodies.payload.mass"), other tables of an array by their numbers from 0 on
        ("supports.0.at"). A value may be a whole table, and None leaves the key out. Another
        number of links ("rod.links") converts damping as `with_links` does. Raises SceneError.

            weaker = scene.replace({"loads.follower.force": 300, "initial.phi": "0.1*s"})
        """
        if others or not isinstance(changes, Mapping):
            allowed = 'a dictionary of values by dotted names, such as {"rod.length": 3}'
            raise SceneError("changes", others or changes, allowed)
        given = {str(name): plain(value, str(name)) for name, value in changes.items()}
        made = with_values(self, given)
        for name, value in given.items():
            if value is not None:
                check_named(made.to_dict(), name.split("."), (name, value))
        return made


Made = TypeVar("Made", bound=Exchange)


def with_values(scene: Made, given: Mapping[str, Any]) -> Made:
    """The scene with plain values of keys, as `Scene.replace` makes it; a number that no expression
    names may be among them. Raises SceneError."""
    table, links = scene.model_dump(exclude_none=True), given.get(LINKS)
    if links not in (None, scene.rod.links):
        check_links(links, scene.rod.boundary, LINKS)
        table = scene.with_links(links).model_dump(exclude_none=True)
        given = {name: value for name, value in given.items() if name != LINKS}
    put_values(table, given, type(scene))
    return scene.from_dict(table)
