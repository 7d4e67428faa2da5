"""C compiled for the benchmark, and timed in a C loop."""

from __future__ import annotations

import ctypes
import os
import shlex
import subprocess
import tempfile
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from problem import Vector
from timing import Batch

HERE = Path(__file__).parent
FLAGS = ("-O3", "-march=native", "-fno-math-errno")  # where no module names its own
_POINTER = ctypes.POINTER(ctypes.c_double)


@dataclass(frozen=True)
class Native:
    """A C function void (double t, const double *y, const double *p, double *dy)."""

    function: Any  # of ctypes
    library: ctypes.CDLL  # kept loaded

    def __call__(self, y: Vector, p: Vector) -> Vector:
        dy = np.empty_like(y)
        self.function(ctypes.c_double(0.0), _pointer(y), _pointer(p), _pointer(dy))
        return dy

    def batch(self, y: Vector, p: Vector) -> Batch:
        """Batches of calls from C."""
        loop, dy = _loop(), np.empty_like(y)
        arguments = (self.function, _pointer(y), _pointer(p), _pointer(dy))
        return lambda number: float(loop(*arguments, ctypes.c_long(number)))


def compiled(source: Path, name: str, flags: tuple[str, ...] = FLAGS) -> Native:
    """A function of a C file, compiled with these flags and loaded."""
    folder = Path(tempfile.mkdtemp(prefix="rodgen-bench-", dir=_scratch()))
    path = folder / f"{source.stem}.so"
    compiler = shlex.split(os.environ.get("CC", "cc"))
    command = [*compiler, "-std=c99", "-fPIC", "-shared", *flags, str(source), "-o", str(path)]
    made = subprocess.run([*command, "-lm"], capture_output=True, text=True)
    if made.returncode:
        raise RuntimeError(f"{' '.join(command)} failed:\n{made.stderr}")
    return loaded(path, name)


def loaded(path: Path, name: str) -> Native:
    """A function of a library."""
    library = ctypes.CDLL(str(path))
    function = library[name]
    function.restype = None
    return Native(function, library)


def of_module(module: ModuleType) -> Native:
    """The right-hand side of a module of the C target: in the library that it has loaded, or
    else compiled from its C file with its flags."""
    source = Path(str(module.__file__)).with_suffix(".c")
    name = f"{source.stem}_rhs"
    library = getattr(module, "LIBRARY", None)
    return loaded(Path(library), name) if library else compiled(source, name, flags_of(module))


def yardstick(links: int, flags: tuple[str, ...] = FLAGS) -> Native:
    """The plain elimination for so many links."""
    return compiled(HERE / "yardstick.c", "yardstick_rhs", (*flags, f"-DN={links}"))


def flags_of(module: ModuleType) -> tuple[str, ...]:
    """The flags of a module of the C target."""
    flags = module.FLAGS
    return tuple(flags.split() if isinstance(flags, str) else flags)


@lru_cache(maxsize=1)
def _loop() -> Any:
    loop = compiled(HERE / "loop.c", "loop").function
    loop.restype = ctypes.c_double
    return loop


@lru_cache(maxsize=1)
def _folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="rodgen-bench-")


def _scratch() -> str:
    """Removed when the benchmark ends."""
    return _folder().name


def _pointer(values: Vector) -> ctypes._Pointer[ctypes.c_double]:
    return values.ctypes.data_as(_POINTER)
