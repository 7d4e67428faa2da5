"""A C file, an empty cache, and compilers that do what a test wants of them."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from rodgen.native.library import BuildError, load_library

REAL = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), "")
DECLARATIONS = "double twice(double); int is_nan(double); double inverse(double, double);"
HEADER = DECLARATIONS.replace("; ", ";\n") + "\n"
SOURCE = """
#include "rod.h"
double twice(double x) { return 2.0*x; }
int is_nan(double x) { return x != x; }
double inverse(double x, double y) { return 1.0/(x + y); }
"""
# What a compiler has to answer before it is asked to build anything.
ANSWERS = '[ "$1" = --version ] && { echo fake 1.0; exit 0; }\n'


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.compiler)


@dataclass
class Place:
    """Where a C file is built: folder holds rod.c and rod.h, cache the libraries, temporary is for
    temporary files, log for what a compiler that is not the real one was asked for."""

    folder: Path
    cache: Path
    temporary: Path
    log: Path
    patch: pytest.MonkeyPatch

    def write(self, source: str = SOURCE, header: str = HEADER) -> None:
        (self.folder / "rod.c").write_text(source)
        (self.folder / "rod.h").write_text(header)

    def compiler(self, body: str = f'exec {REAL} "$@"', answers: str = ANSWERS) -> Path:
        """Set CC to a shell script."""
        program = self.log.with_name("fakecc")
        program.write_text(f'#!/bin/sh\n{answers}echo "$@" >> "{self.log}"\n{body}\n')
        program.chmod(0o755)
        self.patch.setenv("CC", f"'{program}'")
        self.log.write_text("")
        return program

    def built(self) -> list[str]:
        """What the compiler was asked for, but for its version."""
        return self.log.read_text().splitlines()

    def load(self, declarations: str = DECLARATIONS) -> Any:
        return load_library("rod", self.folder, declarations)[1]

    def works(self, times: int = 1) -> bool:
        """Whether the library is what its source says, so many times."""
        return [self.load().twice(21.0) for _ in range(times)] == [42.0] * times

    def fails(self, declarations: str = DECLARATIONS) -> str:
        """What the one error says: it tells of the NumPy target too."""
        with pytest.raises(BuildError) as caught:
            self.load(declarations)
        assert "--target numpy" in str(caught.value)
        return str(caught.value)

    def left(self) -> list[str]:
        """What lies in the cache that is no library, and among temporary files."""
        kept = [path for folder in (self.cache, self.temporary) for path in folder.rglob("*")]
        return [path.name for path in kept if path.name not in ("rod.so", "rod.sha256")]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Place:
    for variable in ("CC", "RODGEN_CFLAGS", "XDG_CACHE_HOME"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))
    made = Place(
        *(tmp_path / "modules", tmp_path / "cache" / "c", tmp_path / "temporary"),
        *(tmp_path / "log", monkeypatch),
    )
    made.folder.mkdir()
    made.temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(made.temporary))
    made.write()
    return made


def until(done: Callable[[], Any], seconds: float = 60.0) -> None:
    """Wait until something is done."""
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def alive(pid: int) -> bool:
    """Whether a process runs; one that has ended but that nobody has waited for does not."""
    done = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True)
    return done.stdout.strip()[:1] not in ("", "Z")
