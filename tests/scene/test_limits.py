"""Scenes beyond all measure: refused in one line before they cost time or memory."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rodgen.scene import Scene, SceneError
from rodgen.scene.plain import DEEPEST, LARGEST, LONGEST, MOST_KEYS
from tests.scene.tables import ROD

HEAD = 'name = "a"\n[rod]\n' + "".join(f"{key} = {value}\n" for key, value in ROD.items())
LONG = 30.0  # seconds: ten times and more what it takes; read twice, it would be hours


def _deep(levels: int) -> str:
    return HEAD + "[initial]\nphi = " + "[" * levels + "0.1" + "]" * levels


FILES = {
    "arrays": (_deep(500), "50 deep"),
    "arrays in lines": (_deep(500).replace("[[", "[ # ]]\n["), "50 deep"),
    "after strings": (HEAD + 'a = [\'\\\\\', "\\"]", ' + "[" * 500, "50 deep"),
    "tables": (HEAD + "a = " + "{b = " * 500 + "1" + "}" * 500, "50 deep"),
    "dotted key": (HEAD + ".".join("a" * 10_000) + " = 1", "50 deep"),
    "quoted dotted key": (HEAD + " . ".join(["'a'"] * 100) + " = 1", "50 deep"),
    "dotted table": (HEAD + "[" + ".".join("a" * 10_000) + "]", "50 deep"),
    "keys": (HEAD + "".join(f"k{i}=1\n" for i in range(10**6)), "100000 keys and values"),
    "dotted keys": (HEAD + "".join(f"a.a.a.a.k{i}=1\n" for i in range(30_000)), "100000 keys"),
    "tables one by one": (HEAD + "".join(f"[a{i}]\n" for i in range(10**6 // 4)), "100000 keys"),
    "numbers": (HEAD + "[initial]\nphi = [" + "1.0," * 10**6 + "]", "100000 keys and values"),
    "texts": (HEAD + "[initial]\nphi = [" + "'a'," * 10**6 + "]", "100000 keys and values"),
    "bytes": (HEAD + "#" + "x" * LARGEST, "10 MB"),
    "carriage returns": (HEAD.replace("\n", "\r"), "carriage return .* line 1"),
    "a carriage return": (HEAD + "# a\rb\n", "carriage return .* line 7"),
    "byte order mark": ("\ufeff" + HEAD, "byte order mark"),
    "nul": (HEAD + "\0", "NUL, as in line 7"),
    # What a scan that reads anything twice would take hours for.
    "escapes": (HEAD + 'a = "' + '\\"' * 2_000_000, "valid TOML"),
    "quotes": (HEAD + "a = " + '"""\\' * 1_000_000, "valid TOML"),
    "words": ("a " * 2_000_000, "valid TOML"),
}


@pytest.mark.parametrize("what", FILES)
def test_file_is_refused_at_once(what: str, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    content, reason = FILES[what]
    path = Path("scene.toml")
    path.write_bytes(content.encode())
    begin = time.process_time()
    with pytest.raises(SceneError, match=reason) as error:
        Scene.from_toml(path)
    assert time.process_time() - begin < LONG
    assert "\n" not in str(error.value)
    assert "scene.toml" in str(error.value)


def test_files_within_the_limits_are_read(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    brackets = "# " + "[" * 999 + "\n"
    name = HEAD.replace('"a"', "'''a'''" + brackets)
    path.write_bytes(name.replace("\n", "\r\n").encode())
    assert Scene.from_toml(path).rod.links == 5
    count = 30_000
    many = HEAD.replace("links = 5", f"links = {count}") + "[initial]\nphi = ["
    path.write_text(many + "0.25," * count + "]", encoding="utf-8")
    assert Scene.from_toml(path).initial_state().sum() == 0.25 * count
    path.write_text(_deep(40), encoding="utf-8")
    with pytest.raises(SceneError, match=r"initial\.phi"):  # a list of lists, but not too deep
        Scene.from_toml(path)


def test_what_is_no_file_is_not_waited_for(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path, reason in (
        (pipe, "this is a pipe"),
        (tmp_path, "this is a folder"),
        (Path("/dev/zero"), "this is a device"),
        ("a\0b", "null"),
    ):
        with pytest.raises(SceneError, match=reason):
            Scene.from_toml(path)


def _nested(levels: int, made: Any) -> Any:
    value: Any = 0.1
    for _ in range(levels):
        value = made(value)
    return value


ENDLESS: list[Any] = []
ENDLESS.append(ENDLESS)
TABLES: dict[str, tuple[dict[str, Any], str]] = {
    "lists": ({"initial": {"phi": _nested(5000, lambda value: [value])}}, "50 tables and lists"),
    "tables": ({"loads": _nested(5000, lambda value: {"a": value})}, "50 tables and lists"),
    "itself": ({"initial": {"phi": ENDLESS}}, "50 tables and lists"),
    "keys": ({"rod": {**ROD, **{f"k{i}": 1 for i in range(10**6)}}}, "100000 keys"),
    "texts": ({"initial": {"phi": ["a"] * 10**6}}, r"initial\.phi\.0 = 'a'"),
    "tables in a list": ({"events": [{}] * 10**5 + [{}]}, "100000 keys"),
    "numbers": ({"initial": {"phi": [1.0] * (LONGEST + 1)}}, "2000000 values"),
    "array": ({"initial": {"phi": np.broadcast_to(1.0, 10**12)}}, "2000000 numbers"),
    "long key": ({"a" * 10**6: 1}, "not a known key"),
}


@pytest.mark.parametrize("what", TABLES)
def test_tables_from_python_are_refused_at_once(what: str) -> None:
    tables, reason = TABLES[what]
    begin = time.process_time()
    with pytest.raises(SceneError, match=reason) as error:
        Scene.from_dict({"name": "a", "rod": ROD, **tables})
    assert time.process_time() - begin < LONG
    assert len(str(error.value)) < 1000
    assert "\n" not in str(error.value)


def test_arrays_of_python_may_be_as_long_as_a_rod() -> None:
    rod = {**ROD, "links": 2 * MOST_KEYS}
    phi = np.full(2 * MOST_KEYS, 0.5)
    scene = Scene.from_dict({"name": "a", "rod": rod, "initial": {"phi": phi}})
    assert scene.initial_state().sum() == phi.sum()


def test_parentheses_of_an_expression() -> None:
    for levels in (DEEPEST, DEEPEST + 1):
        table = {"tip": {"x": "(" * levels + "t" + ")" * levels}}
        if levels == DEEPEST:
            assert Scene.from_dict({"name": "a", "rod": ROD, "loads": table})
            continue
        with pytest.raises(SceneError, match=r"loads\.tip\.x = .* at most 50 deep"):
            Scene.from_dict({"name": "a", "rod": ROD, "loads": table})
