"""A library is built once; what is in the cache and is not what was stored is built again."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sysconfig
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rodgen.native import library
from rodgen.native.library import cache_root
from tests.generated.library.conftest import ANSWERS, HEADER, REAL, SOURCE, Place

ME, NOBODY = os.getuid(), 65534


def test_library_is_built_once(place: Place) -> None:
    place.compiler()
    assert place.works(3)
    assert len(place.built()) == 1
    (entry,) = place.cache.iterdir()
    assert sorted(path.name for path in entry.iterdir()) == ["rod.sha256", "rod.so"]
    assert place.left() == [entry.name]
    assert place.cache.stat().st_mode & 0o777 == 0o700


CHANGES: dict[str, Callable[[Place], Any]] = {
    "source": lambda place: place.write(SOURCE.replace("2.0*x", "x + x")),
    "header": lambda place: place.write(header=HEADER + "\n"),
    "flags": lambda place: place.patch.setenv("RODGEN_CFLAGS", "-O1"),
    "version": lambda place: place.compiler(answers=ANSWERS.replace("1.0", "1.1")),
    "processor": lambda place: place.patch.setattr(
        library, "processor_features", lambda: "flags: none"
    ),
    "Python": lambda place: place.patch.setattr(
        sysconfig, "get_config_var", lambda name: "cpython-399"
    ),
    "format": lambda place: place.patch.setattr(library, "_FORMAT", "another"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_change_is_built_anew(change: str, place: Place) -> None:
    place.compiler()
    assert place.works()
    CHANGES[change](place)
    assert place.works()
    assert len(list(place.cache.glob("*/rod.so"))) == 2


DAMAGES: dict[str, Callable[[bytes, str], tuple[bytes | None, str | None]]] = {
    "truncated": lambda so, sums: (so[: len(so) // 2], sums),
    "empty": lambda so, sums: (b"", sums),
    "garbage": lambda so, sums: (b"\0garbage" * 500, sums),
    "wrong digest": lambda so, sums: (so, "0" * 64 + sums[64:]),
    "no digest": lambda so, sums: (so, None),
    "no library": lambda so, sums: (None, sums),
    "unreadable digest": lambda so, sums: (so, "\0\udcff"),
    # As another architecture's library would be: whole, but nothing to load.
    "foreign": lambda so, sums: (
        b"",
        "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855  rod.so\n",
    ),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_entry_is_built_anew(damage: str, place: Place) -> None:
    place.compiler()
    assert place.works()
    (library,) = place.cache.glob("*/rod.so")
    sums = library.with_suffix(".sha256")
    content, text = DAMAGES[damage](library.read_bytes(), sums.read_text())
    # New files: this process runs the library that it has loaded from the old one.
    library.unlink()
    sums.unlink()
    if content is not None:
        library.write_bytes(content)
    if text is not None:
        sums.write_bytes(text.encode(errors="surrogateescape"))
    assert place.works(2)
    assert len(place.built()) == 2


def test_entry_is_a_file(place: Place) -> None:
    assert place.works()
    (entry,) = place.cache.iterdir()
    shutil.rmtree(entry)
    entry.write_text("not a directory")
    assert place.works()


def _folder(path: Path, mode: int) -> None:
    path.mkdir(parents=True, exist_ok=True)
    path.chmod(mode)


def _refuses_folders(place: Place) -> None:
    """As a read-only file system does, to root too."""
    usual = tempfile.mkdtemp

    def refuse(suffix: str | None = None, prefix: str | None = None, dir: Any = None) -> str:
        if dir is not None and Path(dir) == place.cache:
            raise OSError(30, "Read-only file system", str(dir))
        return usual(suffix, prefix, dir)

    place.patch.setattr(tempfile, "mkdtemp", refuse)


def _nobody_is_at_home(place: Place) -> None:
    def home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    place.patch.setattr(Path, "home", home)
    place.patch.delenv("RODGEN_CACHE")


def _root_is_a_file(place: Place) -> None:
    place.cache.parent.write_text("not a directory")


UNUSABLE: dict[str, Callable[[Place], Any]] = {
    "root is a file": _root_is_a_file,
    "is a file": lambda place: (place.cache.parent.mkdir(), place.cache.write_text("no folder")),
    "others may write": lambda place: _folder(place.cache, 0o777),
    "group may write": lambda place: _folder(place.cache, 0o770),
    "root of all": lambda place: (_folder(place.cache, 0o700), _folder(place.cache.parent, 0o777)),
    "refuses folders": _refuses_folders,
    "nobody at home": _nobody_is_at_home,
    **({"read-only": lambda place: _folder(place.cache, 0o500)} if ME else {}),  # but for root
}


@pytest.mark.parametrize("spoilt", UNUSABLE)
def test_unusable_cache_costs_only_time(spoilt: str, place: Place) -> None:
    place.compiler()
    UNUSABLE[spoilt](place)
    assert place.works(2)
    assert len(place.built()) == 2
    assert not any(place.temporary.iterdir())
    assert not place.cache.is_dir() or not any(place.cache.iterdir())


def test_library_that_cannot_be_loaded_from_the_cache(place: Place) -> None:
    """But from where else it is built."""
    place.compiler(f'case "$PWD" in */cache/*) echo no > rod.so;; *) exec {REAL} "$@";; esac')
    assert place.works()
    assert not any(place.cache.iterdir())


def _given(path: Path) -> None:
    if ME:
        pytest.skip("needs root, to give a file to another user")
    os.chown(path, NOBODY, NOBODY)


def _pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path, 0o600)


STRANGE: dict[str, Callable[[Place], Any]] = {
    "of another user": lambda place: place.patch.setattr(os, "getuid", lambda: ME + 1),
    "open to others": lambda place: next(place.cache.iterdir()).chmod(0o777),
    "entry of another": lambda place: _given(next(place.cache.iterdir())),
    "library of another": lambda place: _given(next(place.cache.glob("*/rod.so"))),
    "open library": lambda place: next(place.cache.glob("*/rod.so")).chmod(0o707),
    "sum of another": lambda place: _given(next(place.cache.glob("*/rod.sha256"))),
    "pipe": lambda place: _pipe(next(place.cache.glob("*/rod.so"))),  # and is not waited for
    "pipe of a sum": lambda place: _pipe(next(place.cache.glob("*/rod.sha256"))),
}
PLANTED = """
#include <stdio.h>
__attribute__((constructor)) static void planted(void) { fclose(fopen("%s", "w")); }
"""


@pytest.mark.parametrize("strange", STRANGE)
def test_library_that_others_may_have_written_is_not_loaded(strange: str, place: Place) -> None:
    place.compiler()
    assert place.works()
    STRANGE[strange](place)
    assert place.works()
    assert len(place.built()) == 2


def test_library_planted_by_another_user_does_not_run(place: Place, tmp_path: Path) -> None:
    """As the user's own it does."""
    flag, other = tmp_path / "flag", tmp_path / "other.c"
    assert place.works()
    (library,) = place.cache.glob("*/rod.so")
    other.write_text(SOURCE.replace("rod.h", str(place.folder / "rod.h")) + PLANTED % flag)
    for owner in (ME, NOBODY):
        library.unlink()
        subprocess.run([REAL, "-fPIC", "-shared", other, "-o", library], check=True)
        library.chmod(0o700)
        sums = library.with_suffix(".sha256")
        sums.write_text(f"{hashlib.sha256(library.read_bytes()).hexdigest()}  rod.so\n")
        sums.chmod(0o600)
        if owner != ME:
            _given(library)
        assert place.works()
        assert flag.exists() == (owner == ME)
        flag.unlink(missing_ok=True)


def test_cache_root(tmp_path: Path, place: Place) -> None:
    """A relative XDG_CACHE_HOME is none, as its specification says."""
    place.patch.setattr(Path, "home", lambda: tmp_path)
    home = tmp_path / ".cache" / "rodgen"
    bases = {str(tmp_path / "xdg"): tmp_path / "xdg" / "rodgen", "relative": home, "": home}
    for override in (str(tmp_path), "relative", "", None):
        for base in (*bases, None):
            for variable, value in (("RODGEN_CACHE", override), ("XDG_CACHE_HOME", base)):
                if value is None:
                    place.patch.delenv(variable, raising=False)
                else:
                    place.patch.setenv(variable, value)
            assert cache_root() == (Path(override) if override else bases.get(base or "", home))


def test_nowhere_to_build(place: Place) -> None:
    _root_is_a_file(place)
    place.patch.setattr(tempfile, "tempdir", str(place.folder / "rod.c"))
    message = place.fails()
    assert all(name in message for name in ("RODGEN_CACHE", "TMPDIR"))


def test_names_of_folders(tmp_path: Path, place: Place) -> None:
    for name in ("with some spaces", "Prüfkörper-棒", "quote's $HOME; *"):
        place.folder, place.cache = tmp_path / name / "modules", tmp_path / name / "cache" / "c"
        place.folder.mkdir(parents=True)
        place.write()
        place.patch.setenv("RODGEN_CACHE", str(tmp_path / name / "cache"))
        assert place.works(2)
        assert len(list(place.cache.glob("*/rod.so"))) == 1
