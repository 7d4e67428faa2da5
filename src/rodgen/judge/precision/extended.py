"""A generated module with extrapolation methods, in long double where that is asked for."""

from __future__ import annotations

import ctypes
import re
import shlex
import subprocess
import tempfile
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from rodgen.judge.precision.contestant import Array, TooSlowError
from rodgen.loading import BuildError, sources
from rodgen.scene import Scene, Structure
from rodgen.templates import c_build

BITS_OF_DOUBLE = 53
# Long double is not computed in vectors; that nothing is aliased matters little there.
FLAGS = {True: ("-O2", "-fno-math-errno"), False: ()}
HEADERS = ("complex", "float", "math", "stdint", "stdlib", "string", "time")
# The sine of doubles in a generated file: everything from its comment to the end of `cosine`.
SINE = re.compile(
    r"/\* Sine and cosine without branches.*?^static inline double cosine\(double v\)\n\{.*?^\}\n",
    re.DOTALL | re.MULTILINE,
)
EXTENDED_SINE = """\
static inline double sine(double v)
{
    return sinl(v);
}

static inline double cosine(double v)
{
    return cosl(v);
}
"""
NUMBER = re.compile(r"(?<![\w.])(?:\d+\.\d*(?:[eE][-+]?\d+)?|\d+[eE][-+]?\d+)(?![\w.])")
COUNTS = ("steps", "rejected", "rhs", "jacobian", "factorisations")
TOO_SLOW = -4
STATUS = {
    -1: "steps become too small",
    -2: "too many steps",
    -3: "no memory",
    TOO_SLOW: "time is up",
    -5: "the rates are not finite",
}

_DOUBLES = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
_COUNTS = np.ctypeslib.ndpointer(np.int64, flags="C_CONTIGUOUS")


def extended(text: str) -> str:
    """The text of a generated C file, with the sine and the constants of long double.

    `double` itself becomes `long double` by a macro. Raises ValueError where the text is not as it
    is known, rather than leave double precision in it.
    """
    text, found = SINE.subn(EXTENDED_SINE, text)
    if found != 1:
        raise ValueError(f"the sine of doubles was found {found} times in the generated file")
    if re.search(r"0x[0-9a-f.]+p|\bquarter\b|\bsigned_by\b|\bfloat\b", text):
        raise ValueError("the generated file works on the bits of doubles beyond its sine")
    return NUMBER.sub(lambda number: number[0] + "L", text)


def driver(scene: Scene | Structure, long: bool) -> dict[str, str]:
    """Files of the library by name, the one that is compiled first."""
    texts = sources(scene, "c")
    source = next(name for name in texts if name.endswith(".c"))
    header = next(name for name in texts if name.endswith(".h"))
    match = re.search(r"_PARAMETERS (\d+)\n", texts[header])
    if match is None:
        raise ValueError("the header does not say how many parameters there are")
    lines = [f"#include <{name}.h>" for name in HEADERS]
    if long:
        lines += ["#include <tgmath.h>", "#define double long double"]
    lines += [f'#include "{source}"', "#undef double"]
    lines += [f"typedef {'long ' if long else ''}double real;"]
    lines += [f"enum {{ PARAMETER_COUNT = {match[1]} }};", '#include "extrapolation.c"', ""]
    method = files("rodgen.judge.precision").joinpath("extrapolation.c")
    return {
        "main.c": "\n".join(lines),
        source: extended(texts[source]) if long else texts[source],
        header: texts[header],
        "extrapolation.c": method.read_text(encoding="utf-8"),
    }


@dataclass(frozen=True)
class Library:
    """The compiled methods. bits: of the significand that the equations are computed in."""

    library: ctypes.CDLL
    bits: int

    def rates(self, t: float, y: Array, p: Array) -> tuple[Array, Array]:
        """dy/dt (states,) as the sum of two doubles."""
        dy, rest = np.empty_like(y), np.empty_like(y)
        self.library.rates_in_two(t, y, p, dy, rest)
        return dy, rest

    def extrapolate(
        self,
        implicit: bool,
        columns: int,
        tolerance: float,
        first: float,
        p: Array,
        weights: Array,
        start: Array,
        times: Array,
        inside: tuple[Array, Array],
        quota: int = 10**9,
        seconds: float = np.inf,
    ) -> tuple[Array, dict[str, int]]:
        """States (times, states) and counts; times[0] is the start.

        inside: between which times loads are asked for on the way to each time; tolerance: of the
        error of a step, times the weights (states,); first: the step to begin with [s]; quota,
        seconds: of steps, and of processor time. Raises ArithmeticError where it gives up,
        TooSlowError where the seconds are over.
        """
        states = np.zeros((len(times), len(start)))
        states[0] = start
        counts = np.zeros(len(COUNTS), dtype=np.int64)
        stops = [np.ascontiguousarray(a, dtype=float) for a in (times, *inside)]
        how = (implicit, columns, tolerance, first)
        reached = np.array([times[0]], dtype=float)
        out = (states, counts, quota, seconds, reached)
        status = self.library.extrapolate(*how, p, weights, len(times), *stops, *out)
        if status:
            kind = TooSlowError if status == TOO_SLOW else ArithmeticError
            where = f"at t = {reached[0]:.4g} s of {times[-1]:.4g} s"
            raise kind(f"extrapolation: {STATUS[status]} {where}")
        return states, dict(zip(COUNTS, map(int, counts), strict=True))


@lru_cache(maxsize=4)
def library(structure: Structure, long: bool) -> Library:
    """Compiled and loaded. Raises BuildError where it cannot be."""
    flags = FLAGS[long] or c_build._flag_sets(c_build._processor())[0]
    with tempfile.TemporaryDirectory(prefix="rodgen-reference-") as folder:
        for name, text in driver(structure, long).items():
            Path(folder, name).write_text(text, encoding="utf-8", newline="\n")
        command = [*c_build._compiler(), "-std=c99", "-fPIC", "-shared", *flags, "main.c"]
        made = subprocess.run(
            [*command, "-o", "library.so", "-lm"],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )
        if made.returncode:
            raise BuildError(f"{shlex.join(command)} failed:\n{made.stderr[:2000]}")
        loaded = ctypes.CDLL(str(Path(folder, "library.so")))
    _declare(loaded)
    return Library(loaded, int(loaded.digits_of_real()))


def _declare(loaded: Any) -> None:
    number, count = ctypes.c_double, ctypes.c_longlong
    loaded.rates_in_two.argtypes = [number, *[_DOUBLES] * 4]
    loaded.rates_in_two.restype = None
    loaded.digits_of_real.restype = ctypes.c_int
    loaded.extrapolate.argtypes = [
        *(ctypes.c_int, ctypes.c_int, number, number, _DOUBLES, _DOUBLES, ctypes.c_size_t),
        *(_DOUBLES, _DOUBLES, _DOUBLES, _DOUBLES, _COUNTS, count, number, _DOUBLES),
    ]
    loaded.extrapolate.restype = ctypes.c_int
