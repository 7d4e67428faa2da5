"""Critical follower forces: against 50 digits, the continuum, simulations, closed forms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from rodgen.analyse.critical import critical_load
from rodgen.analyse.extrapolation import richardson
from rodgen.analyse.modes import natural_modes
from rodgen.analyse.references.follower_columns import FlutterPoint, beck, hauger, leipholz, thrust
from rodgen.analyse.simulated_critical import simulated_critical_load
from rodgen.errors import AnalysisError
from rodgen.scene import Scene
from tests.analyse.rods import ONES, SIZES, THRUST, exact_rates, rod
from tests.sets import sets


@pytest.mark.parametrize(
    ("links", "boundary", "tail", "kind"),
    # A pinned rod's turning, damped from outside, begins to grow before it buckles.
    sets([], slow=[(3, "pinned", 3.0, "divergence")], nightly=[(4, "free", 1.0, "flutter")]),
)
def test_onset_with_drag_to_nine_digits(links: int, boundary: str, tail: float, kind: str) -> None:
    fins = [1.0] * links + [tail]
    drag = {"external_damping": {"coefficient": 0.4, "fin_factor": fins}}
    found = critical_load(rod(links, boundary, THRUST | drag))
    assert found.kind == kind

    def growth(share: float) -> Any:
        """Of the motion that is next to that of the onset, at a share of its force."""
        loads = drag | {"follower": {"force": share * found.value}}
        target = 2j * np.pi * found.frequency
        return min(exact_rates(rod(links, boundary, loads)), key=lambda s: abs(s - target)).real

    assert growth(1 - 1e-9) < 0 < growth(1 + 1e-9)
    assert growth(0.7) < 0


def test_a_viscous_medium_is_a_foundation_of_dampers() -> None:
    """To first order, where the rod moves across its axis alone: without doubts, as it is smooth at
    rest. That along the rod does nothing then."""
    c = 3.0
    medium = {"viscous_drag": {"normal": c, "tangential": 0.5 * c}}
    found = critical_load(rod(10, "clamped", THRUST | medium, **ONES))
    bed = {"stiffness": 0.0, "damping": c}
    expected = critical_load(rod(10, "clamped", THRUST, **ONES, foundation=bed))
    assert found.kind == expected.kind == "flutter"
    assert found.value == pytest.approx(expected.value, rel=1e-12)
    assert not found.notes


@pytest.mark.slow
def test_damping_that_vanishes() -> None:
    """A free rod, of which nothing holds the place: what rounding makes of its translations is no
    motion that grows. A table of damping that is zero changes nothing; the limit of ever weaker
    damping, which is another force, is reached."""

    def force(**damping: float) -> float:
        loads = {f"{name}_damping": {"coefficient": value} for name, value in damping.items()}
        found = critical_load(rod(5, "free", THRUST | loads))
        assert found.kind == "flutter"
        return found.value

    bare = force()
    assert force(external=0.0) == pytest.approx(bare, rel=1e-9)
    assert force(external=0.0, internal=0.0) == pytest.approx(bare, rel=1e-9)
    weak = [force(external=coefficient) for coefficient in (1e-12, 1e-9, 1e-6)]
    assert weak == pytest.approx([weak[0]] * 3, rel=1e-9)
    assert weak[0] < bare * (1 - 1e-4)


@pytest.mark.parametrize(("name", "exact"), sets([("clamped", beck)], slow=[("free", thrust)]))
def test_extrapolated_it_is_that_of_the_continuum(
    name: str, exact: Callable[[], FlutterPoint]
) -> None:
    n = [5, 10, 20, 40]
    found = [critical_load(rod(k, name, THRUST)) for k in n]
    assert {(one.kind, one.modes) for one in found} == {("flutter", (1, 2))}
    force, hertz = exact().dimensional(**SIZES)
    for values, limit in (("value", force), ("frequency", hertz)):
        limits = richardson(n, [getattr(one, values) for one in found], order=[2, 4, 6])
        # What is left is of order n^-8, at n = 40.
        assert limits.value == pytest.approx(limit, rel=1e-5)


@pytest.mark.slow
def test_a_thousand_links() -> None:
    """The lowest modes alone are looked at; the error, which falls with n^2, is 3.3e-6."""
    found = critical_load(rod(1000, "clamped", THRUST))
    assert not found.complete
    assert found.load_parameter == pytest.approx(beck().load, rel=5e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "exact", "second"),
    # Leipholz's to the digits that a power series of his equation gives elsewhere.
    [
        ("leipholz", 40.05373651493959869, leipholz),
        pytest.param("hauger", None, hauger, marks=pytest.mark.nightly),
    ],
)
def test_columns_of_distributed_thrust(
    name: str, exact: float | None, second: Callable[[], FlutterPoint]
) -> None:
    """The whole force at flutter, from the scene of that name with 12 to 48 links."""
    scene, n, known = Scene.example(name), [12, 16, 24, 32, 48], second()
    found = [critical_load(scene.with_links(k), load="distributed_follower") for k in n]
    assert {(one.kind, one.unit) for one in found} == {("flutter", "N")}
    limit = richardson(n, [one.load_parameter for one in found], order=[2, 4, 6, 8])
    assert limit.value == pytest.approx(known.load, rel=1e-9)
    assert exact is None or known.load == pytest.approx(exact, rel=1e-15)
    sizes = {"length": scene.rod.length, "mass": scene.rod.mass}
    frequency = known.dimensional(bending_stiffness=scene.rod.bending_stiffness, **sizes)[1]
    hertz = richardson(n, [one.frequency for one in found], order=[2, 4, 6, 8])
    assert hertz.value == pytest.approx(frequency, rel=1e-9)


def test_a_pinned_rod_buckles_as_one_pinned_and_clamped() -> None:
    """u'' + p u = 0 for the slope, as for a column clamped at one end: tan sqrt(p) = sqrt(p)."""
    n = [5, 10, 20]
    found = [critical_load(rod(k, "pinned", THRUST)) for k in n]
    assert {one.kind for one in found} == {"divergence"}
    p = mp.findroot(lambda x: mp.tan(x) - x, 4.49) ** 2
    limit = richardson(n, [one.load_parameter for one in found], order=[2, 4])
    # What is left is of order n^-6, at n = 20.
    assert limit.value == pytest.approx(float(p), rel=1e-6)


def test_a_single_motion_that_oscillates() -> None:
    """So strongly damped that the pair that flutters is of one mode."""
    loads = THRUST | {"internal_damping": {"coefficient": 10.0}}
    found = critical_load(rod(5, "free", loads, inertia="lumped"))
    assert (found.modes, found.kind) == ((1, 1), "flutter")


@pytest.mark.slow
def test_a_taut_pipe_needs_more_modes() -> None:
    """Hanging from its clamp, its weight a thousand times EI/L^2: the modes of the search are not
    those that flutter. Growth changes its sign there by all eigenvalues."""
    given = ONES | {"clamp_angle": -np.pi / 2}
    loads = {"gravity": {"g": 1000.0}, "internal_damping": {"coefficient": 0.5}}
    found = critical_load(rod(40, "clamped", THRUST | loads, **given))
    for factor, grows in ((1 - 1e-5, False), (1 + 1e-5, True)):
        at = {"follower": {"force": found.value * factor}} | loads
        modes = natural_modes(rod(40, "clamped", at, **given), 40)
        assert bool(modes.growth.max() > 0) is grows


ETA = 0.01  # of a Kelvin-Voigt material


@pytest.mark.parametrize(
    "damping",
    [
        {"internal_damping": {"coefficient": ETA * 5**2}},  # c_int m = eta k of 5 links
        {"material_damping": {"time": ETA}},
    ],
)
def test_a_damped_column_converges_with_second_order(damping: dict[str, Any]) -> None:
    """Beck's column of a Kelvin-Voigt material, moment EI (kappa + eta dkappa/dt): its continuum
    flutters from where Beck's determinant, with EI (1 + i eta w) for EI, vanishes for a real
    frequency w."""

    def determinant(P: mp.mpf, w: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
        stiffness = 1 + 1j * ETA * w
        p, k4 = P / stiffness, w**2 / stiffness
        root = mp.sqrt(p**2 / 4 + k4)
        a, b = mp.sqrt(root + p / 2), mp.sqrt(root - p / 2)
        shapes = 2 * k4 * (1 + mp.cos(a) * mp.cosh(b)) + p * a * b * mp.sin(a) * mp.sinh(b)
        value = p**2 + shapes
        return value.real, value.imag

    limit = float(mp.findroot(determinant, (11.0, 5.4))[0])
    assert limit == pytest.approx(10.9661117, abs=1e-7)
    coarse = rod(5, "clamped", THRUST | damping, **ONES)
    off = [limit - critical_load(coarse.with_links(n)).value for n in (5, 10, 20)]
    # Terms of fourth order are left: 1.935 and 1.984, nearer to 2 with every doubling.
    assert np.log2(off[0] / off[1]) == pytest.approx(2.0, abs=0.07)
    assert np.log2(off[1] / off[2]) == pytest.approx(2.0, abs=0.02)


def test_about_a_bent_state() -> None:
    """A follower force that pushes a little askew bends the rod before it flutters."""
    found = critical_load(rod(8, "clamped", {"follower": {"force": 1.0, "angle": 0.05}}))
    straight = critical_load(rod(8, "clamped", THRUST))
    assert found.kind == "flutter"
    assert found.state == "static equilibrium"
    assert found.value == pytest.approx(straight.value, rel=0.1)
    for factor, grows in ((1 - 1e-6, False), (1 + 1e-6, True)):
        at = {"follower": {"force": found.value * factor, "angle": 0.05}}
        assert bool(natural_modes(rod(8, "clamped", at), 8).growth.max() > 0) is grows


@pytest.mark.slow
def test_the_factor_of_a_tapered_rod_names_its_stiffness() -> None:
    """1/EI over a joint's cell has its integral in closed form, for EI = 3 (2 - s)."""
    found = critical_load(rod(3, "clamped", THRUST, bending_stiffness="3*(2 - s)"))
    cells = [(j - 0.5, j + 0.5) for j in (1, 2)]
    springs = [3 / np.log((2 - a / 3) / (2 - b / 3)) for a, b in cells]  # times the length
    assert found.stiffness == pytest.approx(np.mean(springs) / 3, rel=1e-9)
    unit = found.stiffness / found.scene.rod.length**2
    assert found.load_parameter == pytest.approx(found.value / unit, rel=1e-12)


@pytest.mark.slow
def test_simulations_find_it_too() -> None:
    """From the steady state of a rod that sags, not from the shape that its scene starts with."""
    sags = THRUST | {"gravity": {"g": 0.5}}
    scene = rod(3, "clamped", sags, initial={"phi": 0.3})
    told: list[tuple[float, bool]] = []
    found = simulated_critical_load(
        scene, span=60.0, tolerance=1e-3, progress=lambda force, grew: told.append((force, grew))
    )
    assert found.value == pytest.approx(critical_load(scene).value, rel=5e-3)
    assert len(told) == found.runs
    assert (found.high, True) in told


def test_what_is_not_found_is_said() -> None:
    with pytest.raises(AnalysisError, match=r"\b0\b.*\b40 N"):
        critical_load(rod(5, "clamped", THRUST), bounds=(None, 40.0))
    with pytest.raises(AnalysisError):  # it flutters from the start
        critical_load(rod(5, "clamped", THRUST), bounds=(85.0, 120.0))
    for damping in ({}, {"external_damping": {"coefficient": 1.0}}):
        with pytest.raises(AnalysisError):  # it does not bend
            critical_load(rod(1, "free", THRUST | damping))
    # A fixed step goes with the tolerances that simulations have by default.
    how: dict[str, Any] = {"span": 2.0, "bounds": (0.0, 10.0), "target": "numpy"}
    with pytest.raises(AnalysisError, match=r"\b2 s\b.*\b10\b"):
        simulated_critical_load(
            rod(3, "clamped", THRUST), method="semi_implicit_euler", step=0.01, **how
        )
    with pytest.raises(TypeError, match="'out'"):
        simulated_critical_load(rod(3, "clamped", THRUST), out="run.nc", **how)
