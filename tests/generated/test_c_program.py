"""A C program that calls all of a generated header: nothing that it does is undefined or beside its
memory, by the judgement of AddressSanitizer, UBSan and valgrind."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest

from rodgen.model.methods import COMPILED
from rodgen.scene.structure import Structure
from tests.generated.conftest import Whole, ran, write
from tests.palette import LONG, SMALL, short

COMPILER = next(filter(None, map(shutil.which, ("gcc", "clang", "cc"))), "")
pytestmark = pytest.mark.compiler
WATCH = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer")
SILENT = {"ASAN_OPTIONS": "detect_leaks=0", "UBSAN_OPTIONS": "print_stacktrace=1"}
ROOT = Path(__file__).parents[2]
SHORT, *REST = SMALL[3], SMALL[6], LONG[1], Structure(50, "free", terms=())
PROGRAM = r"""
#include "@.h"
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Memory of just so many doubles, so that one more is seen. */
static double *doubles(size_t count)
{
    double *const x = calloc(count ? count : 1, sizeof *x);
    if (x == NULL)
        exit(1);
    return x;
}

static int bad(const double *x, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(x[i]))
            return 1;
    return 0;
}

static int run(long long method, const double *y, const double *p, double *dy)
{
    enum { SAMPLES = 5, QUOTA = 20 };
    @_run *const r = calloc(1, @_run_size());
    double *const times = doubles(SAMPLES);
    double *const samples = doubles(SAMPLES * (@@_STATES + @@_WORKS));
    double *const trace = doubles(QUOTA * (1 + 2 * @@_STATES));
    size_t sampled = 0;
    const int fixed = method < @@_DOP853 || method > @@_RADAU;
    int status, failed = 0;
    memcpy(@_run_state(r), y, @@_STATES * sizeof *y);
    for (int i = 0; i < SAMPLES; ++i)
        times[i] = 2e-5 * i;
    r->method = method;
    r->low = -INFINITY;
    r->high = INFINITY;
    r->rtol = r->atol = 1e-6;
    failed |= @_run_on(r, p, 1, 0, NULL, NULL, &sampled, NULL) != @@_REFUSED;
    r->end = -1.0;
    failed |= @_run_start(r, p) != @@_REFUSED;
    r->end = 1e-4;
    if (fixed)
        failed |= @_run_start(r, p) != @@_REFUSED;
    r->step = fixed ? 1e-5 : 0.0;
    failed |= @_run_start(r, p) != @@_PAUSED;
    failed |= @_run_on(r, p, LLONG_MIN, 0, times, samples, &sampled, trace) != @@_PAUSED;
    do
        status = @_run_on(r, p, QUOTA, SAMPLES, times, samples, &sampled, trace);
    while (status == @@_PAUSED);
    failed |= status != @@_FULL && status != @@_REACHED;
    failed |= bad(samples, sampled * (@@_STATES + @@_WORKS));
    failed |= bad(@_run_rates(r), @@_STATES + @@_WORKS);
    @_run_at(r, p, 0.5 * (r->before + r->t), samples);
    memcpy(dy, samples, @@_STATES * sizeof *dy);
    r->method = @@_GAUSS_EQUAL_STEPS + 1;
    failed |= @_run_on(r, p, QUOTA, 0, times, samples, &sampled, trace) != @@_REFUSED;
    free(trace);
    free(samples);
    free(times);
    free(r);
    return failed || bad(dy, @@_STATES);
}

int main(void)
{
    enum { RODS = 11 };
    double *const p = doubles(@@_PARAMETERS), *const P = doubles(RODS * @@_PARAMETERS);
    double *const y = doubles(RODS * @@_STATES), *const dy = doubles(RODS * @@_STATES);
    double *const J = doubles(@@_STATES * @@_STATES);
    void *const work = malloc(@_work());
    int failed = 0;
    for (int i = 0; i < @@_PARAMETERS; ++i)
        p[i] = 0.5 + 0.1 * (i % 12);  /* stiff, but not too stiff for explicit steps */
    p[@@_P_LENGTH] = 5.0;
    for (int i = 0; i < RODS * @@_PARAMETERS; ++i)
        P[i] = p[i % @@_PARAMETERS];
    for (int i = 0; i < RODS * @@_STATES; ++i)
        y[i] = 0.3 * sin(i + 1.0);
    @_rhs(0.25, y, p, dy);
    failed |= bad(dy, @@_STATES);
    @_rhs_in(0.25, y, p, dy, work);
    @_jac(0.25, y, p, J);
    failed |= bad(J, @@_STATES * @@_STATES);
    double *const all = doubles(@@_STATES + @@_WORKS);
    void *const rates = malloc(@_flow_work()), *const newton = malloc(@_newton_work());
    const double shift[2] = {3.0, 20.0};
    @_flow(0.25, y, p, all, rates);
    failed |= bad(all, @@_STATES + @@_WORKS);
    @_linearise(0.25, y, p, newton);
    @_factor(7.5, shift, newton);
    @_solve_real(dy, newton);
    @_solve_complex(dy, newton);
    failed |= bad(dy, 2 * @@_STATES);
    free(newton);
    free(rates);
    free(all);
    for (size_t rods = 0; rods <= RODS; ++rods) {
        @_rhs_batch(rods, 0.25, y, p, 0, dy);
        @_rhs_batch(rods, 0.25, y, P, @@_PARAMETERS, dy);
        failed |= bad(dy, rods * @@_STATES);
    }
    for (long long method = @@_EULER; method <= @@_GAUSS_EQUAL_STEPS; ++method)
        failed |= run(method, y, p, dy) << (method + 1);
    p[@@_P_MASS] = 0.0;
    y[0] = NAN;
    y[@@_STATES - 1] = 1e300;
    @_rhs(0.25, y, p, dy);
    @_rhs_batch(RODS, 0.25, y, p, 0, dy);
    @_jac(0.25, y, p, J);
    free(work);
    free(J);
    free(dy);
    free(y);
    free(P);
    free(p);
    return failed != 0;
}
"""


def _made(files: dict[str, str], folder: Path, *flags: str) -> Path:
    """The program over the module of a structure; skips where it cannot be linked."""
    stem = write(files, folder)
    (folder / "main.c").write_text(PROGRAM.replace("@@", stem.upper()).replace("@", stem))
    (folder / "empty.c").write_text("int main(void) { return 0; }\n")
    command = [COMPILER, "-std=c99", "-g", "-O0", *flags]
    if ran(*command, "empty.c", "-o", "empty", cwd=folder).returncode:
        pytest.skip(f"{COMPILER} does not link {' '.join(flags)}")
    sources = ["main.c", *(name for name in files if name.endswith(".c")), "-lm", "-o", "main"]
    done = ran(*command, *sources, cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "main"


def _run(*command: str | Path) -> None:
    """All numbers are finite where they are to be, and nobody who watches says anything."""
    done = ran(*command, env={**os.environ, **SILENT})
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_program_calls_every_function_and_method(whole: Whole) -> None:
    header = next(text for name, text in whole(SHORT).items() if name.endswith(".h"))
    functions = {line.split("(")[0].split("_c_")[-1] for line in header.splitlines() if "(" in line}
    declared = {name for name in functions if name.isidentifier()}
    assert declared >= {"rhs", "rhs_in", "rhs_batch", "jac", "run_start", "run_on", "run_at"}
    assert [name for name in declared if f"@_{name}(" not in PROGRAM] == []
    assert (COMPILED[0], COMPILED[-1]) == ("euler", "gauss_equal_steps")


@pytest.mark.nightly
@pytest.mark.parametrize("structure", [SHORT, *REST], ids=short)
def test_sanitizers_are_silent(whole: Whole, tmp_path: Path, structure: Structure) -> None:
    _run(_made(whole(structure), tmp_path, *WATCH))


@pytest.mark.nightly
@pytest.mark.skipif(not shutil.which("valgrind"), reason="no valgrind on PATH")
def test_valgrind_is_silent(whole: Whole, tmp_path: Path) -> None:
    program = _made(whole(LONG[1]), tmp_path)
    _run("valgrind", "-q", "--error-exitcode=9", "--leak-check=full", program)


@pytest.mark.nightly
def test_module_in_python_is_silent_under_sanitizers(tmp_path: Path) -> None:
    """The tests of arrays and runs, with libraries that watch."""
    asked = (f"-print-file-name={name}" for name in ("libasan.so", "libubsan.so"))
    shared = [ran(COMPILER, one).stdout.strip() for one in asked]
    if not all(Path(path).is_absolute() and Path(path).is_file() for path in shared):
        pytest.skip(f"{COMPILER} has no shared sanitizers")
    env = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
    env |= {
        **SILENT,
        "CC": COMPILER,
        "RODGEN_CFLAGS": " ".join(("-O0", "-g", *WATCH)),
        "LD_PRELOAD": ":".join(shared),
    }
    tests = ROOT / "tests" / "generated" / "test_c_memory.py"
    what = "out_that or after_a_call or too_small or runs_that or goes_into"
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tests)]
    done = ran(*command, "-k", what, "--basetemp", tmp_path / "watched", cwd=ROOT, env=env)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    assert "Sanitizer" not in done.stdout + done.stderr
    assert "runtime error" not in done.stdout + done.stderr
