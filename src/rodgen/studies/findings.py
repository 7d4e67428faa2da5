"""What analyses of a scene find, by the name under which a study keeps it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from rodgen.analyse.critical import Critical
    from rodgen.analyse.modes import Modes
    from rodgen.system import System

CRITICAL, MODES, STATIC = "critical", "modes", "static"
LYAPUNOV, FLOQUET, CYCLE = "lyapunov", "floquet", "cycle"
FEW = 16  # modes that are looked at for whether one grows
YES, NO, UNKNOWN = 1, 0, -1


@dataclass(frozen=True)
class Finding:
    """of: what an analysis has found, made a number, text or, of several, an array of so many;
    usual: whether it is kept where nothing is asked for; several: how many of several then."""

    of: Callable[[Any, int], Any]
    units: str = ""
    dtype: str = "f8"
    fill: Any = math.nan
    usual: bool = False
    several: int = 0


def _stable(stable: bool | None) -> int:
    return UNKNOWN if stable is None else YES if stable else NO


def _first(values: Any, count: int) -> Any:
    """The first values, as many as asked for."""
    made = np.full(count, math.nan)
    made[: min(count, len(values))] = values[:count]
    return made


def _grows(found: Modes) -> float:
    return float(found.growth.max(initial=-math.inf))


def _of_critical(name: str) -> Callable[[Critical, int], Any]:
    return lambda found, _: getattr(found, name)


FINDINGS: Mapping[str, Mapping[str, Finding]] = {
    CRITICAL: {
        "force": Finding(_of_critical("force"), "N", usual=True),
        "factor": Finding(_of_critical("factor"), usual=True),
        "kind": Finding(_of_critical("kind"), dtype="U12", fill="", usual=True),
        "frequency": Finding(_of_critical("frequency"), "Hz", usual=True),
        "error": Finding(_of_critical("error"), "N", usual=True),
        "frequency_error": Finding(_of_critical("frequency_error"), "Hz"),
        "load_ratio": Finding(_of_critical("load_ratio")),
        "growth": Finding(_of_critical("growth"), "1/s"),
        "turning": Finding(_of_critical("turning"), "1/s"),
        "speed": Finding(_of_critical("speed"), "m/s"),
    },
    MODES: {
        "frequency": Finding(
            lambda found, k: _first(found.frequencies, k), "Hz", "f8", usual=True, several=4
        ),
        "growth": Finding(lambda found, k: _first(found.growth, k), "1/s", usual=True, several=4),
        "largest_growth": Finding(lambda found, _: _grows(found), "1/s"),
        "stable": Finding(lambda found, _: _stable(_grows(found) <= 0), "", "i8", UNKNOWN, True),
    },
    STATIC: {
        "tip_x": Finding(lambda rest, _: rest.tip[0], "m", usual=True),
        "tip_y": Finding(lambda rest, _: rest.tip[1], "m", usual=True),
        "tip_angle": Finding(lambda rest, _: rest.phi[-1], "rad", usual=True),
        "phi": Finding(lambda rest, k: _first(rest.phi, k), "rad", several=4),
        "stable": Finding(lambda rest, _: _stable(rest.stable), "", "i8", UNKNOWN, True),
        "instability": Finding(lambda rest, _: rest.instability or "", dtype="U12", fill=""),
    },
    LYAPUNOV: {
        "exponent": Finding(lambda f, k: _first(f.exponents, k), "1/s", usual=True, several=1),
        "error": Finding(lambda f, k: _first(f.errors, k), "1/s", usual=True, several=1),
        "zero_one": Finding(lambda found, _: found.zero_one, usual=True),
        "chaotic": Finding(lambda found, _: _stable(found.chaotic), "", "i8", UNKNOWN, True),
    },
    FLOQUET: {
        "growth": Finding(lambda found, _: found.growth, "1/s", usual=True),
        "modulus": Finding(lambda found, _: found.modulus, usual=True),
        "stable": Finding(lambda found, _: _stable(found.stable), "", "i8", UNKNOWN, True),
        "argument": Finding(lambda found, _: found.argument, "rad"),
        "moduli": Finding(lambda f, k: _first(np.abs(f.multipliers), k), several=4),
        "period": Finding(lambda found, _: found.period, "s"),
        "error": Finding(lambda found, _: found.error),
    },
    CYCLE: {
        "period": Finding(lambda found, _: found.period, "s", usual=True),
        "amplitude": Finding(lambda found, _: found.amplitude, "rad", usual=True),
        "energy": Finding(lambda found, _: found.energy, "J"),
        "stable": Finding(lambda found, _: _stable(found.stable), "", "i8", UNKNOWN, True),
        "unstable": Finding(lambda found, _: found.unstable, "", "i8", UNKNOWN),
        "moduli": Finding(lambda f, k: _first(np.abs(f.nontrivial), k), several=4),
        "error": Finding(lambda found, _: found.trivial_error),
    },
}


def function_of(what: str) -> Callable[..., Any]:
    """The analysis of a scene."""
    if what == CRITICAL:
        from rodgen.analyse.critical import critical_force

        return critical_force
    if what == MODES:
        from rodgen.analyse.modes import natural_modes

        return natural_modes
    if what == LYAPUNOV:
        from rodgen.analyse.chaos.exponents import lyapunov_exponents

        return lyapunov_exponents
    if what == FLOQUET:
        from rodgen.analyse.cycles.floquet import floquet

        return floquet
    if what == CYCLE:
        from rodgen.analyse.cycles.periodic_motion import find_cycle

        return find_cycle
    from rodgen.analyse.statics import static_equilibrium

    return static_equilibrium


def analysed(what: str, system: System, options: Mapping[str, Any], count: int) -> Any:
    """What the analysis of a system finds; count: of several, how many are asked for. Raises
    InputError, AnalysisError and RunError."""
    if what == MODES:
        return function_of(what)(system, max(count, FEW), **options)
    if what == LYAPUNOV:
        states = len(system.y0)
        return function_of(what)(system, count=min(max(count, 1), states), **options)
    return function_of(what)(system, **options)
