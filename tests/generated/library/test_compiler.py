"""A compiler, whatever it does, ends in a library or in one error that says what is wrong."""

from __future__ import annotations

import ast
import math
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rodgen.native import library
from tests.generated.library.conftest import ANSWERS, REAL, SOURCE, Place, alive, until


def test_text_needs_python_and_cffi_only() -> None:
    tree = ast.parse(Path(library.__file__).read_text(encoding="utf-8"))
    found = {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    plain = [node for node in ast.walk(tree) if isinstance(node, ast.Import)]
    found |= {alias.name for node in plain for alias in node.names}
    assert {name.split(".")[0] for name in found} <= sys.stdlib_module_names


def test_default_flags_keep_nan_infinity_and_signed_zeros(place: Place) -> None:
    lib = place.load()
    assert [lib.is_nan(x) for x in (math.nan, math.inf, 0.0)] == [1, 0, 0]
    assert [lib.inverse(-0.0, y) for y in (0.0, -0.0)] == [math.inf, -math.inf]
    assert lib.inverse(math.inf, 1.0) == 0.0


def test_compiler_with_arguments(place: Place) -> None:
    """As `ccache gcc` is: a program that is told the compiler."""
    program = place.compiler('exec "$@"', answers="")
    place.patch.setenv("CC", f"'{program}' {REAL} -DWITH='\"a b\"'")
    place.write(SOURCE + "const char *with = WITH;\n")
    assert place.works()
    version, build = place.built()
    assert version.endswith("--version")
    assert build.startswith(f'{REAL} -DWITH="a b" -std=c99')


@pytest.mark.parametrize(
    ("refused", "used"),
    [
        ("-mprefer-vector-width=512", "-O3 -march=native"),
        ("-march=native", "-O2"),
        ("-O3", "-O2"),
    ],
)
def test_refused_flags_are_replaced(refused: str, used: str, place: Place) -> None:
    refuse = f'for a; do [ "$a" = {refused} ] && {{ echo unknown; exit 1; }}; done; '
    place.compiler(f'{refuse}exec {REAL} "$@"')
    place.patch.setattr(library, "features", lambda: "flags: sse2 avx512f")
    assert place.works(2)
    *before, last = place.built()
    assert before
    assert all(refused in line for line in before)
    assert used in last
    assert refused not in last


def test_given_flags_take_the_place_of_the_default(place: Place) -> None:
    place.compiler()
    place.patch.setenv("RODGEN_CFLAGS", "-O1 -DNAME='\"a b\"'")
    place.write(SOURCE + "const char *name = NAME;\n")
    assert place.works()
    (line,) = place.built()
    assert "-O1" in line
    assert not any(flag in line for flag in library.FLAGS)


def test_no_compiler_any_more(place: Place) -> None:
    assert place.works()
    place.patch.setenv("PATH", str(place.temporary))
    assert place.works()
    place.write(SOURCE + "\n")
    assert "cc, gcc, clang" in place.fails()


def test_first_compiler_on_path_is_used(place: Place) -> None:
    # The script calls the real compiler, which looks for its assembler.
    program = place.compiler(f'PATH={os.defpath} exec {REAL} "$@"')
    place.patch.delenv("CC")
    programs = place.temporary / "bin"
    programs.mkdir()
    (programs / "clang").symlink_to(program)
    place.patch.setenv("PATH", str(programs))
    assert place.works()
    assert len(place.built()) == 1


def test_compiler_without_a_version(place: Place) -> None:
    """As tcc is."""
    place.compiler(answers='[ "$1" = --version ] && { echo no input files; exit 1; }\n')
    assert place.works(2)
    assert len(place.built()) == 1


FAILING = {
    "an error": ("echo 'rod.c:3: so wrong' >&2; exit 1", "so wrong"),
    "a crash": ("kill -SEGV $$", "exit status -11"),
    "no file": ("exit 0", "it wrote no file"),
    "an empty file": (": > rod.so", "too short|cannot be built and loaded"),
    "garbage": ("echo garbage > rod.so", "cannot be built and loaded"),
    "half a file": (
        f'{REAL} "$@"; head -c 60 rod.so > half; mv half rod.so',
        "cannot be built and loaded",
    ),
    "a folder": ("mkdir -p rod.so", "it wrote no file"),
}


@pytest.mark.parametrize("what", FAILING)
def test_failing_compiler(what: str, place: Place) -> None:
    script, expected = FAILING[what]
    place.compiler(script)
    message = place.fails()
    assert any(part in message for part in expected.split("|"))
    assert place.left() == []


def test_last_lines_of_the_compiler_are_shown(place: Place) -> None:
    place.compiler("seq 100; exit 1")
    lines = place.fails().splitlines()
    assert [line.strip() for line in lines[1:-1]] == [str(i) for i in range(89, 101)]


NO_CFFI = "Version mismatch: this is the 'cffi' package version 0"


class Broken:
    """cffi whose parts are of two versions."""

    def __init__(self) -> None:
        raise Exception(NO_CFFI)


Spoil = Callable[[Place], Any]
# What is wrong, and what the error says.
WRONG: dict[str, tuple[Spoil, str]] = {
    "source": (lambda b: b.write("no C at all\n"), "error"),
    "function that is nowhere": (
        lambda b: b.write(SOURCE + "void no_such(void); void f(void) { no_such(); }\n"),
        "no_such",
    ),
    "no source": (lambda b: (b.folder / "rod.c").unlink(), "/rod.c: No such file"),
    "no header": (lambda b: (b.folder / "rod.h").unlink(), "/rod.h: No such file"),
    "flags": (lambda b: b.patch.setenv("RODGEN_CFLAGS", "--no-such-flag"), "--no-such-flag"),
    "words in CC": (lambda b: b.patch.setenv("CC", "cc 'open"), "CC=cc 'open"),
    "words in flags": (
        lambda b: b.patch.setenv("RODGEN_CFLAGS", "cc 'open"),
        "RODGEN_CFLAGS=cc 'open",
    ),
    **{
        f"CC={command}": (
            lambda b, command=command: (b.load(), b.patch.setenv("CC", command)),  # type: ignore[misc]
            f"CC={command}: no such program",
        )
        for command in ("no-such-compiler -m64", "/no/such/cc", "''")
    },
    "MSVC": (
        lambda b: b.patch.setenv("CC", str(b.compiler().rename(b.temporary / "cl"))),
        "MSVC does not compile",
    ),
    "no compiler": (lambda b: b.patch.setenv("PATH", str(b.temporary)), "cc, gcc, clang"),
    "crash": (lambda b: b.compiler(answers="kill -SEGV $$\n"), "exit status -11"),
    "no shell": (lambda b: b.compiler().write_text("#!/no/such/shell\n"), "fakecc --version: "),
    "no program": (lambda b: b.compiler().write_text("\0\0not one"), "fakecc --version: "),
    "no cffi": (lambda b: b.patch.setitem(sys.modules, "cffi", None), "pip install cffi"),
    "cffi": (lambda b: b.patch.setattr("cffi.FFI", Broken), NO_CFFI),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_wrong_is_said(what: str, place: Place) -> None:
    spoil, said = WRONG[what]
    spoil(place)
    message = place.fails()
    assert said in message
    assert ("generate both again" in message) == ("No such file" in said)


def test_declarations_that_are_none(place: Place) -> None:
    assert "cffi refuses the declarations" in place.fails("double twice(")


@pytest.mark.nightly
@pytest.mark.parametrize("limit", ["_BUILD_LIMIT", "_VERSION_LIMIT"])
def test_compiler_that_hangs_is_killed_with_its_children(limit: str, place: Place) -> None:
    pid = place.log.with_name("child")
    hang = f'sleep 1000 & echo $! > "{pid}"; wait\n'
    place.compiler(hang, answers=hang if limit == "_VERSION_LIMIT" else ANSWERS)
    place.patch.setattr(library, limit, 2.0)
    assert "killed after 2 s" in place.fails()
    until(lambda: not alive(int(pid.read_text())))
    assert place.left() == []
