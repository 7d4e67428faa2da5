"""Memory that each analysis needs, by the number of links: measured, with some reserve."""

from __future__ import annotations

from dataclasses import dataclass

from rodgen.memory import check_memory
from rodgen.model.term import ANCHOR
from rodgen.model.terms import TERMS
from rodgen.system import System

STATIC, EQUILIBRIA, MODES, CRITICAL = "an equilibrium", "all equilibria", "modes", "a critical load"
BRANCH, BOUNDARY, CYCLE = "a branch", "a boundary", "a cycle"
EXPONENTS, FLOQUET, PRECISION = "exponents", "multipliers", "a comparison of methods"
SHOW = "the fastest motion"


@dataclass(frozen=True)
class MemoryNeed:
    """Memory of an analysis [bytes]: for every link; for every pair of links, of full matrices; and
    for every pair where all equations are full, as with supports, added states, or loads that
    depend on the motion."""

    link: float
    pair: float = 0.0
    whole: float = 0.0


SIZES = {
    STATIC: MemoryNeed(4e3, whole=400),
    EQUILIBRIA: MemoryNeed(25e3, whole=500),
    MODES: MemoryNeed(8e3, whole=400),
    CRITICAL: MemoryNeed(8e3, 75, whole=450),
    BRANCH: MemoryNeed(25e3, whole=600),  # of two hundred points
    BOUNDARY: MemoryNeed(10e3, 600),
    CYCLE: MemoryNeed(10e3, 20e3),
    EXPONENTS: MemoryNeed(10e3),
    FLOQUET: MemoryNeed(10e3, 1500),
    PRECISION: MemoryNeed(100e3),
    SHOW: MemoryNeed(1.2e3),
}
TANGENT = 256.0  # bytes for every number of a tangent
SHAPE = 200.0  # for every link of a mode
ALL_MODES = 250.0  # for every pair of links, where all modes are computed


def check_analysis_memory(
    analysis: str,
    system: System,
    whole: bool = False,
    count: int = 0,
    few: int = 0,
) -> None:
    """Raise InputError for an analysis that needs more memory than it may take.

    analysis: of SIZES; whole: whether all equations are full in any case; count: of modes, or of
    tangents, 0 for all; few: links up to which all modes are computed.
    """
    size, states, structure = SIZES[analysis], len(system.structure.state_names), system.structure
    anchored = any(TERMS[name].kind == ANCHOR for name in structure.loads)
    full = whole or bool(states or structure.has_feedback or anchored)

    def needed_bytes(links: int) -> float:
        pairs = size.pair + size.whole * full + ALL_MODES * (links <= few)
        bytes_ = size.link * links + pairs * (links + states) ** 2
        if analysis == EXPONENTS:
            numbers = 2 * links + states
            bytes_ += TANGENT * numbers * min(count or numbers, numbers)
        elif analysis == MODES:
            bytes_ += SHAPE * links * min(count, links)
        return bytes_

    check_memory(analysis, structure.links, needed_bytes)
