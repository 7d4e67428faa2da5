"""The peers: agreement first, then their time beside rodgen's, called in the same way."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache, partial
from types import ModuleType

import native
import numpy as np
from peers import Prepared, peers
from problem import Vector, built, disagreement, packed, state
from report import MISSING, duration
from rich.console import Console
from rich.table import Table
from timing import Batch, calls, interleaved

AGREED = 1e-8  # relative; what differs by more is not the same physics, or not the same digits


def against_peers(console: Console) -> Table:
    """One row for a peer and a number of links; says on the console which are skipped."""
    table = Table(title="free, uniform, follower: what a user would pick instead")
    for column in ("what", "n", "set-up", "off by", "time", "rodgen", "times rodgen"):
        table.add_column(column, justify="left" if column == "what" else "right")
    for name, peer in peers():
        if isinstance(peer, ImportError):
            why = f"{name} is skipped ({peer}): pip install rodgen[bench]"
            console.print(why, markup=False, highlight=False)
            continue
        for links in peer.SIZES:
            table.add_row(peer.NAME, str(links), *_compare(peer, links))
        table.add_section()
    for links in (20, 50, 200, 1000):
        target, _, seconds = _rodgen(links)
        table.add_row(f"rodgen, {target}", str(links), duration(seconds), "", "", "", "")
    table.caption = (
        "time: of the peer's own function, without conversion of the state; rodgen: called in the "
        "same way, from C or with an out array from Python; set-up: with nothing kept from before"
    )
    return table


def _compare(peer: ModuleType, links: int) -> list[str]:
    start = time.perf_counter()
    try:
        prepared = peer.prepare(links)
    except Exception as error:  # another's library may fail in any way
        return ["-", "-", f"fails: {str(error).splitlines()[:1]}", "", ""]
    setup = duration(time.perf_counter() - start)
    _, module, _ = _rodgen(links)
    y, p = state(links), packed(module)
    off = disagreement(prepared.rhs(y), module.rhs(0.0, y, p))
    if not off < AGREED:
        return [setup, f"{off:.0e}", "not timed", "", ""]
    times = interleaved({"peer": prepared.batch, "ours": _batch(prepared, links, y, p)})
    shown = [duration(times.median(name)) for name in ("peer", "ours")]
    return [setup, f"{off:.0e}", *shown, f"{times.ratio('peer', 'ours'):.2g}"]


def _batch(prepared: Prepared, links: int, y: Vector, p: Vector) -> Batch:
    """rodgen called as the peer is."""
    target, module, _ = _rodgen(links)
    if target != "C":
        return calls(partial(module.rhs, 0.0, y, p))
    if prepared.in_c:
        return native.of_module(module).batch(y, p)
    out = np.empty_like(y)
    return calls(partial(module.rhs, 0.0, y, p, out))


@lru_cache
def _rodgen(links: int) -> tuple[str, ModuleType, float]:
    """The C target, or NumPy's where it cannot be had, and the time of its set-up from cold."""
    with _empty_cache():
        start = time.perf_counter()
        try:
            found = "C", built(links, target="c")
        except MISSING:
            found = "NumPy", built(links)
        return *found, time.perf_counter() - start


_kept: list[tempfile.TemporaryDirectory[str]] = []  # loaded libraries lie in them


@contextmanager
def _empty_cache() -> Iterator[None]:
    _kept.append(tempfile.TemporaryDirectory())
    before = os.environ.get("RODGEN_CACHE")
    os.environ["RODGEN_CACHE"] = _kept[-1].name
    try:
        yield
    finally:
        del os.environ["RODGEN_CACHE"]
        if before is not None:
            os.environ["RODGEN_CACHE"] = before
