"""C that is compiled for a comparison, and timed in a loop in C."""

from __future__ import annotations

import ctypes
import os
import shlex
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from rodgen.judge.precision.contestant import Array
from rodgen.judge.timing import Batch
from rodgen.loading import BuildError

SHARED = ("-std=c99", "-fPIC", "-shared")  # as the C target is built
# Those of rodgen's that help unrolled code: -O3 and wider vectors measure the same there.
FLAGS = ("-O2", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")
LOOP = """
#define _POSIX_C_SOURCE 199309L
#include <time.h>

typedef void rhs_function(double t, const double *y, const double *p, double *dy);

double loop(rhs_function *rhs, const double *y, const double *p, double *dy, long count)
{
    struct timespec start, end;
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (long i = 0; i < count; i++)
        rhs(0.0, y, p, dy);
    clock_gettime(CLOCK_MONOTONIC, &end);
    return (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
}
"""
_DOUBLES = ctypes.POINTER(ctypes.c_double)


@dataclass(frozen=True)
class Native:
    """A C function void (double t, const double *y, const double *p, double *dy)."""

    function: Any  # of ctypes
    library: ctypes.CDLL  # kept loaded

    def __call__(self, t: float, y: Array, p: Array) -> Array:
        dy = np.empty_like(y)
        self.function(ctypes.c_double(t), _pointer(y), _pointer(p), _pointer(dy))
        return dy

    def batch(self, y: Array, p: Array) -> Batch:
        """Batches of calls from C."""
        loop, dy = _loop(), np.empty_like(y)

        def seconds(number: int) -> float:
            arguments = (_pointer(y), _pointer(p), _pointer(dy))
            return float(loop(self.function, *arguments, ctypes.c_long(number)))

        return seconds


def compiled(texts: Mapping[str, str], name: str, flags: Sequence[str] = FLAGS) -> Native:
    """A function of C files, of which the first is compiled with these flags, and loaded.

    Raises BuildError.
    """
    folder = Path(tempfile.mkdtemp(dir=_scratch().name))
    for file, text in texts.items():
        (folder / file).write_text(text)
    compiler = shlex.split(os.environ.get("CC", "cc"))
    command = [*compiler, *SHARED, *flags, next(iter(texts)), "-o", "library.so", "-lm"]
    try:
        made = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    except OSError as error:
        raise BuildError(f"{shlex.join(command)}: {error.strerror}") from error
    if made.returncode:
        raise BuildError(f"{shlex.join(command)} failed:\n{made.stderr}")
    library = ctypes.CDLL(str(folder / "library.so"))
    function = library[name]
    function.restype = None
    return Native(function, library)


@lru_cache(maxsize=1)
def _loop() -> Any:
    loop = compiled({"loop.c": LOOP}, "loop", ("-O2",)).function
    loop.restype = ctypes.c_double
    return loop


@lru_cache(maxsize=1)
def _scratch() -> tempfile.TemporaryDirectory[str]:
    """Removed when the process ends."""
    return tempfile.TemporaryDirectory(prefix="rodgen-judge-")


def _pointer(values: Array) -> ctypes._Pointer[ctypes.c_double]:
    return values.ctypes.data_as(_DOUBLES)
