"""C compiled for the benchmark, and timed in a C loop."""

from __future__ import annotations

import ctypes
import os
import shlex
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from problem import Vector

import rodgen
from rodgen.judge.timing import Batch
from rodgen.loading import BuildError, sources

HERE = Path(__file__).parent
_SHARED = ("-std=c99", "-fPIC", "-shared")  # as the C target is built
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


def compiled(texts: Mapping[str, str], name: str, flags: tuple[str, ...]) -> Native:
    """A function of C files, of which the first is compiled with these flags, and loaded."""
    folder = Path(tempfile.mkdtemp(dir=_scratch().name))
    for file, text in texts.items():
        (folder / file).write_text(text)
    compiler = shlex.split(os.environ.get("CC", "cc"))
    command = [*compiler, *_SHARED, *flags, next(iter(texts)), "-o", "library.so", "-lm"]
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


def of_module(module: ModuleType) -> Native:
    """The right-hand side of a module of the C target, its C file compiled as it is there."""
    structure = rodgen.Structure(module.N, module.BOUNDARY, module.INERTIA, module.TERMS)
    texts = sources(structure, "c")
    source = next(name for name in texts if name.endswith(".c"))
    files = {source: texts[source]} | {name: texts[name] for name in texts if name.endswith(".h")}
    return compiled(files, f"{Path(source).stem}_rhs", flags_of(module))


def yardstick(links: int, flags: tuple[str, ...]) -> Native:
    """The plain elimination for so many links."""
    file = HERE / "yardstick.c"
    return compiled({file.name: file.read_text()}, "yardstick_rhs", (*flags, f"-DN={links}"))


def flags_of(module: ModuleType) -> tuple[str, ...]:
    """The flags that a module of the C target is compiled with on this machine."""
    if hasattr(module, "_flag_sets"):
        first: tuple[str, ...] = module._flag_sets(module._processor())[0]
        return first
    return tuple(module.FLAGS)


@lru_cache(maxsize=1)
def _loop() -> Any:
    file = HERE / "loop.c"
    loop = compiled({file.name: file.read_text()}, "loop", ("-O2",)).function
    loop.restype = ctypes.c_double
    return loop


@lru_cache(maxsize=1)
def _scratch() -> tempfile.TemporaryDirectory[str]:
    """Removed when the benchmark ends."""
    return tempfile.TemporaryDirectory(prefix="rodgen-bench-")


def _pointer(values: Vector) -> ctypes._Pointer[ctypes.c_double]:
    return values.ctypes.data_as(_POINTER)
