"""The text of the C target: what is in it, which compilers take it, and as plain C."""

from __future__ import annotations

import ctypes
import importlib
import os
import re
import shutil
import sys
from ctypes.util import find_library
from pathlib import Path

import pytest

from rodgen.model.terms import TERMS
from rodgen.native.native_run import FILES
from rodgen.scene.structure import Structure
from tests.generated.conftest import Whole, Written, ran, write
from tests.palette import SMALL, TEXTS, short
from tests.sets import sets

COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]
pytestmark = pytest.mark.skipif(not COMPILERS, reason="no C compiler on PATH")
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic")
LOOPS = [f"rodgen_native/{name}" for name in FILES if name.endswith(".c")]
DIALECTS = ("", "-std=c99", "-std=gnu99", "-std=c11", "-std=gnu17", "-D_GNU_SOURCE")
EACH = pytest.mark.parametrize("structure", sets([SMALL[3]], slow=TEXTS), ids=short)
TWO = [
    Structure(2, "pinned", terms=("follower",), expressions=(("follower_force", text),))
    for text in ("2*t", "3*t")
]
# Of mathematics in the C libraries of other systems, and older ones.
ELSEWHERE = {
    *("drem", "exp10", "finite", "gamma", "pow10", "roundeven", "scalb", "sincos", "sinpi"),
    *("cospi", "significand", "nextup", "nextdown", "canonicalize", "fmaximum", "fminimum"),
}


def _compiles(compiler: str, *arguments: str, cwd: Path) -> None:
    done = ran(compiler, *WARNINGS, *arguments, cwd=cwd)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.nightly
@pytest.mark.parametrize("compiler", COMPILERS)
def test_every_dialect_takes_it_without_a_warning(
    whole: Whole, tmp_path: Path, compiler: str
) -> None:
    files = [f"{write(whole(each), tmp_path)}.c" for each in TEXTS]
    more = ("-Wvla", "-Wstrict-prototypes", "-Wmissing-prototypes", "-fsyntax-only")
    for dialect in DIALECTS:
        _compiles(compiler, *more, *([dialect] if dialect else []), *files, *LOOPS, cwd=tmp_path)


def _identifiers(text: str) -> set[str]:
    """Names in C code, without those in comments."""
    return set(re.findall(r"[A-Za-z_]\w*", re.sub(r"/\*.*?\*/", "", text, flags=re.S)))


@EACH
def test_text_holds_only_what_the_scene_has(whole: Whole, structure: Structure) -> None:
    """And its functions have no names of C libraries."""
    python, code, header, *_ = whole(structure).values()
    functions = set(re.findall(r"^static [\w ]*?[ *](\w+)\(", code, re.M))
    assert {"square", "quarter", "linearise", "real_solve"} <= functions
    libraries = [ctypes.CDLL(path) for path in map(find_library, ("c", "m")) if path]
    taken = {name for name in functions if any(hasattr(library, name) for library in libraries)}
    assert taken | (functions & ELSEWHERE) == set()
    names = _identifiers(code)
    assert "static double" not in re.sub(r"static (inline )?double \w+\(", "", code)  # re-entrant
    # These enter the rates wherever the scene has them.
    for term in ("follower", "external_damping", "tip_load"):
        for parameter in TERMS[term].parameters:
            assert (parameter.name in names) == (term in structure.terms), parameter
    # Gravity alone accelerates a free rod evenly, a single joint has no damper.
    assert ("gravity" in names) <= ("gravity" in structure.terms)
    assert ("internal_damping" in names) <= ("internal_damping" in structure.terms)
    assert ("base_ax" in names) == (structure.boundary == "free")
    assert ("clamp_angle" in names) <= (structure.boundary in ("cantilever", "clamped"))
    rates, _ = code.split("/* Newton matrices")
    assert ("lambda_x" in _identifiers(rates)) <= (structure.inertia == "uniform")
    assert ("tension" in names) == (structure.inertia == "lumped")
    assert ("malloc" in names) <= (structure.n_links > 20)
    assert f"{structure.module_stem('c')}_jac" in _identifiers(header)
    # Of laws that follow the motion, and states that they add.
    assert not re.search(r"sensor|state_\d|_by_|signals", python + code + header)
    assert "\nSTATES =" not in python


def test_text_grows_only_by_digits(written: Written) -> None:
    """And is no longer than what is asked for: `rhs` alone has less than half the lines of all."""
    parts = ("rhs", "batch", "jac")
    made = (written(Structure(n), "c", "chain", parts).values() for n in (100, 1000))
    small, large = map("".join, made)
    assert len(large) - len(small) < 2000
    assert len(large.encode()) < 250_000
    structure = Structure(50, terms=("follower",))
    for asked, most in ((("rhs",), 500), (None, 1100)):
        files = written(structure, "c", "chain", asked).items()
        (code,) = (text for name, text in files if name.endswith(".c"))
        assert len(code.splitlines()) <= most


def test_fast_math_is_refused(whole: Whole, tmp_path: Path) -> None:
    stem = write(whole(SMALL[3]), tmp_path)
    for flag in ("-ffast-math", "-ffinite-math-only", "-Ofast"):
        done = ran(COMPILERS[0], flag, "-fsyntax-only", f"{stem}.c", cwd=tmp_path)
        assert done.returncode != 0
        assert "-ffast-math" in done.stderr


@pytest.mark.skipif(not all(map(shutil.which, ("g++", "nm"))), reason="no g++ or nm on PATH")
def test_header_is_one_of_c_plus_plus_too(whole: Whole, tmp_path: Path) -> None:
    """Of which a program with the step loops is made; and all its symbols begin with the stem."""
    stem = write(whole(SMALL[3]), tmp_path)
    sources = [f"{stem}.c", *LOOPS]
    program = f'#include "{stem}.h"\n#include "{stem}.h"\n'
    program += f"int main() {{ return (int)({stem}_work() == 0) + {stem.upper()}_EULER; }}\n"
    (tmp_path / "main.cpp").write_text(program)
    assert ran(COMPILERS[0], "-c", *sources, cwd=tmp_path).returncode == 0
    objects = [Path(name).with_suffix(".o").name for name in sources]
    _compiles("g++", "main.cpp", *objects, "-lm", "-o", "main", cwd=tmp_path)
    assert ran("./main", cwd=tmp_path).returncode == 0
    listed = ran("nm", "--defined-only", "--extern-only", f"{stem}.o", cwd=tmp_path).stdout
    symbols = [line.split()[-1] for line in listed.splitlines()]
    assert f"{stem}_linearise" in symbols
    assert [symbol for symbol in symbols if not symbol.startswith(f"{stem}_")] == []


@pytest.mark.skipif(not shutil.which("g++"), reason="no g++ on PATH")
@EACH
def test_all_of_it_is_c_plus_plus_too(whole: Whole, tmp_path: Path, structure: Structure) -> None:
    stem = write(whole(structure), tmp_path)
    for source in (f"{stem}.c", *LOOPS):
        done = ran("g++", "-std=gnu++17", "-x", "c++", "-fsyntax-only", source, cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "")


PAIR = """
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


@pytest.mark.slow
def test_two_that_differ_in_an_expression_link_and_import_together(
    written: Written, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stems = [write(written(each, "c", "chain", ("rhs",)), tmp_path) for each in TWO]
    program = PAIR.replace("@0", stems[0]).replace("@1", stems[1])
    (tmp_path / "main.c").write_text(program)
    sources = ["main.c", *(f"{stem}.c" for stem in stems)]
    _compiles(COMPILERS[0], *sources, "-lm", "-o", "main", cwd=tmp_path)
    printed = [float(line) for line in ran("./main", cwd=tmp_path).stdout.split()]
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    modules = [importlib.import_module(write(written(each), tmp_path)) for each in TWO]
    p = modules[0].parameters(mass=3.0, length=2.0, bending_stiffness=30.0, follower_angle=0.1)
    rates = [module.rhs(0.5, [0.1, 0.4, 0.2, -0.3], p)[3] for module in modules]
    # Rounding of some ten operations.
    assert printed == pytest.approx(rates, rel=1e-13)
    assert rates[0] != rates[1]


@pytest.mark.slow
def test_compiler_that_fails_is_one_error(written: Written, tmp_path: Path) -> None:
    stem = write(written(SMALL[0], "c"), tmp_path)
    env = {**os.environ, "CC": "false", "PYTHONDONTWRITEBYTECODE": "1"}
    done = ran(sys.executable, "-c", f"import {stem}", cwd=tmp_path, env=env)
    assert done.returncode == 1
    assert "BuildError" in done.stderr
