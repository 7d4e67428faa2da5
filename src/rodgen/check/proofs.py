"""Proofs of structures, cached by content hash."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

from rodgen.derive.comparison import Comparison
from rodgen.loading import cache
from rodgen.result import Result, ResultTable, Row
from rodgen.scene.structure import Structure

# Links of the chain in which accelerations by joint forces are compared: every case is in it.
MOST_JOINTS = 6
MOST_EXPLICIT = 60  # links; beyond, the explicit step takes minutes


WAYS = {
    "any n": "any n (symbolic)",
    "explicit n": "n = {links} (LagrangesMethod)",
    "rational points": "n = {links} (exact, at random rational points)",
    "joint forces": "n = {few} (from the joint forces, exact)",
}


@dataclass(frozen=True, repr=False)
class Proof(Result):
    """All comparisons of a structure with the closed form, which held; kept says that they were
    made earlier."""

    structure: Structure
    comparisons: tuple[Comparison, ...]
    seconds: float
    kept: bool = False

    ROWS = (
        Row("module", "module", of=lambda proof: proof.structure.stem),
        Row("structure", "structure", of=lambda proof: proof.structure.hash),
        Row("proven", "proven", of=lambda proof: [asdict(one) for one in proof.comparisons]),
        Row("proven_earlier", "proven earlier, unchanged since", of=lambda proof: proof.kept),
    )

    @property
    def entries(self) -> int:
        """Number of entries that were compared."""
        return sum(one.entries for one in self.comparisons)

    def tables(self) -> list[ResultTable]:
        """Numbers of entries that are equal to the closed form, exactly, by matrix or load and by
        the way of comparing."""
        ways = list(dict.fromkeys(one.how for one in self.comparisons))
        names = list(dict.fromkeys(one.name for one in self.comparisons))
        of = {(one.name, one.how): str(one.entries) for one in self.comparisons}
        links = self.structure.n_links
        heads = (WAYS[way].format(links=links, few=min(links, MOST_JOINTS)) for way in ways)
        rows = [(name, *(of.get((name, way), "") for way in ways)) for name in names]
        return [ResultTable.of_rows(("matrix or load", *heads), rows)]

    def __repr__(self) -> str:
        again = "proven earlier" if self.kept else f"proven in {self.seconds:.1f} s"
        return f"<Proof of {self.structure.stem}: {self.entries} entries; {again}>"


def prove(
    structure: Structure,
    explicit: bool = False,
    found: Callable[[Comparison], None] = lambda _: None,
) -> Proof:
    """Prove the equations of a structure, or recall that they have been proven.

    Up to MOST_EXPLICIT links, or where ``explicit`` asks for it, LagrangesMethod runs with all
    links. ``found`` is called with every comparison as soon as it holds. Raises
    derive.proofs.DisagreementError (an ArithmeticError) at the first entry that differs.
    """
    explicit = explicit or structure.n_links <= MOST_EXPLICIT
    rod = (structure.n_links, structure.boundary, structure.inertia)
    what = (*rod, structure.terms, explicit, MOST_JOINTS, structure.nonuniform)
    packages = (*cache.PACKAGES, "rodgen.check")
    entry = ("proofs", f"{cache.key('proof', *what, packages=packages)}.json")
    kept = _recall(structure, cache.read_text(*entry))
    if kept is not None:
        for comparison in kept.comparisons:
            found(comparison)
        return kept
    from rodgen.derive.proofs import comparisons  # SymPy is imported only where it is needed

    start, held = time.perf_counter(), []
    for comparison in comparisons(*what):
        held.append(comparison)
        found(comparison)
    proof = Proof(structure, tuple(held), time.perf_counter() - start)
    rows = [[h.name, h.how, h.entries] for h in proof.comparisons]
    cache.store_text(json.dumps({"held": rows, "seconds": proof.seconds}), *entry)
    return proof


def _recall(structure: Structure, text: str | None) -> Proof | None:
    """A stored proof, or None where there is none that can be read."""
    try:
        record = json.loads(text or "")
        rows = tuple(Comparison(str(n), str(how), int(count)) for n, how, count in record["held"])
        seconds = float(record["seconds"])
        return Proof(structure, rows, seconds, kept=True) if rows else None
    except (ValueError, KeyError, TypeError):
        return None
