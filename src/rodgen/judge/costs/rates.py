"""Set-up from cold, and evaluations of the rates and of their Jacobian."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache, partial
from pathlib import Path
from types import ModuleType

import numpy as np

import rodgen
from rodgen.judge.costs.caches import cache_at, scratch
from rodgen.judge.costs.rod import THRUST, Array, built, compared, packed, row, state
from rodgen.judge.peers.native import Native, compiled
from rodgen.judge.surroundings import flags
from rodgen.judge.timing import Batch, calls
from rodgen.judge.unit import Row
from rodgen.loading import load_files, sources

MOST_DENSE, MOST_JAC, MOST_NUMPY_JAC = 500, 2000, 500  # links that do not take seconds a call
AT_ONCE = 64  # states of a batch


@contextmanager
def set_up(links: int, cold: bool = True) -> Iterator[tuple[list[Row], ModuleType]]:
    """The rod's C module; cold: rows of the seconds of generation, with the import of SymPy, and
    of compilation in an empty cache."""
    if not cold:
        yield [], built(links, THRUST)
        return
    structure = rodgen.Structure(links, terms=THRUST)
    with scratch() as folder, cache_at(folder):
        start = time.perf_counter()
        texts = sources(structure, "c")
        written = time.perf_counter()
        module = load_files(texts)
        done = time.perf_counter()
    rows = [
        row("generate", "rodgen C", links, written - start, rounds=1),
        row("compile", "rodgen C", links, done - written, rounds=1),
    ]
    yield rows, module


def rates(links: int, module: ModuleType, quick: bool) -> list[Row]:
    """Rates at a state, in all forms."""
    y, p = state(links), packed(module)
    out = np.empty_like(y)
    made: dict[str, Callable[[], Batch]] = {
        "rodgen C": lambda: calls(partial(module.rhs, 0.0, y, p, out)),
        "rodgen C, from C": lambda: _native(links).batch(y, p),
        "rodgen C, of a batch": lambda: _batch(module, y, p),
        "rodgen NumPy": lambda: _numpy(links, "chain", y),
    }
    if links <= MOST_DENSE:
        made["rodgen NumPy, dense"] = lambda: _numpy(links, "dense", y)
    return compared("rhs", links, made, quick)


@lru_cache(maxsize=1)
def _native(links: int) -> Native:
    """The C file by itself, compiled as its module compiles it, for calls from C."""
    texts = sources(rodgen.Structure(links, terms=THRUST), "c")
    files = {name: text for name, text in texts.items() if name.endswith((".c", ".h"))}
    source = min(files)  # the .c before the .h
    return compiled(files, f"{Path(source).stem}_rhs", flags().split())


def _batch(module: ModuleType, y: Array, p: Array) -> Batch:
    """Seconds for one state of a batch."""
    many = np.tile(y, (AT_ONCE, 1))
    out = np.empty_like(many)
    whole = calls(partial(module.rhs_batch, 0.0, many, p, out))
    return lambda number: whole(-(-number // AT_ONCE)) * number / (-(-number // AT_ONCE) * AT_ONCE)


def _numpy(links: int, form: str, y: Array) -> Batch:
    module = built(links, THRUST, "numpy", form)
    return calls(partial(module.rhs, 0.0, y, packed(module)))


def jacobians(links: int, module: ModuleType, quick: bool) -> list[Row]:
    """Exact Jacobians, dense as they are."""
    y, p = state(links), packed(module)
    made: dict[str, Callable[[], Batch]] = {}
    if links <= MOST_JAC:
        made["rodgen C"] = lambda: calls(partial(module.jac, 0.0, y, p))
    if links <= MOST_NUMPY_JAC:
        made["rodgen NumPy"] = lambda: _numpy_jac(links, y)
    return compared("jacobian", links, made, quick)


def _numpy_jac(links: int, y: Array) -> Batch:
    module = built(links, THRUST, "numpy")
    return calls(partial(module.jac, 0.0, y, packed(module)))
