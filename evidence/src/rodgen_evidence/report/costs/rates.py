"""Rates and Jacobians against the number of links, of rodgen and of its peers."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from pathlib import Path
from types import ModuleType

import numpy as np

import rodgen
from rodgen.analyse.precision.contestant import Measurement, describe_error
from rodgen.loading import sources
from rodgen_evidence.report.costs.cold import cold, environment, scratch
from rodgen_evidence.report.costs.cost_rows import (
    THRUST,
    Array,
    built,
    compare_costs,
    parameter_vector,
    row,
    scene,
    state,
)
from rodgen_evidence.report.interleaved_timing import Batch, calls
from rodgen_evidence.report.peers import prepare
from rodgen_evidence.report.peers.native import Native, compile_function
from rodgen_evidence.report.peers.peer import check_difference, difference
from rodgen_evidence.report.surroundings import flags

MOST_DENSE, MOST_JAC, MOST_NUMPY_JAC = 500, 2000, 500  # links that do not take seconds a call
AT_ONCE = 64  # states of a batch


def set_up(links: int, quick: bool) -> tuple[list[Measurement], ModuleType]:
    """The rod's C module; unless quick, made from cold, with rows of the seconds of that."""
    if quick:
        return [], built(links, THRUST)
    with scratch() as folder, environment(RODGEN_CACHE=folder):
        seconds = cold(scene(links).model_dump(exclude_none=True), folder)
        rows = [row(kind, "rodgen C", links, taken, rounds=1) for kind, taken in seconds.items()]
        return rows, built(links, THRUST)


def rates(links: int, module: ModuleType, quick: bool) -> list[Measurement]:
    """Rates at a state, in all forms."""
    y, p = state(links), parameter_vector(module)
    out = np.empty_like(y)
    made: dict[str, Callable[[], Batch]] = {
        "rodgen C": lambda: calls(partial(module.rhs, 0.0, y, p, out)),
        "rodgen C, from C": lambda: native(links).batch(y, p),
        "rodgen C, of a batch": lambda: _batch(module, y, p),
        "rodgen NumPy": lambda: _numpy(links, "chain", y),
    }
    if links <= MOST_DENSE:
        made["rodgen NumPy, dense"] = lambda: _numpy(links, "dense", y)
    return compare_costs("rhs", links, made, quick)


@lru_cache(maxsize=2)
def native(links: int, nonuniform: tuple[str, ...] = ()) -> Native:
    """The C file by itself, compiled as its module compiles it, for calls from C; nonuniform: what
    differs along the rod."""
    texts = sources(rodgen.Structure(links, terms=THRUST, nonuniform=nonuniform), "c")
    files = {name: text for name, text in texts.items() if name.endswith((".c", ".h"))}
    source = min(files)  # the .c before the .h
    return compile_function(files, f"{Path(source).stem}_rhs", flags().split())


def _batch(module: ModuleType, y: Array, p: Array) -> Batch:
    """Seconds for one state of a batch."""
    many = np.tile(y, (AT_ONCE, 1))
    out = np.empty_like(many)
    whole = calls(partial(module.rhs_batch, 0.0, many, p, out))
    return lambda number: whole(-(-number // AT_ONCE)) * number / (-(-number // AT_ONCE) * AT_ONCE)


def _numpy(links: int, form: str, y: Array, function: str = "rhs") -> Batch:
    module = built(links, THRUST, "numpy", form)
    return calls(partial(getattr(module, function), 0.0, y, parameter_vector(module)))


def jacobians(links: int, module: ModuleType, quick: bool) -> list[Measurement]:
    """Exact Jacobians, dense as they are."""
    y, p = state(links), parameter_vector(module)
    made: dict[str, Callable[[], Batch]] = {}
    if links <= MOST_JAC:
        made["rodgen C"] = lambda: calls(partial(module.jac, 0.0, y, p))
    if links <= MOST_NUMPY_JAC:
        made["rodgen NumPy"] = lambda: _numpy(links, "chain", y, "jac")
    return compare_costs("jacobian", links, made, quick)


PATIENCE = 4.0  # s of set-up, after which more links are not tried


def of_peer(name: str, links: Sequence[int], quick: bool = False) -> list[Measurement]:
    """A peer's rows, from few links to many, as far as its set-up does not take too long."""
    rows: list[Measurement] = []
    before, slow = float("inf"), 0
    for n in sorted(links):
        if slow:
            text = f"set-up takes more than {PATIENCE:g} s for {slow} links; more are not tried"
            rows.append(row("rhs", name, n, failed=text))
            continue
        start = time.perf_counter()
        try:
            rows.append(_measure(name, n, quick))
        except Exception as error:  # another's library may fail in any way
            rows.append(row("rhs", name, n, failed=describe_error(error)))
        taken = time.perf_counter() - start
        # What is compiled once for any number of links does not grow.
        slow, before = n if taken > max(PATIENCE, 1.5 * before) else 0, taken
    return rows


def _measure(name: str, links: int, quick: bool) -> Measurement:
    """Measure a peer in turns with rodgen, so that both see the same machine; return its row.

    Raises ArithmeticError where the peer's rates are not ours.
    """
    start = time.perf_counter()
    peer = prepare(name, links)
    setup = time.perf_counter() - start
    module, y = built(links, THRUST), state(links)
    p, out = parameter_vector(module), np.empty_like(y)
    half = len(y) // 2
    check_difference(difference(np.asarray(peer.rhs(y))[half:], module.rhs(0.0, y, p)[half:]))
    both = {name: lambda: peer.batch, "": lambda: calls(partial(module.rhs, 0.0, y, p, out))}
    made = compare_costs("rhs", links, both, quick)
    return next(one for one in made if one["who"] == name) | {"setup": setup}
