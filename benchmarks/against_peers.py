"""The peers: agreement first, then their time beside rodgen's, called in the same way."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from functools import lru_cache, partial
from importlib import import_module
from types import ModuleType

import native
import numpy as np
from costs import process
from problem import Vector, built, disagreement, packed, state
from report import duration
from rich.console import Console
from rich.table import Table

from rodgen.judge.peers.rates import RATES
from rodgen.judge.peers.rates.prepared import Prepared
from rodgen.judge.timing import Batch, calls, interleaved
from rodgen.loading import BuildError

BUILD = "import sys; from problem import built; built(int(sys.argv[1]), target=sys.argv[2])"
SIZES = (10, 20, 50, 200, 1000)  # links; a peer refuses those that are too many
AGREED = 1e-8  # relative; what differs by more is not the same physics, or not the same digits


def against_peers(console: Console) -> Table:
    """One row for a peer and a number of links; says on the console which are skipped."""
    table = Table(title="free, uniform, follower: what a user would pick instead")
    for column in ("what", "n", "set-up", "off by", "time", "rodgen", "times rodgen"):
        table.add_column(column, justify="left" if column == "what" else "right")
    for name, (module, function) in RATES.items():
        try:
            prepare = getattr(import_module(module), function)
        except ImportError as error:
            why = f"{name} is skipped ({error}): pip install rodgen[bench]"
            console.print(why, markup=False, highlight=False)
            continue
        for links in SIZES:
            table.add_row(name, str(links), *_compare(prepare, links))
        table.add_section()
    for links in (20, 50, 200, 1000):
        target, _ = _rodgen(links)
        setup = duration(_setup(links, target))
        table.add_row(f"rodgen, {target}", str(links), setup, "", "", "", "")
    table.caption = (
        "time: of the peer's own function, without conversion of the state; rodgen: called in the "
        "same way, from C or with an out array from Python; set-up: with nothing kept from before, "
        "without imports but for rodgen, where it is a whole process; Numba compiles for all n"
    )
    return table


def _compare(prepare: Callable[[int], Prepared], links: int) -> list[str]:
    start = time.perf_counter()
    try:
        prepared: Prepared = prepare(links)
    except Exception as error:  # another's library may fail in any way
        return ["-", "-", f"fails: {str(error).splitlines()[:1]}", "", ""]
    setup = duration(time.perf_counter() - start)
    _, module = _rodgen(links)
    y, p = state(links), packed(module)
    off = disagreement(prepared.rhs(y), module.rhs(0.0, y, p))
    if not off < AGREED:
        return [setup, f"{off:.0e}", "not timed", "", ""]
    times = interleaved({"peer": prepared.batch, "ours": _batch(prepared, links, y, p)})
    shown = [duration(times.median(name)) for name in ("peer", "ours")]
    return [setup, f"{off:.0e}", *shown, f"{times.ratio('peer', 'ours'):.2g}"]


def _batch(prepared: Prepared, links: int, y: Vector, p: Vector) -> Batch:
    """rodgen called as the peer is."""
    target, module = _rodgen(links)
    if target != "C":
        return calls(partial(module.rhs, 0.0, y, p))
    if prepared.in_c:
        return native.of_module(module).batch(y, p)
    out = np.empty_like(y)
    return calls(partial(module.rhs, 0.0, y, p, out))


@lru_cache
def _rodgen(links: int) -> tuple[str, ModuleType]:
    """The C target, or NumPy's where it cannot be had."""
    try:
        return "C", built(links, target="c")
    except BuildError:
        return "NumPy", built(links)


def _setup(links: int, target: str) -> float:
    """Seconds of a process that builds with an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        seconds, _ = process(BUILD, [str(links), target.lower()], RODGEN_CACHE=folder)
    return seconds
