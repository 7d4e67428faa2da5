"""The load family of a scene."""

from __future__ import annotations

import math
from dataclasses import replace

from rodgen.analyse.analysis_guard import CRITICAL, check_analysis_memory
from rodgen.analyse.light_family import LightLoadFamily
from rodgen.analyse.load_family import LoadFamily
from rodgen.analyse.scaled_load import ScaledLoad, default_load, find_term
from rodgen.analyse.steady_rod import SteadyRod, state_after
from rodgen.scene import Scene
from rodgen.system import System


def load_family(
    system: System | Scene,
    t: float | None = None,
    speed: float | None = None,
    after: float | None = None,
    load: str | None = None,
) -> LoadFamily:
    """Linearise a scene for every size of a load. Raises InputError, AnalysisError."""
    system = System.of(system)
    check_analysis_memory(CRITICAL, system)
    system, t = state_after(system, t, speed, after)
    load = default_load(system) if load is None else load
    named, law = find_term(load), None
    term = system.structure.load_rows.get(named.name) if named else None
    if term and term.has_size:
        # Its size is not used by what follows; one that is a function of time is no parameter.
        name = term.size_parameters[0].name
        law = system.expressions.get(name)
        if law is not None:
            system = system.at({system.key_of(name): 0.0})
    rod = SteadyRod.of(system, t, speed)
    made = ScaledLoad.of(load, rod)
    if law is not None:
        applied = math.nan if law.signals else float(law(rod.t))
        made = replace(made, applied=applied)
    return (LightLoadFamily if rod.is_light else LoadFamily)(rod, made)
