"""Proofs, kept by content hash: what has been proven is not proven again."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass

from rodgen.loading import cache
from rodgen.scene.structure import Structure

# Links of the chain in which accelerations by joint forces are compared: every case is in it.
MOST_JOINTS = 6
MOST_EXPLICIT = 60  # links; beyond, the explicit step takes minutes


@dataclass(frozen=True)
class Held:
    """A comparison that held: what, how, and how many entries."""

    name: str
    how: str
    entries: int


@dataclass(frozen=True)
class Proof:
    """All comparisons of a structure; kept says that they were made earlier."""

    comparisons: tuple[Held, ...]
    seconds: float
    kept: bool = False


def prove(
    structure: Structure,
    explicit: bool = False,
    found: Callable[[Held], None] = lambda _: None,
) -> Proof:
    """Prove the equations of a structure, or recall that they have been proven.

    Up to MOST_EXPLICIT links, or where ``explicit`` asks for it, LagrangesMethod runs with all
    links. ``found`` is called with every comparison as soon as it holds. Raises
    derive.proofs.DisagreementError (an ArithmeticError) at the first entry that differs.
    """
    explicit = explicit or structure.links <= MOST_EXPLICIT
    rod = (structure.links, structure.boundary, structure.inertia)
    what = (*rod, structure.terms, explicit, MOST_JOINTS, structure.uneven)
    packages = (*cache.PACKAGES, "rodgen.check")
    entry = ("proofs", f"{cache.key('proof', *what, packages=packages)}.json")
    kept = _recall(cache.read_text(*entry))
    if kept is not None:
        for comparison in kept.comparisons:
            found(comparison)
        return kept
    from rodgen.derive.proofs import comparisons  # SymPy is imported only where it is needed

    start, held = time.perf_counter(), []
    for c in comparisons(*what):
        held.append(Held(c.name, c.how, c.entries))
        found(held[-1])
    proof = Proof(tuple(held), time.perf_counter() - start)
    rows = [[h.name, h.how, h.entries] for h in proof.comparisons]
    cache.store_text(json.dumps({"held": rows, "seconds": proof.seconds}), *entry)
    return proof


def _recall(text: str | None) -> Proof | None:
    """A stored proof, or None where there is none that can be read."""
    try:
        record = json.loads(text or "")
        rows = tuple(Held(str(n), str(how), int(count)) for n, how, count in record["held"])
        return Proof(rows, float(record["seconds"]), kept=True) if rows else None
    except (ValueError, KeyError, TypeError):
        return None
