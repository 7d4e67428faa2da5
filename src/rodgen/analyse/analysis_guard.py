"""Guards of every analysis: one BLAS thread, doubts as warnings, overflow as AnalysisError;
checks of bounds; and memory needs by the number of links, measured, with some reserve.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, wraps
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from rodgen.errors import AnalysisError, InputError
from rodgen.memory import check_memory
from rodgen.model.terms import TERMS
from rodgen.result import warns_of_doubts
from rodgen.scene.plain_tables import is_number, to_plain
from rodgen.scene.tables import LARGEST
from rodgen.system import System
from rodgen.system.link_inertia import is_light

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")

STATIC, EQUILIBRIA, MODES, CRITICAL = "an equilibrium", "all equilibria", "modes", "a critical load"
BRANCH, BOUNDARY, CYCLE = "a branch", "a boundary", "a cycle"
EXPONENTS, FLOQUET, PRECISION = "exponents", "multipliers", "a comparison of methods"
SHOW, LINEAR = "the fastest motion", "a linear model"

Bounds = tuple[float, float]
OpenBounds = tuple[float | None, float | None]


@lru_cache(maxsize=1)
def _thread_controller() -> ThreadpoolController:
    import scipy.linalg  # noqa: F401, whose BLAS has to be loaded to be found
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def guard_analysis(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate an analysis to warn of every doubt about its result, to run on one BLAS thread
    (waking others costs more than they save on small problems), and to raise AnalysisError where a
    number leaves the range of doubles."""

    @warns_of_doubts
    @wraps(function)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> R:
        import numpy as np  # here, as commands need the errors alone

        try:
            with _thread_controller().limit(limits=1, user_api="blas"), np.errstate(all="ignore"):
                return function(*args, **kwargs)
        except (np.linalg.LinAlgError, ZeroDivisionError, OverflowError) as error:
            raise AnalysisError(
                f"numbers too large or too small for double precision ({error})"
            ) from error

    return wrapper


@dataclass(frozen=True)
class MemoryNeed:
    """Memory of an analysis [bytes]: for every link; for every pair of links, of full matrices; and
    for every pair where all equations are full, as with supports, added states, loads that depend
    on the motion, or links without mass."""

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
    LINEAR: MemoryNeed(10e3, 1500),
}
TANGENT = 256.0  # bytes for every number of a tangent
SHAPE = 200.0  # for every link of a mode
ALL_MODES = 250.0  # for every pair of links, where all modes are computed


def check_analysis_memory(
    analysis: str, system: System, whole: bool = False, count: int = 0, few: int = 0
) -> None:
    """Raise InputError for an analysis that needs more memory than it may take.

    analysis: of SIZES; whole: whether all equations are full in any case; count: of modes, or of
    tangents, 0 for all; few: links up to which all modes are computed.
    """
    size, states, structure = SIZES[analysis], len(system.structure.state_names), system.structure
    anchored = any(TERMS[name].holds_joints for name in structure.loads)
    full = whole or bool(states or structure.has_feedback or anchored) or is_light(system)

    def needed_bytes(links: int) -> float:
        pairs = size.pair + size.whole * full + ALL_MODES * (links <= few)
        bytes_ = size.link * links + pairs * (links + states) ** 2
        if analysis == EXPONENTS:
            numbers = 2 * links + states
            bytes_ += TANGENT * numbers * min(count or numbers, numbers)
        elif analysis == MODES:
            bytes_ += SHAPE * links * min(count, links)
        return bytes_

    check_memory(analysis, structure.n_links, needed_bytes)


def check_whole_number(
    given: object, field: str, low: int, high: float = math.inf, allowed: str = ""
) -> int:
    """Check a whole number from low to high, and return it. allowed: what the message says, by
    default the range. Raises InputError for anything else."""
    number = to_plain(given, field)
    if isinstance(number, int) and not isinstance(number, bool) and low <= number <= high:
        return number
    ends = f"of at least {low}" if high == math.inf else f"from {low} to {high}"
    raise InputError(field, given, allowed or f"a whole number {ends}")


def check_positive(
    given: object, field: str, allowed: str, most: float = sys.float_info.max
) -> float:
    """Check a number above 0 and up to the most, and return it. allowed: what the message says.
    Raises InputError for anything else."""
    number = to_plain(given, field)
    if is_number(number) and 0 < number <= most:
        return float(number)
    raise InputError(field, given, allowed)


def check_inside(given: object, field: str, bounds: Bounds, more: str = "") -> float:
    """Check a number within bounds, in any order, and return it. more: for the message. Raises
    InputError for anything else."""
    number, (low, high) = to_plain(given, field), sorted(bounds)
    if is_number(number) and low <= number <= high:
        return float(number)
    raise InputError(field, given, f"a number in the range, {low:g} to {high:g}{more}")


def check_bounds(given: object) -> Bounds:
    """Check bounds and return them. Raises InputError unless they are two finite numbers."""
    low, high = check_open_bounds(given, "(a, b), two finite numbers")
    if low is None or high is None:
        raise InputError("bounds", given, "(a, b), two finite numbers")
    return float(low), float(high)


def check_open_bounds(
    given: object, allowed: str = "(a, b), each None or a finite number"
) -> OpenBounds:
    """Check bounds of which each may be None, and return them. Raises InputError for others."""

    def can_be_end(value: object) -> bool:
        return value is None or (is_number(value) and abs(value) <= LARGEST)

    ends = to_plain(given, "bounds")
    if not (isinstance(ends, list) and len(ends) == 2 and all(map(can_be_end, ends))):
        raise InputError("bounds", given, f"{allowed}, at most {LARGEST:g} in size")
    return ends[0], ends[1]
