"""Generated C compiles as any compiler has it by default, and beside another of its kind."""

from __future__ import annotations

import ctypes
import importlib
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from ctypes.util import find_library
from pathlib import Path

import pytest

from rodgen.scene.structure import TERMS, Structure

Written = Callable[..., dict[str, str]]
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]
pytestmark = pytest.mark.skipif(not COMPILERS, reason="no C compiler on PATH")
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic")
DIALECTS = ("", "-std=c99", "-std=gnu99", "-std=c11", "-std=gnu17", "-D_GNU_SOURCE")
# Pairs and numbers, cut into segments and not, on the stack and not, with all loads and none.
STRUCTURES = [
    Structure(1, terms=TERMS),
    Structure(3, "cantilever", "lumped", TERMS),
    Structure(20, "clamped", terms=TERMS),
    Structure(50, "free", terms=()),
]
TWO = [
    Structure(2, "pinned", terms=("follower",), expressions=(("follower_force", text),))
    for text in ("2*t", "3*t")
]
# Of mathematics in the C libraries of other systems, and older ones.
ELSEWHERE = {
    *("drem", "exp10", "finite", "gamma", "pow10", "roundeven", "scalb", "sincos", "sinpi"),
    *("cospi", "significand", "nextup", "nextdown", "canonicalize", "fmaximum", "fminimum"),
}


def _write(files: dict[str, str], folder: Path) -> str:
    """The stem of the files, written into a folder."""
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return Path(next(iter(files))).stem


def _run(*command: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_dialect_takes_it_without_a_warning(
    written: Written, tmp_path: Path, compiler: str, dialect: str
) -> None:
    stems = [_write(written(structure, "c"), tmp_path) for structure in (*STRUCTURES, *TWO)]
    flags = [flag for flag in (*WARNINGS, dialect, "-fsyntax-only") if flag]
    done = _run(compiler, *flags, *(f"{stem}.c" for stem in stems), cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("structure", STRUCTURES, ids=lambda s: s.stem)
def test_no_c_library_has_the_names_of_its_functions(
    written: Written, structure: Structure
) -> None:
    code = next(text for name, text in written(structure, "c").items() if name.endswith(".c"))
    names = set(re.findall(r"^static [\w ]*?[ *](\w+)\(", code, re.M))
    assert {"square", "step", "dense", "real_solve"} <= names
    libraries = [ctypes.CDLL(path) for path in map(find_library, ("c", "m")) if path]
    taken = {name for name in names if any(hasattr(library, name) for library in libraries)}
    assert taken | (names & ELSEWHERE) == set()


def test_fast_math_is_refused(written: Written, tmp_path: Path) -> None:
    stem = _write(written(STRUCTURES[0], "c"), tmp_path)
    for flag in ("-ffast-math", "-ffinite-math-only", "-Ofast"):
        done = _run(COMPILERS[0], flag, "-fsyntax-only", f"{stem}.c", cwd=tmp_path)
        assert done.returncode != 0
        assert "not with -ffast-math" in done.stderr


@pytest.mark.skipif(not shutil.which("g++"), reason="no C++ compiler on PATH")
def test_header_is_one_of_c_plus_plus_too(written: Written, tmp_path: Path) -> None:
    stem = _write(written(STRUCTURES[1], "c"), tmp_path)
    program = f'#include "{stem}.h"\n#include "{stem}.h"\n'
    program += f"int main() {{ return (int)({stem}_work() == 0) + {stem.upper()}_EULER; }}\n"
    (tmp_path / "main.cpp").write_text(program)
    assert _run(COMPILERS[0], "-c", f"{stem}.c", cwd=tmp_path).returncode == 0
    done = _run("g++", *WARNINGS, "main.cpp", f"{stem}.o", "-lm", "-o", "main", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert _run("./main", cwd=tmp_path).returncode == 0


PROGRAM = """
#include "@0.h"
#include "@1.h"
#include <stdio.h>

int main(void)
{
    const double y[4] = {0.1, 0.4, 0.2, -0.3}, p[] = {3.0, 2.0, 30.0, 0.1};
    double dy[4];
    @0_rhs(0.5, y, p, dy);
    printf("%.17g\\n", dy[3]);
    @1_rhs(0.5, y, p, dy);
    printf("%.17g\\n", dy[3]);
    return 0;
}
"""


def test_two_that_differ_in_an_expression_link_and_import_together(
    written: Written, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stems = [_write(written(structure, "c"), tmp_path) for structure in TWO]
    program = PROGRAM.replace("@0", stems[0]).replace("@1", stems[1])
    (tmp_path / "main.c").write_text(program)
    sources = ["main.c", *(f"{stem}.c" for stem in stems)]
    done = _run(COMPILERS[0], *WARNINGS, *sources, "-lm", "-o", "main", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    printed = [float(line) for line in _run("./main", cwd=tmp_path).stdout.split()]
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    modules = [importlib.import_module(_write(written(each), tmp_path)) for each in TWO]
    p = modules[0].parameters(mass=3.0, length=2.0, bending_stiffness=30.0, follower_angle=0.1)
    rates = [module.rhs(0.5, [0.1, 0.4, 0.2, -0.3], p)[3] for module in modules]
    # Rounding of some ten operations.
    assert printed == pytest.approx(rates, rel=1e-13)
    assert rates[0] != rates[1]
