"""The C target: against 50-digit arithmetic, against NumPy, and as plain C."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from rodgen.emit.check import LIMIT, check_module
from rodgen.scene.structure import BOUNDARIES, INERTIAS, TERMS, Structure

Built = Callable[..., ModuleType]
Written = Callable[..., dict[str, str]]
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]
pytestmark = pytest.mark.skipif(not COMPILERS, reason="no C compiler on PATH")

# Every boundary, inertia and term, with one link, two, and three of which one is inside.
SMALL = [
    Structure(1, "free", "uniform", TERMS),
    Structure(1, "clamped", "lumped", TERMS),
    Structure(1, "pinned", "uniform", ("gravity",)),
    Structure(2, "cantilever", "uniform", TERMS),
    Structure(2, "free", "lumped", ()),
    Structure(2, "pinned", "uniform", ("external_damping",)),
    Structure(3, "clamped", "uniform", TERMS),
    Structure(3, "cantilever", "lumped", TERMS),
    Structure(3, "pinned", "lumped", ("internal_damping",)),
    Structure(3, "free", "uniform", ("tip_load",)),
    Structure(5, "free", "lumped", ("follower", "gravity")),
]
# Joint forces are cut into segments from 9 and from 28 unknowns on: both sides of each, full and
# padded last segments, odd and even rows. Tensions are not cut.
LONG = [
    Structure(9, "free"),
    Structure(10, "free", terms=TERMS),
    Structure(10, "pinned"),
    Structure(20, "clamped", terms=TERMS),
    Structure(28, "free"),
    Structure(30, "cantilever", terms=TERMS),
    Structure(50, "free", terms=()),
    Structure(51, "pinned", terms=TERMS),
    Structure(50, "free", "lumped", TERMS),
]
TIMED = Structure(
    4,
    "clamped",
    terms=TERMS,
    expressions=(
        ("follower_force", "300*min(t/0.5, 1, 2 - t) + tan(t)**2"),
        ("tip_force_x", "-1.5*sin(t)**2 if t <= 0.7 else max(t, 0.5)**-1.5"),
        ("tip_force_y", "exp(-t)*log(2 + t)/sqrt(1 + t) + tanh(t)*abs(cos(5*t)) - pi"),
    ),
)


def _id(structure: Structure) -> str:
    return structure.stem.replace("_".join(TERMS), "all")


def test_every_choice_is_among_the_structures() -> None:
    assert {(s.boundary, s.inertia) for s in SMALL} == {
        (b, i) for b in BOUNDARIES for i in INERTIAS
    }
    assert {s.links for s in SMALL} >= {1, 2, 3}
    assert {s.boundary for s in LONG} == set(BOUNDARIES)


@pytest.mark.parametrize("structure", SMALL, ids=_id)
def test_module_equals_fifty_digit_arithmetic(built: Built, structure: Structure) -> None:
    # Rounding of some hundred operations, amplified by the condition of M (about 20 at n=5).
    assert max(d.error for d in check_module(built(structure, "c"), states=2)) < 1e-13


@pytest.mark.parametrize("structure", LONG, ids=_id)
def test_longer_modules_pass_the_check(built: Built, structure: Structure) -> None:
    # The condition of M grows as n^3, to 6e4 at n = 50.
    worst = max(d.error for d in check_module(built(structure, "c"), states=1))
    assert worst < min(LIMIT, 1e-13 * structure.links**1.5)


@pytest.mark.parametrize("structure", [*SMALL, LONG[1]], ids=_id)
def test_jacobian_is_that_of_the_closed_form(
    built: Built, point: type, structure: Structure
) -> None:
    at = point(built(structure, "c"))
    exact, got = at.exact_jacobian(), at.module.jac(at.t, at.y, at.p)
    largest = np.abs(exact).max(axis=1, keepdims=True)
    # Rows of zeros (nothing turns one free link) hold the rounding of terms that cancel.
    assert np.all(np.abs(got - exact) < 1e-9 * np.maximum(largest, 1e-5 * np.abs(exact).max()))


@pytest.mark.parametrize("structure", [SMALL[1], SMALL[6], LONG[3], LONG[7], LONG[8]], ids=_id)
def test_targets_agree(built: Built, point: type, structure: Structure) -> None:
    """Rates and Jacobians; all else is the same text in both modules."""
    at, numpy = point(built(structure, "c"), 7), built(structure)
    for function, digits in (("rhs", 1e-10), ("jac", 1e-9)):
        one = getattr(at.module, function)(at.t, at.y, at.p)
        two = getattr(numpy, function)(at.t, at.y, at.p)
        # Condition of M at n = 50 (6e4) times rounding.
        np.testing.assert_allclose(one, two, rtol=0, atol=digits * np.abs(two).max())


# Many states ------------------------------------------------------------------------------------


@pytest.mark.parametrize("shared", [True, False], ids=["one p", "a p for each"])
@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 21])
@pytest.mark.parametrize("structure", [SMALL[0], SMALL[3], SMALL[7], LONG[3], TIMED], ids=_id)
def test_batch_is_row_by_row(
    built: Built, point: type, structure: Structure, count: int, shared: bool
) -> None:
    rod = built(structure, "c")
    draw = np.random.default_rng(count)
    Y = draw.standard_normal((count, len(rod.STATE)))
    p = point(rod).p
    P = p if shared else p * draw.uniform(0.5, 2.0, (count, len(p)))
    rates = rod.rhs_batch(0.3, Y, P)
    one = [rod.rhs(0.3, y, p if shared else P[row]) for row, y in enumerate(Y)]
    expected = np.reshape(one, Y.shape)
    # One rod at a time is eliminated in another order: rounding times the condition of M.
    np.testing.assert_allclose(
        rates, expected, rtol=0, atol=1e-11 * np.abs(expected).max(initial=0)
    )
    out = np.full_like(Y, np.nan)
    assert rod.rhs_batch(0.3, Y, P, out) is out
    np.testing.assert_array_equal(out, rates)


def test_rod_of_a_batch_does_not_see_its_neighbours(built: Built, point: type) -> None:
    rod = built(LONG[3], "c")
    Y = np.random.default_rng(1).standard_normal((11, len(rod.STATE)))
    p = point(rod).p
    before = rod.rhs_batch(0.0, Y, p)
    Y[4] = np.nan
    after = rod.rhs_batch(0.0, Y, p)
    assert np.isnan(after[4]).any()
    others = np.arange(11) != 4
    np.testing.assert_array_equal(after[others], before[others])


def test_batches_that_are_none_are_refused(built: Built, point: type) -> None:
    rod = built(SMALL[6], "c")
    p, size = point(rod).p, len(rod.STATE)
    Y = np.zeros((3, size))
    for wrong in (np.zeros(size), np.zeros((3, size + 1)), np.zeros((2, 3, size))):
        with pytest.raises(ValueError, match="Y has shape"):
            rod.rhs_batch(0.0, wrong, p)
    for wrong in (p[:-1], np.tile(p, (2, 1)), np.tile(p, (3, 2))):
        with pytest.raises(ValueError, match="P has shape"):
            rod.rhs_batch(0.0, Y, wrong)
    with pytest.raises(ValueError, match="shares memory"):
        rod.rhs_batch(0.0, Y, p, Y)
    with pytest.raises(TypeError, match="Y has dtype complex"):
        rod.rhs_batch(0.0, Y.astype(complex), p)


# What comes in and where it goes ----------------------------------------------------------------


@pytest.fixture(scope="module")
def rod(built: Built) -> ModuleType:
    return built(LONG[3], "c")


def test_result_goes_into_out(rod: ModuleType, point: type) -> None:
    at = point(rod)
    expected = rod.rhs(0.0, at.y, at.p)
    out = np.full_like(at.y, np.nan)
    assert rod.rhs(0.0, at.y, at.p, out) is out
    np.testing.assert_array_equal(out, expected)


@pytest.mark.parametrize("shift", [0, 1, 7, -3])
def test_out_may_overlap_the_state(rod: ModuleType, point: type, shift: int) -> None:
    at = point(rod)
    expected, size = rod.rhs(0.0, at.y, at.p), len(at.y)
    memory = np.zeros(size + 20)
    memory[10 : 10 + size] = at.y
    y, out = memory[10 : 10 + size], memory[10 + shift : 10 + shift + size]
    rod.rhs(0.0, y, at.p, out)
    np.testing.assert_array_equal(out, expected)


BAD_OUT: dict[str, Callable[[int], object]] = {
    "short": lambda size: np.zeros(size - 1),
    "long": lambda size: np.zeros(size + 1),
    "two axes": lambda size: np.zeros((1, size)),
    "integers": lambda size: np.zeros(size, dtype=int),
    "floats": lambda size: np.zeros(size, dtype=np.float32),
    "big-endian": lambda size: np.zeros(size, dtype=">f8"),
    "every second": lambda size: np.zeros(2 * size)[::2],
    "backwards": lambda size: np.zeros(size)[::-1],
    "read-only": lambda size: np.frombuffer(bytes(8 * size)),
    "list": lambda size: [0.0] * size,
}


@pytest.mark.parametrize("bad", BAD_OUT)
def test_out_that_cannot_be_written_is_refused(rod: ModuleType, point: type, bad: str) -> None:
    at = point(rod)
    out = BAD_OUT[bad](len(at.y))
    with pytest.raises(ValueError, match="out"):
        rod.rhs(0.0, at.y, at.p, out)
    assert not np.any(np.asarray(out))


def test_threads_do_not_disturb_each_other(rod: ModuleType, point: type) -> None:
    """cffi lets go of the interpreter: two calls run at the same time."""
    at = point(rod)
    states = np.random.default_rng(5).standard_normal((2, len(at.y)))
    expected = [rod.rhs(0.0, y, at.p) for y in states]
    jacobians = [rod.jac(0.0, y, at.p) for y in states]

    def work(which: int) -> bool:
        y = states[which]
        same = all(np.array_equal(rod.rhs(0.0, y, at.p), expected[which]) for _ in range(5000))
        return same and all(
            np.array_equal(rod.jac(0.0, y, at.p), jacobians[which]) for _ in range(100)
        )

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, [0, 1, 0, 1]))


@pytest.mark.parametrize("angle", [1e16, -1e16, 1e300])
def test_angles_without_digits_after_the_point_give_no_numbers(
    rod: ModuleType, point: type, angle: float
) -> None:
    at = point(rod)
    at.y[2] = angle
    assert np.isnan(rod.rhs(0.0, at.y, at.p)).any()


# The text ---------------------------------------------------------------------------------------


def _write(written: Written, structure: Structure, folder: Path) -> str:
    for name, text in written(structure, "c").items():
        (folder / name).write_text(text, encoding="utf-8")
    return structure.module_stem("c")


def _compile(compiler: str, *arguments: str, cwd: Path) -> None:
    command = [compiler, "-std=c99", "-Wall", "-Wextra", "-pedantic", *arguments]
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("structure", [*SMALL, *LONG, TIMED], ids=_id)
def test_text_has_no_warnings(
    written: Written, tmp_path: Path, structure: Structure, compiler: str
) -> None:
    """Those that the reader of the text has; the program below has those of the optimiser."""
    stem = _write(written, structure, tmp_path)
    more = ("-Wvla", "-Wstrict-prototypes", "-Wmissing-prototypes")
    _compile(compiler, *more, "-fsyntax-only", f"{stem}.c", cwd=tmp_path)


PROGRAM = r"""
#include "@.h"
#include <stdio.h>
#include <stdlib.h>

#define STATES @@_STATES
#define RODS 11

static double p[@@_PARAMETERS], y[RODS * STATES], dy[RODS * STATES], J[STATES * STATES];

static void print(const char *name, const double *x, size_t count)
{
    printf("%s", name);
    for (size_t i = 0; i < count; ++i)
        printf(" %.17g", x[i]);
    printf("\n");
}

int main(void)
{
    void *work = malloc(@_work());
    for (size_t i = 0; i < sizeof p / sizeof *p; ++i)
        if (scanf("%lf", &p[i]) != 1)
            return 1;
    for (size_t i = 0; i < RODS * STATES; ++i)
        if (scanf("%lf", &y[i]) != 1)
            return 1;
    @_rhs(0.25, y, p, dy);
    print("rhs", dy, STATES);
    @_rhs_in(0.25, y, p, dy, work);
    print("rhs_in", dy, STATES);
    @_jac(0.25, y, p, J);
    print("jac", J, STATES * STATES);
    @_rhs_batch(RODS, 0.25, y, p, 0, dy);
    print("rhs_batch", dy, RODS * STATES);
    free(work);
    return 0;
}
"""


def _has_sanitizers(folder: Path) -> bool:
    (folder / "empty.c").write_text("int main(void) { return 0; }\n")
    command = [COMPILERS[0], "-fsanitize=address,undefined", "empty.c", "-o", "empty"]
    done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    return done.returncode == 0 and subprocess.run([folder / "empty"], check=False).returncode == 0


@pytest.mark.parametrize(
    "structure", [SMALL[0], SMALL[7], LONG[1], LONG[3], LONG[7], TIMED], ids=_id
)
def test_any_c_program_can_use_it(
    built: Built, written: Written, point: type, tmp_path: Path, structure: Structure
) -> None:
    """And no byte outside its arrays is touched, nor anything undefined done."""
    stem = _write(written, structure, tmp_path)
    program = PROGRAM.replace("@@", stem.upper()).replace("@", stem)
    (tmp_path / "main.c").write_text(program, encoding="utf-8")
    watch = ["-fsanitize=address,undefined", "-fno-sanitize-recover"]
    flags = watch if _has_sanitizers(tmp_path) else []
    _compile(COMPILERS[0], *flags, "-O1", "main.c", f"{stem}.c", "-o", "main", "-lm", cwd=tmp_path)
    at = point(built(structure, "c"))
    Y = np.random.default_rng(3).standard_normal((11, len(at.y)))
    numbers = " ".join(repr(float(x)) for x in (*at.p, *Y.ravel()))
    command = [str(tmp_path / "main")]
    done = subprocess.run(command, input=numbers, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    printed = {
        line.split()[0]: np.array(line.split()[1:], float) for line in done.stdout.splitlines()
    }
    expected = {
        "rhs": at.module.rhs(0.25, Y[0], at.p),
        "rhs_in": at.module.rhs(0.25, Y[0], at.p),
        "jac": at.module.jac(0.25, Y[0], at.p).ravel(),
        "rhs_batch": at.module.rhs_batch(0.25, Y, at.p).ravel(),
    }
    assert set(printed) == set(expected)
    for name, values in expected.items():
        # Other flags round otherwise; the condition of M at n = 51 is 6e4.
        limit = 1e-10 * np.abs(values).max()
        np.testing.assert_allclose(printed[name], values, rtol=0, atol=limit, err_msg=name)


def _identifiers(text: str) -> set[str]:
    """Names in C code, without those in comments."""
    return set(re.findall(r"[A-Za-z_]\w*", re.sub(r"/\*.*?\*/", "", text, flags=re.S)))


@pytest.mark.parametrize("structure", [*SMALL, *LONG, TIMED], ids=_id)
def test_text_holds_only_what_the_scene_has(written: Written, structure: Structure) -> None:
    _, code, header = written(structure, "c").values()
    names = _identifiers(code)
    assert "static double" not in re.sub(r"static (inline )?double \w+\(", "", code)  # re-entrant
    # These enter the rates wherever the scene has them.
    loads = {
        "follower_force": "follower",
        "follower_angle": "follower",
        "external_damping": "external_damping",
        "fin_factor": "external_damping",
        "tip_force_x": "tip_load",
        "tip_force_y": "tip_load",
    }
    for parameter, term in loads.items():
        assert (parameter in names) == (term in structure.terms), parameter
    # Gravity alone accelerates a free rod evenly, a single joint has no damper.
    assert ("gravity" in names) <= ("gravity" in structure.terms)
    assert ("internal_damping" in names) <= ("internal_damping" in structure.terms)
    assert ("base_ax" in names) == (structure.boundary == "free")
    assert ("clamp_angle" in names) <= (structure.boundary in ("cantilever", "clamped"))
    rates, _ = code.split("/* Newton matrices")
    assert ("lambda_x" in _identifiers(rates)) <= (structure.inertia == "uniform")
    assert ("tension" in names) == (structure.inertia == "lumped")
    assert ("malloc" in names) <= (structure.links > 20)
    assert f"{structure.module_stem('c')}_jac" in _identifiers(header)


def test_text_grows_only_by_digits(written: Written) -> None:
    small, large = ("".join(written(Structure(n), "c").values()) for n in (100, 1000))
    assert len(large) - len(small) < 2000
    assert len(large.encode()) < 250_000


def test_compiler_that_fails_is_one_error(written: Written, tmp_path: Path) -> None:
    stem = _write(written, SMALL[0], tmp_path)
    env = {**os.environ, "CC": "false", "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", f"import {stem}"]
    done = subprocess.run(
        command, cwd=tmp_path, env=env, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "BuildError" in done.stderr.splitlines()[-1] or "BuildError" in done.stderr
    assert "target numpy" in done.stderr
