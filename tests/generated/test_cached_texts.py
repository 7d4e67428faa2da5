"""Texts in the cache are run as Python: those that others can have written are none."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

import rodgen
from rodgen.loading import cache
from rodgen.loading.build import sources
from tests.palette import SMALL

PINNED = SMALL[4]
NOBODY, ROOT = 65534, os.getuid() == 0
ENTRY = ("modules", "0" * 32, "text.json")


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache."""
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "above" / "cache"))
    return tmp_path / "above" / "cache"


def stored(root: Path, text: str = "text", entry: tuple[str, ...] = ENTRY) -> Path:
    """The file of an entry that can be read."""
    assert cache.store_text(text, *entry)
    assert cache.read_text(*entry) == text
    return root.joinpath(*entry)


def test_entries_are_those_of_one_user(root: Path) -> None:
    """Whatever the mask of the user."""
    before = os.umask(0)
    try:
        file = stored(root)
    finally:
        os.umask(before)
    assert file.stat().st_mode & 0o777 == 0o600
    for folder in (root, file.parent.parent, file.parent):
        assert folder.stat().st_mode & 0o777 == 0o700


def _linked(file: Path) -> None:
    file.rename(file.with_name("other"))
    file.symlink_to("other")


def _pipe(file: Path) -> None:
    file.unlink()
    os.mkfifo(file, 0o600)


def _given(path: Path) -> None:
    if not ROOT:
        pytest.skip("needs root, to give a file to another user")
    os.chown(path, NOBODY, NOBODY)


STRANGE: dict[str, Callable[[Path, Path, pytest.MonkeyPatch], object]] = {
    "all of another": lambda file, _, patch: patch.setattr(os, "getuid", lambda: NOBODY + 1),
    "file of another": lambda file, *_: _given(file),
    "folder of another": lambda file, *_: _given(file.parent),
    "root of another": lambda _, root, __: _given(root),
    "open file": lambda file, *_: file.chmod(0o606),
    "file of a group": lambda file, *_: file.chmod(0o660),
    "open folder": lambda file, *_: file.parent.chmod(0o707),
    "open folder above": lambda file, *_: file.parent.parent.chmod(0o770),
    "open root": lambda _, root, __: root.chmod(0o707),
    "link": lambda file, *_: _linked(file),
    "pipe": lambda file, *_: _pipe(file),  # and is not waited for
    "folder": lambda file, *_: (file.unlink(), file.mkdir()),
}


@pytest.mark.parametrize("strange", STRANGE)
def test_what_others_may_have_written_is_no_entry(
    strange: str, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = stored(root)
    STRANGE[strange](file, root, monkeypatch)
    assert cache.read_text(*ENTRY) is None


def test_folders_of_ours_are_closed_and_roots_of_others_are_left_alone(root: Path) -> None:
    """A mask of 002 made folders that a group could write."""
    file = stored(root)
    file.parent.parent.chmod(0o775)
    assert cache.read_text(*ENTRY) is None
    stored(root)
    assert file.parent.parent.stat().st_mode & 0o777 == 0o700
    root.chmod(0o777)
    assert not cache.store_text("new", *ENTRY[:1], "1" * 32, ENTRY[2])
    assert [one.name for one in file.parent.parent.iterdir()] == ["0" * 32]
    assert root.stat().st_mode & 0o777 == 0o777


@pytest.mark.parametrize("target", ["numpy", pytest.param("c", marks=pytest.mark.compiler)])
def test_nothing_planted_runs(
    target: str, root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A module that another user has put into the cache, in place of the one that is asked for; as
    the user's own it does run."""
    flag = tmp_path / "flag"
    with cache.record_texts() as entries:
        sources(PINNED, target, parts=("rhs",))
    ((entry, text),) = entries.items()
    planted = f"import pathlib\npathlib.Path({str(flag)!r}).touch()\n"
    texts = {
        name: planted + one if name.endswith(".py") else one
        for name, one in json.loads(text).items()
    }
    file = stored(root, json.dumps(texts), entry)
    if ROOT:
        os.chown(file, NOBODY, NOBODY)
    else:
        file.chmod(0o666)
    rodgen.build(PINNED, target)
    assert not flag.exists()
    file.unlink()
    monkeypatch.setenv("RODGEN_CACHE", f"{root}/")  # where nothing is loaded from yet
    stored(root, json.dumps(texts), entry)
    rodgen.build(PINNED, target)
    assert flag.exists()


@pytest.mark.parametrize("text", ["[1]", "1", "null", "{", "", "[" * 10**5])
def test_entries_that_are_no_texts_are_made_again(text: str, root: Path) -> None:
    with cache.record_texts() as entries:
        made = sources(PINNED, "numpy", parts=("rhs",))
    (entry,) = entries
    cache.store_text(text, *entry)
    assert sources(PINNED, "numpy", parts=("rhs",)) == made
