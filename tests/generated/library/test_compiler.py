"""A compiler, whatever it does, ends in a library or in one error that says what is wrong."""

from __future__ import annotations

import math
import os
import re
import sys
from collections.abc import Callable
from typing import Any

import pytest

from rodgen.native import library
from tests.generated.library.conftest import ANSWERS, REAL, SOURCE, Place, alive, until


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
    [("-mprefer-vector-width=512", "-O3 -march=native"), ("-march=native", "-O2"), ("-O3", "-O2")],
)
def test_refused_flags_are_replaced(refused: str, used: str, place: Place) -> None:
    refuse = f'for a; do [ "$a" = {refused} ] && {{ echo unknown; exit 1; }}; done; '
    place.compiler(f'{refuse}exec {REAL} "$@"')
    place.patch.setattr(library, "processor_features", lambda: "flags: sse2 avx512f")
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


# What the compiler does, and what of it the error names.
FAILING = {
    "echo 'rod.c:3: so wrong' >&2; exit 1": "so wrong",
    "kill -SEGV $$": "-11",
    "exit 0": "fakecc",  # and writes no file
    ": > rod.so": "rod.c",
    "echo garbage > rod.so": "rod.c",
    f'{REAL} "$@"; head -c 60 rod.so > half; mv half rod.so': "rod.c",
    "mkdir -p rod.so": "fakecc",
}


@pytest.mark.parametrize("script", FAILING, ids=lambda script: script[:12])
def test_failing_compiler(script: str, place: Place) -> None:
    place.compiler(script)
    assert FAILING[script] in place.fails()
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
# What is wrong, and what of it the error names.
WRONG: dict[str, tuple[Spoil, str]] = {
    "source": (lambda b: b.write("no C at all\n"), "rod.c:1"),
    "function that is nowhere": (
        lambda b: b.write(SOURCE + "void no_such(void); void f(void) { no_such(); }\n"),
        "no_such",
    ),
    "no source": (lambda b: (b.folder / "rod.c").unlink(), "/rod.c"),
    "no header": (lambda b: (b.folder / "rod.h").unlink(), "/rod.h"),
    "flags": (lambda b: b.patch.setenv("RODGEN_CFLAGS", "--no-such-flag"), "--no-such-flag"),
    "words in CC": (lambda b: b.patch.setenv("CC", "cc 'open"), "CC=cc 'open"),
    "words in flags": (
        lambda b: b.patch.setenv("RODGEN_CFLAGS", "cc 'open"),
        "RODGEN_CFLAGS=cc 'open",
    ),
    **{
        f"CC={command}": (
            lambda b, command=command: (b.load(), b.patch.setenv("CC", command)),
            f"CC={command}",
        )
        for command in ("no-such-compiler -m64", "/no/such/cc", "''")
    },
    "MSVC": (lambda b: b.patch.setenv("CC", str(b.compiler().rename(b.temporary / "cl"))), "CC=cl"),
    "no compiler": (lambda b: b.patch.setenv("PATH", str(b.temporary)), "cc, gcc, clang"),
    "crash": (lambda b: b.compiler(answers="kill -SEGV $$\n"), "-11"),
    "no shell": (lambda b: b.compiler().write_text("#!/no/such/shell\n"), "fakecc --version"),
    "no program": (lambda b: b.compiler().write_text("\0\0not one"), "fakecc --version"),
    "no cffi": (lambda b: b.patch.setitem(sys.modules, "cffi", None), "cffi"),
    "cffi": (lambda b: b.patch.setattr("cffi.FFI", Broken), NO_CFFI),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_wrong_is_named(what: str, place: Place) -> None:
    spoil, named = WRONG[what]
    spoil(place)
    assert named in place.fails()


def test_declarations_that_are_none(place: Place) -> None:
    assert "cffi" in place.fails("double twice(")


@pytest.mark.nightly
@pytest.mark.parametrize("limit", ["_BUILD_LIMIT", "_VERSION_LIMIT"])
def test_compiler_that_hangs_is_killed_with_its_children(limit: str, place: Place) -> None:
    pid = place.log.with_name("child")
    hang = f'sleep 1000 & echo $! > "{pid}"; wait\n'
    place.compiler(hang, answers=hang if limit == "_VERSION_LIMIT" else ANSWERS)
    place.patch.setattr(library, limit, 2.0)
    assert re.search(r"\b2 s\b", place.fails())
    until(lambda: not alive(int(pid.read_text())))
    assert place.left() == []
