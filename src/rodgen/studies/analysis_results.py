"""Analyses that a study can compute, and the rows of their results that it can keep."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.result import UNKNOWN, Result, Row

if TYPE_CHECKING:
    from rodgen.system import System

CRITICAL, MODES, STATIC = "critical", "modes", "static"
LYAPUNOV, FLOQUET, CYCLE = "lyapunov", "floquet", "cycle"
ANALYSES = (CRITICAL, MODES, STATIC, LYAPUNOV, FLOQUET, CYCLE)
FEW = 16  # modes that are looked at for whether one grows


def function_of(analysis: str) -> Callable[..., Any]:
    """Return the function that analyses a system."""
    return _analysis(analysis)[0]


def rows_of(analysis: str) -> dict[str, Row]:
    """Return the rows of an analysis that a study can keep, by name."""
    return {row.name: row for row in _analysis(analysis)[1].ROWS if row.kept is not None}


def _analysis(analysis: str) -> tuple[Callable[..., Any], type[Result]]:
    """Return the function of an analysis and the class of its result, imported on request."""
    if analysis == CRITICAL:
        from rodgen.analyse.critical import Critical, critical_load

        return critical_load, Critical
    if analysis == MODES:
        from rodgen.analyse.modes import Modes, natural_modes

        return natural_modes, Modes
    if analysis == LYAPUNOV:
        from rodgen.analyse.chaos.lyapunov import Exponents, lyapunov_exponents

        return lyapunov_exponents, Exponents
    if analysis == FLOQUET:
        from rodgen.analyse.cycles.floquet import Floquet, floquet

        return floquet, Floquet
    if analysis == CYCLE:
        from rodgen.analyse.cycles.cycle_result import Cycle
        from rodgen.analyse.cycles.periodic_motion import find_cycle

        return find_cycle, Cycle
    from rodgen.analyse.statics import Equilibrium, static_equilibrium

    return static_equilibrium, Equilibrium


@lru_cache(maxsize=8)
def unit_in(analysis: str, system: System, load: str | None) -> str:
    """Return the unit of the load that is scaled, by default the first that follows the rod; "" for
    an analysis that scales none. Raises InputError for a load that cannot be scaled."""
    if analysis != CRITICAL:
        return ""
    from rodgen.analyse.scaled_load import default_load, unit_of

    return unit_of(default_load(system) if load is None else load)


def kept_value(row: Row, result: Result, count: int) -> Any:
    """Return the value of a row as an array keeps it; count: how many of several values."""
    assert row.kept is not None
    value = row.value(result)
    if row.kept.several:
        made = np.full(count, row.kept.fill)
        made[: min(count, len(value))] = value[:count]
        return made
    if value is None:
        return UNKNOWN if row.kept.dtype == "i8" else row.kept.fill
    return value


def analyse(analysis: str, system: System, options: Mapping[str, Any], count: int) -> Any:
    """Analyse a system; count: how many of several values are kept. Raises InputError,
    AnalysisError and RunError."""
    if analysis == MODES:
        return function_of(analysis)(system, max(count, FEW), **options)
    if analysis == LYAPUNOV:
        states = len(system.y0)
        return function_of(analysis)(system, count=min(max(count, 1), states), **options)
    return function_of(analysis)(system, **options)
