"""C that is compiled for a comparison, and timed in a loop in C."""

from __future__ import annotations

import shlex
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.native.library import load_library
from rodgen_evidence.report.costs.cold import environment, scratch
from rodgen_evidence.report.interleaved_timing import Batch

# Those of rodgen's that help unrolled code: -O3 and wider vectors measure the same there.
FLAGS = ("-O2", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")
SCRATCH = scratch()  # removed when the process ends
ARGUMENTS = "double t, const double *y, const double *p, double *dy"
LOOP = """
#define _POSIX_C_SOURCE 199309L
#include <time.h>

void {name}({arguments});

double loop(const double *y, const double *p, double *dy, long count)
{{
    struct timespec start, end;
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (long i = 0; i < count; i++)
        {name}(0.0, y, p, dy);
    clock_gettime(CLOCK_MONOTONIC, &end);
    return (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
}}
"""


@dataclass(frozen=True)
class Native:
    """A C function void (double t, const double *y, const double *p, double *dy)."""

    name: str
    ffi: Any  # of cffi
    library: Any

    def __call__(self, t: float, y: Array, p: Array) -> Array:
        dy = np.empty_like(y)
        getattr(self.library, self.name)(t, *self._pointers(y, p, dy))
        return dy

    def batch(self, y: Array, p: Array) -> Batch:
        """Batches of calls from C."""
        dy = np.empty_like(y)
        return lambda number: float(self.library.loop(*self._pointers(y, p, dy), number))

    def _pointers(self, *arrays: Array) -> list[Any]:
        return [self.ffi.from_buffer("double[]", array) for array in arrays]


def compile_function(texts: Mapping[str, str], name: str, flags: Sequence[str] = FLAGS) -> Native:
    """Compile a function of C files with these flags in an empty cache, and load it.

    Raises BuildError.
    """
    folder = Path(tempfile.mkdtemp(dir=SCRATCH.name))
    files = {**texts, "loop.c": LOOP.format(name=name, arguments=ARGUMENTS)}
    for file, text in files.items():
        (folder / file).write_text(text, encoding="utf-8")
    declared = f"void {name}({ARGUMENTS}); double loop({ARGUMENTS[10:]}, long count);"
    with environment(RODGEN_CACHE=str(folder / "cache"), RODGEN_CFLAGS=shlex.join(flags)):
        return Native(name, *load_library(name, folder, declared, list(files)))
