"""Runs of a C module in compiled steps: the class Run of a module extends the one here."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .library import library_environment, load_library

Array = NDArray[np.float64]


def header_text(header: str) -> str:
    """Text of a header of the step loops."""
    return Path(__file__).with_name(header).read_text(encoding="utf-8")


def header_numbers(header: str) -> dict[str, int]:
    """Numbers that a header defines, by name."""
    found = re.findall(r"RODGEN_(\w+) = (-?\d+)", header_text(header))
    return {name: int(value) for name, value in found}


# Methods by their number in a run, and what the functions of a run end with.
METHODS = tuple(name.lower() for name in header_numbers("methods.h") if name != "METHODS")
IMPLICIT = METHODS[METHODS.index("dop853") + 1 :]
STATUSES = header_numbers("steps.h")
REFUSED = STATUSES["REFUSED"]
HEADERS = ("collocation.h", "control.h", "run.h", "steps.h", "methods.h", "tableaux.h")
FILES = (
    "steps.c",
    "explicit.c",
    "collocation.c",
    "collocation_dense.c",
    "collocation_tangents.c",
    *HEADERS,
)


def step_library() -> tuple[Any, Any]:
    """cffi's FFI object and the library of the step loops, built once a machine.

    Raises BuildError where there is none to be had.
    """
    return loop_library("steps", FILES, "methods.h", "steps.h")


def loop_library(stem: str, files: tuple[str, ...], *headers: str) -> tuple[Any, Any]:
    """cffi's FFI object and the library of loops in C, whose headers declare what cffi is told of.
    Raises BuildError."""
    return _loop_library(stem, files, headers, library_environment())


@lru_cache(maxsize=8)
def _loop_library(
    stem: str, files: tuple[str, ...], headers: tuple[str, ...], _: tuple[str | None, ...]
) -> tuple[Any, Any]:
    declared = "".join(map(_cffi_declarations, headers))
    return load_library(stem, Path(__file__).parent, declared, files)


def _cffi_declarations(header: str) -> str:
    """Declarations in a header, without lines of the preprocessor and for C++."""
    text = re.sub(r"^#ifdef __cplusplus$.*?^#endif$", "", header_text(header), flags=re.M | re.S)
    return re.sub(r"^#.*$", "", text, flags=re.M)


def aligned_bytes(size: int) -> NDArray[np.uint8]:
    """Bytes, all zero, on a cache line of their own, so that vectors do not lie across two."""
    room = np.zeros(size + 64, dtype=np.uint8)
    start = -room.ctypes.data % 64
    return room[start : start + size]


@dataclass(frozen=True)
class NativeFunctions:
    """Functions of a library, and the memory that they work in; the library lives as long."""

    library: Any
    functions: dict[str, int]
    size: int

    @classmethod
    def from_library(
        cls, ffi: Any, library: Any, stem: str, size: str, names: tuple[str, ...]
    ) -> NativeFunctions:
        functions = {
            name: int(ffi.cast("uintptr_t", getattr(library, f"{stem}_{name}"))) for name in names
        }
        return cls(library, functions, getattr(library, f"{stem}_{size}")())


def flow_functions(ffi: Any, library: Any, stem: str) -> NativeFunctions:
    """Functions of a library that explicit methods need."""
    return NativeFunctions.from_library(ffi, library, stem, "flow_work", ("flow",))


def newton_functions(ffi: Any, library: Any, stem: str) -> NativeFunctions:
    """Functions of a library that implicit methods need besides."""
    names = ("linearise", "factor", "solve_real", "solve_complex")
    return NativeFunctions.from_library(ffi, library, stem, "newton_work", names)


def variation_functions(ffi: Any, library: Any, stem: str) -> NativeFunctions:
    """Functions of a library that runs with tangents need in place of the rates alone."""
    return NativeFunctions.from_library(ffi, library, stem, "variations_work", ("variations",))


@dataclass
class NativeEquations:
    """Equations of one rod, for the step loops.

    states: of y; works: names of the loads without potential; tangents: how many go on with y;
    base: numbers of y before the angles;
    flow, newton: their functions, the second when it is asked for; packed, state: what checks p
    and y; added: numbers of y behind positions and velocities.
    """

    states: int
    works: tuple[str, ...]
    base: int
    flow: NativeFunctions
    packed: Callable[[Any], Array]
    state: Callable[[Any], Array]
    newton: Callable[[], NativeFunctions]
    added: int = 0
    tangents: int = 0

    @property
    def width(self) -> int:
        """Numbers of a row: y, works and tangents."""
        return self.states + len(self.works) + self.tangents * self.states

    def system(self, ffi: Any, implicit: bool) -> Any:
        """A struct rodgen_system."""
        system = ffi.new("struct rodgen_system *")
        system.states, system.works, system.base = self.states, len(self.works), self.base
        system.added, system.tangents = self.added, self.tangents
        parts = [self.flow, self.newton()] if implicit else [self.flow]
        for part in parts:
            for name, address in part.functions.items():
                setattr(system, name, ffi.cast(ffi.typeof(getattr(system, name)), address))
        system.flow_size = self.flow.size
        system.newton_size = parts[-1].size if implicit else 0
        return system


class NativeRun:
    """A run in compiled steps by one of METHODS, from one break point of the loads to the next.

    state (states + works,): y, then the work [J] of every load of works, then the tangents of a
    run that has them; rates: of these; numbers:
    t, steps, rejected, rhs, jacobian, factorisations, ... as steps.h has them; memory: all that a
    run knows, as bytes: with the same bytes in it, another run of this module goes on to the same
    bits.
    """

    equations: ClassVar[NativeEquations]

    def __init__(
        self,
        method: str,
        t: float,
        y: Any,
        p: Any,
        step: float = 0.0,
        rtol: float = 1e-8,
        atol: float = 1e-10,
    ):
        """Start at the state y at time t [s]; step [s]: a fixed one, or the first to try (0: any);
        rtol, atol: what the estimated error of one step may be, of dop853 a sixtieth of what
        rodgen.simulate keeps to."""
        if method not in METHODS:
            raise ValueError(f"method is {method!r}: must be one of {', '.join(METHODS)}")
        equations = self.equations
        self._ffi, self._library = step_library()
        self._values = np.ascontiguousarray(equations.packed(p), dtype=float).copy()
        self._p = self._ffi.from_buffer("double *", self._values)
        self._system = equations.system(self._ffi, method in IMPLICIT)
        self.memory = aligned_bytes(self._library.rodgen_run_size(self._system))
        self.numbers = self._ffi.from_buffer("rodgen_run *", self.memory, require_writable=True)
        self.state = self._row(self._library.rodgen_run_state)
        self.rates = self._row(self._library.rodgen_run_rates)
        self.state[: equations.states] = equations.state(y)
        self._sampled = self._ffi.new("size_t *")
        self.numbers.method, self.numbers.t = METHODS.index(method), t
        self.numbers.step, self.numbers.rtol, self.numbers.atol = step, rtol, atol

    def _row(self, where: Callable[[Any, Any], Any]) -> Array:
        """States and works in the memory, which lives as long as any part of it."""
        address = int(self._ffi.cast("uintptr_t", where(self._system, self.numbers)))
        start = address - self.memory.ctypes.data
        return self.memory[start : start + 8 * self.equations.width].view(float)

    def begin(
        self, end: float, low: float = -np.inf, high: float = np.inf, longest: float = np.inf
    ) -> int:
        """Begin a stretch from here to end [s], in which loads are asked for their values between
        low and high; longest: step [s] of methods that choose theirs. Returns PAUSED or NOT_FINITE;
        raises ValueError for what is no run, such as one that ends before it begins."""
        self.numbers.end, self.numbers.low, self.numbers.high = end, low, high
        self.numbers.longest = longest
        return self._check_status(
            self._library.rodgen_run_start(self._system, self.numbers, self._p)
        )

    def advance(self, quota: int, times: Any, samples: Any, trace: Any = None) -> tuple[int, int]:
        """Take at most quota steps, with samples (K, states + works) at times (K,) that are passed;
        trace (quota, 1 + 2 states): t, y and dy of every step. Both may have more rows. Returns the
        status and the samples taken; raises ValueError for arrays that cannot hold them."""
        ffi, states = self._ffi, self.equations.states
        times = np.ascontiguousarray(times, dtype=float)
        if times.ndim != 1:
            raise ValueError(f"times has shape {times.shape}: must be one axis")
        samples = _rows("samples", samples, len(times), len(self.state))
        if trace is not None:
            trace = ffi.from_buffer("double *", _rows("trace", trace, quota, 2 * states + 1))
        self._sampled[0] = 0
        status = self._library.rodgen_run_on(
            *(self._system, self.numbers, self._p, quota, len(times)),
            *(ffi.from_buffer("double *", times), ffi.from_buffer("double *", samples)),
            *(self._sampled, ffi.NULL if trace is None else trace),
        )
        return self._check_status(status), self._sampled[0]

    def _check_status(self, status: int) -> int:
        """Return the status of a run, or raise ValueError where it is refused."""
        if status == REFUSED:
            n = self.numbers
            raise ValueError(
                f"no run of {METHODS[n.method] if 0 <= n.method < len(METHODS) else n.method} from"
                f" t = {n.t} to end = {n.end} with step = {n.step}, rtol = {n.rtol}, "
                f"atol = {n.atol}: it must be begun, end no earlier than t, have a step above 0 "
                "where the method has a fixed one, and tolerances of at least 0"
            )
        return status

    def state_at(self, times: Any) -> Array:
        """State and works (K, states + works) at times (K,) inside the last step."""
        out = np.empty((len(times), len(self.state)))
        for t, row in zip(times, out, strict=True):
            row = self._ffi.from_buffer("double *", row)
            self._library.rodgen_run_at(self._system, self.numbers, self._p, t, row)
        return out


def with_tangents(equations: NativeEquations, count: int) -> type[NativeRun]:
    """Class of runs with so many tangents, whose numbers (count * states,) end state and rates,
    direction after direction; rates and samples by explicit methods alone."""
    return type("Run", (NativeRun,), {"equations": replace(equations, tangents=count)})


def _rows(name: str, out: Any, count: int, width: int) -> Array:
    """Return out, if so many rows of this width can be written into it, or raise ValueError."""
    count = max(count, len(out)) if np.ndim(out) else count
    plain = isinstance(out, np.ndarray) and not isinstance(out, np.ma.MaskedArray)
    if not (plain and out.dtype == np.dtype(float) and out.shape == (count, width)):
        found = f"{out.dtype} {out.shape}" if plain else type(out).__name__
        raise ValueError(
            f"{name} is {found}: must be an array of doubles of shape {(count, width)}"
        )
    if not (out.flags.c_contiguous and out.flags.writeable and out.dtype.isnative):
        raise ValueError(f"{name} must be writable, its doubles one after the other")
    kept: Array = out
    return kept
