"""Critical follower forces: against 50 digits, the continuum, simulations, closed forms."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from rodgen.analyse.columns import beck, thrust
from rodgen.analyse.critical import critical_force
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.extrapolate import richardson
from rodgen.analyse.growth import simulated_critical_force
from rodgen.analyse.modes import natural_modes
from rodgen.scene import Scene, SceneError

Rod = Callable[..., Scene]
THRUST: dict[str, Any] = {"follower": {"force": 50.0}}
UNIT = 100.0 / 5.0**2  # EI/L^2


@pytest.mark.parametrize("inertia", ["uniform", "lumped"])
@pytest.mark.parametrize("boundary", ["free", "clamped", "cantilever"])
def test_flutter_to_nine_digits(rod: Rod, exact: Any, boundary: str, inertia: str) -> None:
    found = critical_force(rod(5, boundary, THRUST, inertia=inertia))
    model = exact(5, boundary, lumped=inertia == "lumped")

    def gap(P: Any) -> Any:
        """Squared difference of the two squared frequencies that are closest: it changes sign."""
        squares = model.squares(P)
        return min(((a - b) ** 2 for a, b in combinations(squares, 2)), key=abs).real

    near = mp.mpf(found.force)
    force = mp.findroot(gap, (near * (1 - mp.mpf(10) ** -6), near), tol=mp.mpf(10) ** -18)
    assert found.kind == "flutter"
    assert found.modes == (1, 2)
    assert found.force == pytest.approx(float(force), rel=1e-10)
    met = min(combinations(model.squares(force), 2), key=lambda pair: abs(pair[0] - pair[1]))
    assert found.frequency == pytest.approx(float(mp.sqrt(-met[0]).real / 2 / mp.pi), rel=1e-7)


@pytest.mark.parametrize("boundary", ["free", "clamped", "cantilever", "pinned"])
def test_nothing_grows_at_smaller_forces(rod: Rod, exact: Any, boundary: str) -> None:
    """A scan of all motions in 50 digits, which knows nothing of what was found."""
    model = exact(4, boundary)
    for P in range(0, 400, 4):
        squares = model.squares(mp.mpf(P))
        if any(v.real > 0 or abs(v.imag) > 1e-30 * abs(v) for v in squares):
            break
    found = critical_force(rod(4, boundary, THRUST))
    assert P - 4 <= found.force <= P


@pytest.mark.parametrize("boundary", ["free", "clamped"])
@pytest.mark.parametrize("external", [False, True])
def test_damped_flutter_to_nine_digits(rod: Rod, exact: Any, boundary: str, external: bool) -> None:
    name, value = ("external_damping", 0.4) if external else ("internal_damping", 0.3)
    found = critical_force(rod(5, boundary, THRUST | {name: {"coefficient": value}}))
    model = exact(5, boundary)
    C = model.external_damping(value, [1.0] * 6) if external else model.internal_damping(value)

    def growth(P: Any) -> Any:
        """Real part of the eigenvalue next to the imaginary axis that oscillates."""
        target = 2j * np.pi * found.frequency
        return min(model.rates(P, C), key=lambda s: abs(s - target)).real

    near = mp.mpf(found.force)
    force = mp.findroot(growth, (near * (1 - mp.mpf(10) ** -6), near), tol=mp.mpf(10) ** -30)
    assert found.force == pytest.approx(float(force), rel=1e-9)
    assert found.kind == "flutter"


@pytest.mark.parametrize("name", ["free", "clamped"])
def test_extrapolated_it_is_that_of_the_continuum(rod: Rod, name: str) -> None:
    n = [20, 40, 80, 160]
    found = [critical_force(rod(k, name, THRUST)) for k in n]
    exact = thrust() if name == "free" else beck()
    force, hertz = exact.dimensional(mass=50.0, length=5.0, bending_stiffness=100.0)
    limit = richardson(n, [one.force for one in found], order=[2, 4, 6])
    assert limit.value == pytest.approx(force, rel=1e-8)
    assert richardson(n, [one.frequency for one in found], order=[2, 4, 6]).value == pytest.approx(
        hertz, rel=1e-8
    )


@pytest.mark.parametrize(("n", "factor"), [(2, 32.0), (3, 54.0)])
def test_short_free_chains_diverge(rod: Rod, n: int, factor: float) -> None:
    """Whole numbers: the determinant of the stiffness of two or three links, by hand."""
    found = critical_force(rod(n, "free", THRUST))
    assert (found.kind, found.frequency, found.modes) == ("divergence", 0.0, (1, 1))
    assert found.factor == pytest.approx(factor, rel=1e-12)


def test_a_pinned_rod_buckles_as_one_pinned_and_clamped(rod: Rod) -> None:
    """u'' + p u = 0 for the slope, as for a column clamped at one end: tan sqrt(p) = sqrt(p)."""
    n = [20, 40, 80]
    found = [critical_force(rod(k, "pinned", THRUST)) for k in n]
    assert {one.kind for one in found} == {"divergence"}
    p = mp.findroot(lambda x: mp.tan(x) - x, 4.49) ** 2
    limit = richardson(n, [one.factor for one in found], order=[2, 4])
    assert limit.value == pytest.approx(float(p), rel=1e-7)


@pytest.mark.parametrize("tail", [1.0, 3.0])
def test_a_pinned_rod_turns_away_before_it_buckles(rod: Rod, exact: Any, tail: float) -> None:
    """Its turning, damped from outside, begins to grow: in 50 digits, scanned and refined."""
    fins = [1.0] * 6 + [tail]
    loads = THRUST | {"external_damping": {"coefficient": 0.1, "fin_factor": fins}}
    found = critical_force(rod(6, "pinned", loads))
    model = exact(6, "pinned")
    C = model.external_damping(0.1, fins)

    def growth(P: Any) -> Any:
        """The largest real rate, that which is always zero apart."""
        real = [s.real for s in model.rates(P, C) if abs(s.imag) < 1e-20 * (1 + abs(s))]
        return max((s for s in real if abs(s) > 1e-20), key=lambda s: s)

    low, high = (
        mp.mpf(found.force) * (1 - mp.mpf(10) ** -8),
        mp.mpf(found.force) * (1 + mp.mpf(10) ** -8),
    )
    assert growth(low) < 0 < growth(high)
    assert all(growth(mp.mpf(P)) < 0 for P in range(0, int(found.force), 8))
    assert (found.kind, found.frequency) == ("divergence", 0.0)


@pytest.mark.parametrize(
    ("links", "boundary", "loads"),
    [
        (5, "free", {"internal_damping": {"coefficient": 10.0}}),
        (
            2,
            "clamped",
            {"internal_damping": {"coefficient": 10.0}, "external_damping": {"coefficient": 30.0}},
        ),
    ],
)
def test_a_single_motion_that_oscillates(
    rod: Rod, links: int, boundary: str, loads: dict[str, Any]
) -> None:
    found = critical_force(rod(links, boundary, THRUST | loads, inertia="lumped"))
    assert found.modes == (1, 1)
    assert found.kind == "flutter"


def test_a_taut_pipe_needs_more_modes(rod: Rod) -> None:
    """Hanging from its clamp, its weight a thousand times EI/L^2: the modes of the search are not
    those that flutter. Growth changes its sign there by all eigenvalues."""
    given = {"mass": 1.0, "length": 1.0, "bending_stiffness": 1.0, "clamp_angle": -np.pi / 2}
    loads = {"gravity": {"g": 1000.0}, "internal_damping": {"coefficient": 0.5}}
    found = critical_force(rod(40, "clamped", THRUST | loads, **given))
    for factor, grows in ((1 - 1e-5, False), (1 + 1e-5, True)):
        at = {"follower": {"force": found.force * factor}} | loads
        modes = natural_modes(rod(40, "clamped", at, **given), 40)
        assert bool(modes.growth.max() > 0) is grows


def test_a_damped_column_converges_with_second_order(rod: Rod) -> None:
    """Beck's column of a Kelvin-Voigt material, moment EI (kappa + eta dkappa/dt): its continuum
    flutters from where Beck's determinant, with EI (1 + i eta w) for EI, vanishes for a real
    frequency w."""
    eta, given = 0.01, {"mass": 1.0, "length": 1.0, "bending_stiffness": 1.0}

    def determinant(P: mp.mpf, w: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
        stiffness = 1 + 1j * eta * w
        p, k4 = P / stiffness, w**2 / stiffness
        root = mp.sqrt(p**2 / 4 + k4)
        a, b = mp.sqrt(root + p / 2), mp.sqrt(root - p / 2)
        shapes = 2 * k4 * (1 + mp.cos(a) * mp.cosh(b)) + p * a * b * mp.sin(a) * mp.sinh(b)
        value = p**2 + shapes
        return value.real, value.imag

    limit = float(mp.findroot(determinant, (11.0, 5.4))[0])
    assert limit == pytest.approx(10.9661117, abs=1e-7)
    damping = {"internal_damping": {"coefficient": eta * 5**2}}  # c_int m = eta k
    coarse = rod(5, "clamped", THRUST | damping, **given)
    off = [limit - critical_force(coarse.with_links(n)).force for n in (5, 10, 20)]
    # Terms of fourth order are left: 1.935 and 1.984, nearer to 2 with every doubling.
    assert np.log2(off[0] / off[1]) == pytest.approx(2.0, abs=0.07)
    assert np.log2(off[1] / off[2]) == pytest.approx(2.0, abs=0.02)


def test_zieglers_paradox(rod: Rod) -> None:
    """However little there is of internal damping, it lowers the force by a finite share."""
    bare = critical_force(rod(10, "clamped", THRUST)).force
    forces = [
        critical_force(rod(10, "clamped", THRUST | {"internal_damping": {"coefficient": c}})).force
        for c in (1e-3, 1e-6)
    ]
    assert forces[0] < 0.6 * bare
    assert forces[0] == pytest.approx(forces[1], rel=1e-4)


def test_growth_begins_there(rod: Rod) -> None:
    for loads in ({}, {"internal_damping": {"coefficient": 0.1}}):
        force = critical_force(rod(12, "free", THRUST | loads)).force
        for factor, grows in ((1 - 1e-6, False), (1 + 1e-6, True)):
            at = {"follower": {"force": force * factor}} | loads
            growth = natural_modes(rod(12, "free", at), 12).growth.max()
            assert bool(growth > 0) is grows


def test_overdamped_it_is_a_matter_of_the_slow_motions(rod: Rod) -> None:
    """With a damping that leaves no inertia, the force no longer depends on it."""
    forces = [
        critical_force(rod(12, "free", THRUST | {"internal_damping": {"coefficient": c}})).force
        for c in (1e5, 1e6)
    ]
    assert forces[0] == pytest.approx(forces[1], rel=1e-4)


def test_about_a_bent_state(rod: Rod) -> None:
    """A follower force that pushes a little askew bends the rod before it flutters."""
    found = critical_force(rod(8, "clamped", {"follower": {"force": 1.0, "angle": 0.05}}))
    straight = critical_force(rod(8, "clamped", THRUST))
    assert found.kind == "flutter"
    assert found.state == "static equilibrium"
    assert found.force == pytest.approx(straight.force, rel=0.1)
    for factor, grows in ((1 - 1e-6, False), (1 + 1e-6, True)):
        at = {"follower": {"force": found.force * factor, "angle": 0.05}}
        assert bool(natural_modes(rod(8, "clamped", at), 8).growth.max() > 0) is grows


def test_a_thousand_links(rod: Rod) -> None:
    found = critical_force(rod(1000, "clamped", THRUST))
    assert not found.complete
    # The error of 1000 links is 3.3e-6 (it falls with n^2); digits beyond that are not asked for.
    assert found.factor == pytest.approx(beck().load, rel=5e-6)


def test_simulations_find_it_too(rod: Rod) -> None:
    scene = rod(5, "free", THRUST)
    found = simulated_critical_force(scene, span=100.0, tolerance=1e-3)
    exact = critical_force(scene).force
    # Growth in 100 s asks for a rate of ln(100)/100 1/s, which a surplus of 1e-3 brings.
    assert found.low * (1 - 1e-3) <= exact <= found.high
    assert found.high == pytest.approx(exact, rel=5e-3)


def test_simulations_start_from_the_steady_state(rod: Rod) -> None:
    """A rod that sags is not one that grows; the shape that a scene starts with does not count."""
    table = rod(6, "clamped", THRUST | {"gravity": {"g": 0.5}}).model_dump(exclude_none=True)
    table["initial"] = {"phi": 0.3}
    scene = Scene.from_dict(table)
    told: list[tuple[float, bool]] = []
    found = simulated_critical_force(
        scene, span=60.0, tolerance=1e-3, progress=lambda force, grew: told.append((force, grew))
    )
    assert found.force == pytest.approx(critical_force(scene).force, rel=5e-3)
    assert len(told) == found.runs
    assert (found.high, True) in told


def test_what_is_not_found_is_said(rod: Rod) -> None:
    with pytest.raises(AnalysisError, match=r"neither flutter nor divergence between 0 and 40 N"):
        critical_force(rod(6, "clamped", THRUST), highest=40.0)
    with pytest.raises(AnalysisError, match="unstable already at the lowest force"):
        critical_force(rod(6, "clamped", THRUST), lowest=85.0, highest=120.0)
    with pytest.raises(AnalysisError, match=r"no motion grows 1\.01 times within 5 s up to 10"):
        simulated_critical_force(rod(3, "clamped", THRUST), span=5.0, high=10.0)


@pytest.mark.parametrize(
    ("loads", "options", "field"),
    [
        ({}, {}, "loads.follower"),
        (THRUST, {"lowest": 10.0, "highest": 5.0}, "highest"),
        (THRUST, {"highest": np.nan}, "highest"),
    ],
)
def test_bad_input(rod: Rod, loads: dict[str, Any], options: dict[str, Any], field: str) -> None:
    with pytest.raises(SceneError, match=field):
        critical_force(rod(4, "free", loads), **options)
    with pytest.raises(SceneError, match="bending_stiffness"):
        critical_force(rod(4, "free", THRUST, bending_stiffness=0.0))


def test_settings_of_simulations(rod: Rod) -> None:
    """A fixed step goes with the tolerances that simulations have by default; what is given has to
    be of use, and no other argument of a run is one of its settings."""
    scene = rod(3, "clamped", THRUST)
    how: dict[str, Any] = {"span": 2.0, "high": 10.0, "target": "numpy"}
    with pytest.raises(AnalysisError, match="no motion grows"):
        simulated_critical_force(scene, method="semi_implicit_euler", step=0.01, **how)
    with pytest.raises(SceneError, match=r"step = 0\.01: must be absent: auto chooses its own"):
        simulated_critical_force(scene, step=0.01, **how)
    with pytest.raises(SceneError, match=r"rtol = 0\.001: must be absent: rk4 has a fixed step"):
        simulated_critical_force(scene, method="rk4", step=0.01, rtol=1e-3, **how)
    with pytest.raises(SceneError, match=r"integrate\.out = "):
        simulated_critical_force(scene, out="run.nc", **how)
