"""Scenes beyond all measure: refused in one line before they cost time or memory."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from rodgen.scene import Scene
from rodgen.scene.grammar.syntax_tree import BRACKETS, MOST_CHOICES
from rodgen.scene.plain_tables import DEEPEST, LARGEST, LONGEST, MOST_KEYS, MOST_VALUES
from rodgen.scene.tables import MOST_TABLES
from tests.scene.tables import ROD, scene_of, table_of
from tests.scene.tables import TOML as HEAD
from tests.told import Refusal, refused

PHI = "[initial]\nphi = ["
MANY = 2 * MOST_KEYS
LONG = 30.0  # seconds: a hundred times what it takes; read twice, it would be hours
NONE = None  # no limit but that of the language


def _deep(levels: int) -> str:
    return PHI[:-1] + "[" * levels + "0.1" + "]" * levels


# What follows the head, and a number that the message names: a limit, or the line.
FILES: list[tuple[str, float | None]] = [
    (_deep(500), DEEPEST),
    (_deep(500).replace("[[", "[ # ]]\n["), DEEPEST),
    ('a = [\'\\\\\', "\\"]", ' + "[" * 500, DEEPEST),
    ("a = " + "{b = " * 500 + "1" + "}" * 500, DEEPEST),
    (".".join("a" * 10_000) + " = 1", DEEPEST),
    (" . ".join(["'a'"] * 100) + " = 1", DEEPEST),
    ("[" + ".".join("a" * 10_000) + "]", DEEPEST),
    ("".join(f"k{i}=1\n" for i in range(MANY)), MOST_KEYS),
    ("".join(f"a.a.a.a.k{i}=1\n" for i in range(30_000)), MOST_KEYS),
    ("".join(f"[a{i}]\n" for i in range(MANY)), MOST_KEYS),
    (PHI + "1.0," * (MOST_VALUES + 1) + "]", MOST_VALUES),
    (PHI + "'a'," * (MOST_VALUES + 1) + "]", MOST_VALUES),
    ("".join(f"{i}.5.5 = 1\n" for i in range(60_000)), MOST_KEYS),  # keys, and no numbers
    ("#" + "x" * LARGEST, LARGEST / 1e6),
    ("# a\rb\n", 7),
    ("\0", 7),
    # What a scan that reads anything twice would take hours for.
    ('a = "' + '\\"' * 300_000, NONE),
    ("a = " + '"""\\' * 300_000, NONE),
    ("a " * 300_000, NONE),
]


def _at_once(make: Callable[..., object], *of: Any) -> Refusal:
    begin = time.process_time()
    told = refused(make, *of)
    assert time.process_time() - begin < LONG
    return told


def test_file_is_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    texts = [(HEAD + text, number) for text, number in FILES]
    texts += [(HEAD.replace("\n", "\r"), 1), ("\ufeff" + HEAD, 1), ("[" * 5000, DEEPEST)]
    texts += [("name = \n", 1), ("name = " + "9" * 5000, NONE)]
    for text, number in texts:
        path.write_bytes(text.encode())
        told = _at_once(Scene.from_toml, path)
        assert told[:2] == ("scene", str(path))
        assert number is None or number in told.numbers, (text[:200], told.allowed)
    path.write_text(f"{HEAD}# a comment\nlinks == 4  # what is wrong\n")
    assert "links == 4" in refused(Scene.from_toml, path).allowed
    path.write_text(f"{HEAD}links = {' ' * 5000}= 4 {'#' * 5000}\n")  # a part of the line alone
    assert "= 4" in refused(Scene.from_toml, path).allowed
    path.write_bytes(b"\xff\xfe\x00")  # no UTF-8
    assert refused(Scene.from_toml, path)[:2] == ("scene", str(path))


def test_files_within_the_limits_are_read(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    name = HEAD.replace('"a"', "'''a'''# " + "[" * 999 + "\n")
    path.write_bytes(name.replace("\n", "\r\n").encode())
    assert Scene.from_toml(path).rod.links == 5
    count = 30_000
    many = HEAD.replace("links = 5", f"links = {count}") + PHI
    path.write_text(many + "0.25," * count + "]", encoding="utf-8")
    assert Scene.from_toml(path).initial_state().sum() == 0.25 * count
    knots = [i / 3 for i in range(2 * count)]
    path.write_text(f"{HEAD}[tables.f]\nknots = {knots}\nvalues = {knots}", encoding="utf-8")
    assert len(Scene.from_toml(path).tables["f"]) == 2 * count
    path.write_text(HEAD + _deep(40), encoding="utf-8")  # a list of lists, but not too deep
    assert refused(Scene.from_toml, path).field.startswith("initial.phi")


def test_what_is_no_file_is_not_waited_for(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path in (pipe, tmp_path, Path("/dev/zero"), "a\0b", tmp_path / "none.toml"):
        assert _at_once(Scene.from_toml, path)[:2] == ("scene", str(path))


def _nested(levels: int, made: Any) -> Any:
    value: Any = 0.1
    for _ in range(levels):
        value = made(value)
    return value


ENDLESS: list[Any] = []
ENDLESS.append(ENDLESS)
TABLES: list[tuple[dict[str, Any], str, int | None]] = [
    ({"initial": {"phi": _nested(5000, lambda value: [value])}}, "initial.phi", DEEPEST),
    ({"loads": _nested(5000, lambda value: {"a": value})}, "loads", DEEPEST),
    ({"initial": {"phi": ENDLESS}}, "initial.phi", DEEPEST),
    ({"rod": {**ROD, **dict.fromkeys(map(str, range(MANY)), 1)}}, "scene", MOST_KEYS),
    ({"initial": {"phi": ["a"] * MANY}}, "initial.phi.0", None),
    ({"events": [{}] * (MOST_KEYS + 1)}, "scene", MOST_KEYS),
    ({"initial": {"phi": [1.0] * (LONGEST + 1)}}, "initial.phi", LONGEST),
    ({"initial": {"phi": np.broadcast_to(1.0, 10**12)}}, "initial.phi", LONGEST),
    ({"a" * 10**6: 1}, "aaa", None),
]


def test_tables_from_python_are_refused_at_once() -> None:
    for tables, field, number in TABLES:
        told = _at_once(Scene.from_dict, {"name": "a", "rod": ROD} | tables)
        assert told.field.startswith(field)
        assert number is None or number in told.numbers


def test_arrays_of_python_may_be_as_long_as_a_rod() -> None:
    phi = np.full(MANY, 0.5)
    assert scene_of(rod={"links": MANY}, initial={"phi": phi}).initial_state().sum() == phi.sum()


def test_parentheses_of_an_expression() -> None:
    inside, beyond = ("(" * levels + "t" + ")" * levels for levels in (DEEPEST, DEEPEST + 1))
    scene_of(loads={"tip": {"x": inside}})
    told = refused(scene_of, loads={"tip": {"x": beyond}})
    assert told[:2] == ("loads.tip.x", beyond)
    assert DEEPEST in told.numbers


def test_more_tables_and_choices_than_a_scene_has_are_refused_at_once() -> None:
    """Ten thousand of them would take seconds each time that the scene is read."""
    many = 10 * MOST_TABLES
    tables: dict[str, Any] = {
        "states": {f"q{at}": {"rate": f"-q{at}"} for at in range(many)},
        "bodies": [{"name": f"b{at}", "at": at / many, "mass": 1.0} for at in range(many)],
        "events": [{"quantity": "tip_y", "value": float(at)} for at in range(many)],
        "supports": [{"at": at / many} for at in range(many)],
    }
    for key, given in tables.items():
        told = _at_once(Scene.from_dict, table_of(**{key: given}))
        assert (told.field, told.value) == (key, many)
        assert MOST_TABLES in told.numbers
    nested = "s + 1"
    for at in range(BRACKETS - 2):
        nested = f"min({nested}, {at + 2} + t*s)"
    few = MOST_CHOICES // (BRACKETS - 2)
    wide = f"max({', '.join(f'{at} - s' for at in range(MOST_CHOICES + 2))})"
    chosen = " + ".join(f"(s + {at} if s < 0.5 else 2)" for at in range(MOST_CHOICES + 1))
    for law in (" + ".join([nested] * (few + 1)), wide, chosen, f"abs({wide})"):
        rod = {"mass_per_length": law, "mass": None}
        told = _at_once(Scene.from_dict, table_of(rod=rod))
        assert told.field == "rod.mass_per_length"
        assert MOST_CHOICES in told.numbers
    for law in (" + ".join([nested] * few), wide.replace("0 - s, 1 - s, ", "")):
        scene_of(rod=ROD | {"mass_per_length": law, "mass": None})
