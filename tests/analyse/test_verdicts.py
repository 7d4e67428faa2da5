"""What grows, and from which load on, of random rods with feedback, damping, springs and all ways
in which an end can be held: against the eigenvalues of the Jacobian of the module."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.branches.deflation import static_equilibria
from rodgen.analyse.statics import static_equilibrium
from rodgen.errors import AnalysisError
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.scene import Scene
from tests.analyse.rods import FORCE, ONES, jacobian, rod
from tests.sets import sets

HIGHEST = 60.0  # EI/L^2
NOTHING = 1e-5  # 1/s: roundings of zeros of the whole rod, of which up to four meet
SLIGHT = 2.0**-100  # m/s, at which external damping is linear across the rod


def random_rod(seed: int) -> Scene:
    """One that stays straight under thrust; its number decides how its end is held and what steers
    the thrust."""
    rng = np.random.default_rng(seed)

    def size(low: float, high: float) -> float:
        return float(10 ** rng.uniform(np.log10(low), np.log10(high)))

    boundary = list(BOUNDARIES)[seed % len(BOUNDARIES)]
    gain, at = float(rng.choice([-1, 1])) * size(1e-3, 0.5), round(float(rng.random()), 2)
    steers = {"angle": f"{gain!r}*omega({at})"}, {"angle": f"{gain!r}*phi({at})"}
    steers += ({"angle": "gimbal"}, {"angle": f"{gain!r}*(omega({at}) + phi(0.5))"}, {})
    steer = steers[seed // len(BOUNDARIES) % len(steers)]
    tables: dict[str, Any] = {}
    if "gimbal" in steer.values():
        tables["states"] = {"gimbal": {"rate": f"20*({gain!r}*omega({at}) - gimbal)"}}
    loads: dict[str, Any] = {"follower": {"force": 1.0} | steer}
    if rng.random() < 0.6:
        loads["material_damping"] = {"time": size(1e-4, 0.1)}
    if rng.random() < 0.3:
        loads["external_damping"] = {"coefficient": size(1e-2, 10)}
    if rng.random() < 0.3 and boundary != "free":
        spring = {"stiffness": [0.0, size(1, 50)], "damping": [0.0, size(0.01, 1)]}
        tables["supports"] = [{"at": 1.0} | spring]
    if rng.random() < 0.2:
        tables["foundation"] = {"stiffness": size(1, 50), "damping": size(1e-3, 1)}
    inertia, links = str(rng.choice(list(INERTIAS))), int(rng.integers(2, 5))
    return rod(links, boundary, loads, inertia=inertia, **ONES, **tables)


def growth(scene: Scene, force: float) -> float:
    """Of what grows most about the straight rod [1/s]."""
    scene = scene.replace({FORCE: force})
    y = np.zeros(len(scene.initial_state()))
    half, free = (len(y) - len(scene.states)) // 2, scene.boundary_condition.translates
    moving, J = y.copy(), jacobian(scene, y).copy()
    moving[half + free : half + 2 if free else 2 * half] = SLIGHT
    J[:, half : 2 * half] = jacobian(scene, moving)[:, half : 2 * half]
    # Along the rod external damping has no linear part.
    kept = np.setdiff1d(np.arange(len(y)), [0, half] if free else [])
    return float(np.linalg.eigvals(J[np.ix_(kept, kept)]).real.max())


@pytest.mark.parametrize("seed", sets(range(10), slow=range(10, 40), nightly=range(40, 160)))
def test_the_critical_load_is_where_a_motion_begins_to_grow(seed: int) -> None:
    scene = random_rod(seed)
    loads = np.linspace(0.0, HIGHEST, 31)
    grows = np.array([growth(scene, load) > NOTHING for load in loads])
    if grows[0] or not grows.any():
        with pytest.raises(AnalysisError):
            rodgen.critical_load(scene, bounds=(None, HIGHEST))
        return
    found = rodgen.critical_load(scene, bounds=(None, HIGHEST))
    assert found.value <= loads[np.argmax(grows)] * (1 + 1e-9)
    assert not grows[loads < found.value * (1 - 1e-9)].any()
    beside = [growth(scene, found.value * (1 + way) + 10 * way) for way in (-1e-4, 1e-4)]
    assert beside[1] > max(beside[0], 0.0) or found.value == 0.0
    assert growth(scene, found.value + 1e-2) > 0


def test_modes_of_a_thrust_that_follows_the_motion_of_a_joint() -> None:
    """Whatever the thrust is, also none: the same numbers count."""
    for angle in ("0.2*phi(0) - 0.1*vy(1)", "-0.1*vy(1)"):
        scene = rod(3, "free", {"follower": {"force": 1.0, "angle": angle}}, **ONES)
        found = rodgen.critical_load(scene, bounds=(None, HIGHEST))
        assert growth(scene, found.value + 1e-2) > NOTHING
        assert found.value == 0.0 or growth(scene, 0.99 * found.value) < NOTHING


@pytest.mark.parametrize(("tau", "force", "kind"), [(0.005, 15.0, "flutter"), (0.005, 9.9, "")])
def test_damping_makes_a_rest_unstable(tau: float, force: float, kind: str) -> None:
    """The column flutters from 10.04 EI/L^2 on with that damping, from 20 without."""
    loads = {"follower": {"force": force}, "material_damping": {"time": tau}}
    found = static_equilibrium(rod(5, "clamped", loads, **ONES))
    assert found.instability == kind
    assert (growth(rod(5, "clamped", loads, **ONES), force) > 0) is bool(kind)


def test_a_bent_rod_with_external_damping_is_judged_by_what_is_known() -> None:
    """Without it: a weight leaves nothing open, thrust does; also where a motion flutters without
    that damping, which may heal it."""
    damped = {"external_damping": {"coefficient": 0.1}, "gravity": {"g": 1.0}}
    for thrust, known in ((None, True), (1.0, None), (40.0, None)):
        loads = damped | ({} if thrust is None else {"follower": {"force": thrust}})
        assert static_equilibrium(rod(3, "clamped", loads, **ONES)).stable is known


BLOWN: dict[str, Any] = {"drag": {"normal": 1.0, "tangential": 0.0}}


def in_the_wind(x: float, y: float, **more: Any) -> Scene:
    loads = {"drag": BLOWN["drag"] | {"wind": [x, y]}, "material_damping": {"time": 0.05}}
    return rod(2, "clamped", loads, **ONES, **more)


@pytest.mark.parametrize("wind", [(-3.0, 1.0), (0.0, 10.0)])
def test_in_a_wind_a_rod_rests_where_a_run_comes_to_rest(wind: tuple[float, float]) -> None:
    found = static_equilibrium(in_the_wind(*wind))
    run = rodgen.simulate(in_the_wind(*wind, integrate={"span": [0.0, 60.0]}), target="numpy")
    np.testing.assert_allclose(found.phi, run.phi[-1], atol=1e-8)
    assert found.stable


@pytest.mark.slow
def test_a_branch_that_turns_back_in_the_wind_leads_nowhere() -> None:
    """At 0.142 of the drag; the state in which a run rests is on another branch."""
    scene = in_the_wind(-10.0, 1.0)
    with pytest.raises(AnalysisError, match=r"0\.142\d+ .* turns back"):
        static_equilibrium(scene)
    run = rodgen.simulate(scene.with_integrate(span=[0.0, 60.0]), target="numpy")
    resting = [one for one in static_equilibria(scene) if one.stable]
    assert min(np.abs(one.phi - run.phi[-1]).max() for one in resting) < 1e-8
