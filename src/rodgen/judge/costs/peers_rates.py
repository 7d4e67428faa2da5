"""What the peers' own functions for the rates cost, each first held against ours."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from rodgen.judge.costs.rod import THRUST, Array, built, compared, packed, row, state, why
from rodgen.judge.timing import Batch, calls
from rodgen.judge.unit import Row

AGREED = 1e-6  # relative: chains in relative coordinates lose digits with their length
PATIENCE = 4.0  # s of set-up, after which more links are not tried
Peers = Mapping[str, tuple[str, str]]  # name -> module, function(links), as in peers.rates


def known() -> dict[str, tuple[str, str]]:
    """The peers that there are."""
    try:
        peers: dict[str, tuple[str, str]] = import_module("rodgen.judge.peers.rates").RATES
    except (ImportError, AttributeError):
        return {}
    return peers


def of_peer(name: str, links: Sequence[int], quick: bool = False) -> list[Row]:
    """A peer's rows, from few links to many, as far as its set-up does not take too long."""
    rows: list[Row] = []
    module, function = known()[name]
    try:
        prepare: Callable[[int], Any] = getattr(import_module(module), function)
    except ImportError as error:
        return [row("rhs", name, n, failed=why(error)) for n in links]
    before, slow = float("inf"), 0
    for n in sorted(links):
        if slow:
            text = f"set-up takes more than {PATIENCE:g} s for {slow} links; more are not tried"
            rows.append(row("rhs", name, n, failed=text))
            continue
        start = time.perf_counter()
        try:
            rows += _measured(name, prepare, n, quick)
        except Exception as error:  # another's library may fail in any way
            rows.append(row("rhs", name, n, failed=why(error)))
        taken = time.perf_counter() - start
        # What is compiled once for any number of links does not grow.
        slow, before = n if taken > max(PATIENCE, 1.5 * before) else 0, taken
    return rows


def _measured(name: str, prepare: Callable[[int], Any], links: int, quick: bool) -> list[Row]:
    start = time.perf_counter()
    prepared = prepare(links)
    setup = time.perf_counter() - start
    check(prepared, links)
    made = compared("rhs", links, {name: partial(_batch, prepared), **_ours(links)}, quick)
    return [{**one, "setup": setup} for one in made if one["who"] == name]


def _batch(prepared: Any) -> Batch:
    batch: Batch = prepared.batch
    return batch


def _ours(links: int) -> dict[str, Any]:
    """Ours takes turns with the peer, so that both see the same machine; it has its row already."""
    module, y = built(links, THRUST), state(links)
    return {"": lambda: calls(partial(module.rhs, 0.0, y, packed(module), np.empty_like(y)))}


def check(prepared: Any, links: int) -> None:
    """Raise ArithmeticError where a peer's rates are not ours."""
    module, y = built(links, THRUST), state(links)
    half = links + 2
    ours: Array = module.rhs(0.0, y, packed(module))[half:]
    theirs = np.asarray(prepared.rhs(y))[half:]
    off = float(np.abs(theirs - ours).max() / np.abs(ours).max())
    if not off <= AGREED:
        raise ArithmeticError(f"the rates differ from rodgen's by {off:.1e}, relative")
