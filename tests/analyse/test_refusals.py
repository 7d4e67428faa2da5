"""What no analysis takes: each refuses it by the field that it is about; and what has no answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
from rodgen.analyse.branches.stability_boundary import stability_boundary
from rodgen.analyse.chaos.lyapunov import lyapunov_exponents
from rodgen.analyse.chaos.poincare import zero_one_test
from rodgen.analyse.critical import critical_load
from rodgen.analyse.cycles.cycle_continuation import continue_cycles
from rodgen.analyse.cycles.floquet import floquet
from rodgen.analyse.cycles.nonlinear_modes import nonlinear_mode
from rodgen.analyse.cycles.periodic_motion import find_cycle
from rodgen.analyse.extrapolation import richardson
from rodgen.analyse.modes import natural_modes
from rodgen.analyse.references.continuum import (
    chain_frequency,
    linear_own_weight,
    linear_tip_force,
    natural_frequency,
    wave_number,
)
from rodgen.analyse.references.elastica import axial_force, own_weight, tip_force
from rodgen.analyse.references.follower_columns import LOADS, thrust_frequencies
from rodgen.analyse.simulated_critical import simulated_critical_load
from rodgen.analyse.spectrum import find_peaks
from rodgen.analyse.statics import static_equilibrium
from rodgen.errors import AnalysisError
from rodgen.scene import Scene
from tests.analyse.rods import AXIAL, COLUMN, FORCE, THRUST, ZIEGLER, rod
from tests.sets import sets
from tests.told import refused

nan, inf = np.nan, np.inf
EXTERNAL = "loads.external_damping.coefficient"
INTERNAL, STIFFNESS = "loads.internal_damping.coefficient", "rod.bending_stiffness"
CLAMPED, FREE = rod(3, "clamped", THRUST), rod(4, "free", THRUST)
BENT = rod(5, "clamped", {"tip": {"x": 0.0, "y": 0.0}})
CYCLING, ROUND = COLUMN, ZIEGLER
BURNING = rod(5, "clamped", {"follower": {"force": "300 - t"}}, integrate={"span": [0, 8]})
FALLING = rod(4, "free", {"gravity": {}, "drag": {"normal": 0.8, "tangential": 0.05}})
DAMPED = THRUST | {"external_damping": {"coefficient": 0.5}}
FLYING = rod(4, "free", DAMPED, initial={"velocity": [-20.0, 0.0]})
SPRINGY = rod(2, "free", inertia="lumped")
SWINGING, TUMBLING = (rod(n, "pinned", {"gravity": {}}) for n in (1, 2))
SIZES = {"length": 1.0, "bending_stiffness": 1.0}
T = 0.01 * np.arange(100)
TONE = np.cos(60 * T)


def forced(load: str) -> Scene:
    return rod(1, "pinned", {"tip": {"x": load}}, bending_stiffness=0.0)


# Functions with what they are about, and values of their options that they refuse by its name.
OPTIONS: list[tuple[Callable[..., object], tuple[Any, ...], dict[str, tuple[Any, ...]]]] = [
    (natural_modes, (FREE,), {"count": (0,)}),
    (natural_modes, (BURNING,), {"t": (8.1,)}),
    (static_equilibrium, (BURNING,), {"t": (-0.1,)}),
    (static_equilibrium, (CLAMPED,), {"imperfection": (0.0, -0.01, 1.5, nan, inf, "0.1", True)}),
    (critical_load, (BURNING,), {"t": (nan, inf, "1", True), "load": ("wind",)}),
    (critical_load, (CLAMPED,), {"bounds": [(None, one) for one in (5e-324, inf, nan, 1e61, "3")]}),
    (critical_load, (CLAMPED,), {"bounds": ((-inf, None), (nan, 1.0), (True, None), 3.0, (1.0,))}),
    (critical_load, (CLAMPED,), {"speed": (3.0,), "end": ("middle",), "simulate": (0.0, nan)}),
    (critical_load, (CLAMPED,), {"simulate": ("8",)}),
    (critical_load, (FREE,), {"speed": (nan, "fast", True), "after": (11.0, -1.0, inf)}),
    (simulated_critical_load, (CLAMPED,), {"step": (0.01,)}),
    (continue_equilibria, (BENT, AXIAL, (0.0, -5.0)), {"branch_point": (1,)}),
    (continue_equilibria, (FALLING, STIFFNESS, (1.0, 2.0)), {"motion": ("rest",)}),
    (find_cycle, (ROUND,), {"period": (1.0,), "y0": ([0.1] * 4,), "segments": (0,)}),
    (find_cycle, (ROUND,), {"method": ("hand",), "multipliers": (0,)}),
    (continue_cycles, (CYCLING, FORCE, (1.0, 5.0)), {"start": ("anywhere",)}),
    (floquet, (forced("sin(t)"),), {"period": (-1.0,), "segments": (0,), "y": ([1.0],)}),
    (floquet, (forced("1.0"),), {"period": (None,)}),
    (floquet, (forced("exp(-t)"),), {"period": (None,)}),
    (floquet, (forced("sin(t)*t"),), {"period": (None,)}),
    (floquet, (forced("sin(t) + sin(sqrt(2)*t)"),), {"period": (None,)}),
    (lyapunov_exponents, (TUMBLING,), {"count": (0, 5, 1.5), "span": (-1.0, inf)}),
    (lyapunov_exponents, (TUMBLING,), {"transient": (10.0, nan)}),
    (find_peaks, (T, TONE), {"window": ("blackman",), "peaks": (0,), "lowest": (-1.0,)}),
    (find_peaks, (T, TONE), {"floor": (1.0,)}),
    (richardson, ((10, 20), (1, 2)), {"order": (0,)}),
    (richardson, ((10, 20, 40), (1, 1.5, 1.6)), {"order": ((4, 2),)}),
    (wave_number, ("free",), {"k": (0,)}),
    (wave_number, ("free", 1), {"digits": (0,)}),
    (chain_frequency, (1,), {"length": (-1.0,)}),
]


@pytest.mark.parametrize(("function", "about", "options"), OPTIONS)
def test_values_of_an_option_that_are_refused(
    function: Callable[..., object], about: tuple[Any, ...], options: dict[str, tuple[Any, ...]]
) -> None:
    more = {"model": rodgen.build(about[0], "numpy")} if function is floquet else {}
    more |= {"target": "numpy"} if function is find_cycle else {}
    for name, values in options.items():
        for value in values:
            assert refused(function, *about, **more, **{name: value}).field == name, value


# The field by which something else is refused.
OTHERS: list[tuple[str, Callable[[], object]]] = [
    ("t", lambda: natural_modes(FREE, after=1.0, t=2.0)),
    ("speed", lambda: natural_modes(FREE, after=1.0, speed=2.0)),
    ("rod.boundary", lambda: static_equilibrium(rod(4, "free", {"gravity": {}}))),
    ("loads.follower", lambda: critical_load(rod(4, "free"))),
    (STIFFNESS, lambda: critical_load(rod(4, "free", THRUST, bending_stiffness=0.0))),
    ("bounds", lambda: critical_load(CLAMPED, bounds=(10.0, 5.0))),
    ("bounds", lambda: critical_load(CLAMPED, bounds=(3.0, 3.0))),
    ("bounds", lambda: critical_load(CLAMPED, bounds=(1e9, np.nextafter(1e9, 2e9)))),
    ("loads.tip", lambda: critical_load(CLAMPED, load="tip")),
    ("rtol", lambda: simulated_critical_load(CLAMPED, method="rk4", step=0.01, rtol=1e-3)),
    ("vary", lambda: stability_boundary(ROUND, (FORCE, FORCE))),
    ("vary", lambda: stability_boundary(ROUND, (FORCE, "loads.nothing.x"))),
    ("rod.links", lambda: stability_boundary(ROUND, (FORCE, "rod.links"))),
    # External damping of a rod in flight has no linear part.
    ("vary", lambda: stability_boundary(FLYING, (FORCE, EXTERNAL))),
    *(
        ("bounds", lambda key=key, e=e: stability_boundary(ROUND, (FORCE, key), bounds=e))
        for key, e in ((INTERNAL, (None, (1.0, 0.0))), (INTERNAL, (None, (0.0, inf))))
    ),
    ("vary", lambda: continue_equilibria(BENT, "rod.links", (5, 10))),
    ("vary", lambda: continue_equilibria(BENT, "name", (0, 1))),
    ("vary", lambda: continue_equilibria(BENT, "initial.phi.0", (0.0, 1.0))),
    ("loads.tip.z", lambda: continue_equilibria(BENT, "loads.tip.z", (0, 1))),
    ("bounds", lambda: continue_equilibria(BENT, AXIAL, (1.0, 1.0))),
    ("bounds", lambda: continue_equilibria(BENT, AXIAL, (0.0, nan))),
    ("rod.mass", lambda: continue_equilibria(BENT, "rod.mass", (1.0, -1.0))),
    ("y0", lambda: find_cycle(ROUND, y0=[0.0], period=1.0, target="numpy")),
    ("segments", lambda: find_cycle(ROUND, method="collocation", segments=3, target="numpy")),
    ("segments", lambda: find_cycle(ROUND, segments=3, multipliers=3, target="numpy")),
    ("multipliers", lambda: find_cycle(ROUND, method="shooting", multipliers=3, target="numpy")),
    ("vary", lambda: continue_cycles(CYCLING, "rod.links", (3, 9))),
    ("loads.none", lambda: continue_cycles(CYCLING, "loads.none", (1, 2))),
    ("bounds", lambda: continue_cycles(CYCLING, FORCE, (5.0, 5.0))),
    ("bounds", lambda: continue_cycles(CYCLING, FORCE, (5.0, nan))),
    ("bounds", lambda: continue_equilibria(BENT, AXIAL, 5.0)),
    ("mode", lambda: nonlinear_mode(SPRINGY, 9, 0.5)),
    ("energy", lambda: nonlinear_mode(SPRINGY, 1, -0.5)),
    ("mode", lambda: nonlinear_mode(CYCLING, 1, 0.5)),
    ("series", lambda: zero_one_test(np.ones(99))),
    ("series", lambda: zero_one_test(np.ones((200, 2)))),
    ("events[0].quantity", lambda: rodgen.poincare_section(SWINGING, "phi_9", rising=0.0)),
    ("section", lambda: rodgen.poincare_section(SWINGING, "phi_0")),
    ("section", lambda: rodgen.poincare_section(SWINGING, "phi_0", rising=0.0, falling=0.0)),
    ("rising", lambda: rodgen.poincare_section(SWINGING, "phi_0", rising=nan)),
    ("transient", lambda: rodgen.poincare_section(SWINGING, "phi_0", rising=0.0, transient=-1.0)),
    ("t[99]", lambda: find_peaks(np.r_[T[:99], 1.0], TONE)),
    ("t[1]", lambda: find_peaks(np.zeros(100), TONE)),
    ("signal", lambda: find_peaks(T, TONE[:50])),
    ("signal", lambda: find_peaks(T, np.full(100, nan))),
    ("n", lambda: richardson((10, 20), (1, 2))),
    ("n", lambda: richardson((10,), (1,), 2)),
    *(("n", lambda n=n: richardson((10, 20, n), (1, 2, 3))) for n in (20, -5, inf)),
    ("n", lambda: richardson([10, FREE, CLAMPED], (1, 2, 3))),
    ("values", lambda: richardson((10, 20, 40), (1, nan, 3))),
    ("values", lambda: richardson((10, 20, 40), (1, 2))),
    ("boundary", lambda: wave_number("clamped-free", 1)),
    ("mass", lambda: natural_frequency("free", 1, mass=0, **SIZES)),
    ("force", lambda: linear_tip_force(force=nan, **SIZES)),
    ("bending_stiffness", lambda: linear_tip_force(force=1, length=1, bending_stiffness=nan)),
    ("load", lambda: linear_own_weight(load=inf, **SIZES)),
    ("load", lambda: thrust_frequencies(nan, 2)),
    ("load", lambda: thrust_frequencies(2 * LOADS, 2)),
    ("count", lambda: thrust_frequencies(1.0, 0)),
    ("load", lambda: tip_force(-1.0)),
    ("load", lambda: axial_force(-1.0)),
    ("load", lambda: own_weight("heavy")),
]


def test_what_else_is_refused() -> None:
    for number, (field, call) in enumerate(OTHERS):
        assert refused(call).field == field, number


def steered(boundary: str, angle: str, links: int = 4, rate: str | None = None) -> Scene:
    """A rod whose thrust is turned, by a state z if its rate is given."""
    loads = {"follower": {"force": 3.0, "angle": angle}}
    return rod(links, boundary, loads, states={"z": {"rate": rate}} if rate else {})


BELOW = CYCLING.replace({"loads.follower.force": 5.0, "initial.phi": 0.0})  # it does not flutter
# Scenes are all right, but have not what is to be found.
NOTHING: list[Callable[[], object]] = [
    lambda: natural_modes(rod(4, "free", {"tip": {"y": 1.0}})),  # it turns, and is not steady
    lambda: natural_modes(steered("free", "0.1 + phi(0.3)")),
    lambda: natural_modes(steered("free", "z", rate="1 + z**2")),  # it rises for ever
    lambda: static_equilibrium(rod(4, "pinned")),  # it points anywhere
    # A follower force across the tail winds the chain without stiffness up for ever.
    lambda: static_equilibrium(
        rod(3, "clamped", {"follower": {"force": 1.0, "angle": 1.5}}, bending_stiffness=0.0)
    ),
    lambda: find_cycle(BELOW),  # at rest
    lambda: find_cycle(BELOW, y0=[0.3, 0.1, 0.1, 0, 0, 0], period=1.0),  # it comes to rest
]
MORE: list[Callable[[], object]] = [
    lambda: thrust_frequencies(110, 1),  # it flutters from 109.9 on
    lambda: natural_modes(rod(4, "free", {"follower": {"force": 5.0, "angle": 0.1}})),
    # External damping has no linear part about a bent state.
    lambda: natural_modes(
        rod(4, "clamped", {"gravity": {}, "external_damping": {"coefficient": 0.3}})
    ),
    # A foundation holds across itself alone.
    lambda: static_equilibrium(rod(2, "free", {"tip": {"x": 1.0}}, foundation={"stiffness": 50.0})),
    lambda: static_equilibrium(steered("clamped", "0.1*z", 1, "1 + z**2")),
]


@pytest.mark.parametrize("calls", sets([NOTHING], slow=[MORE]), ids=["few", "more"])
def test_what_has_no_answer(calls: list[Callable[[], object]]) -> None:
    for call in calls:
        with pytest.raises(AnalysisError):
            call()
