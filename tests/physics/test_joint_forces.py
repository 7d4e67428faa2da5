"""Forces and curvature in the joints: weights that hang below, the symmetry of an arch, balances of
moments and of momentum, and the equations that they solve."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from rodgen.integrate.constraint_forces import forces_per_mass
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.model.quantities import QUANTITIES
from rodgen.model.rod import BOUNDARIES, INERTIAS
from tests.palette import ALONG, ENDS
from tests.sets import Make, sets

# Loads that change with time are among either half.
RODS = pytest.mark.parametrize(
    ("boundary", "inertia", "terms"),
    sets(
        [("free", "uniform", ENDS), ("cantilever", "lumped", ENDS)],
        slow=[("clamped", "lumped", ENDS), ("pinned", "lumped", ENDS)],
        nightly=product(BOUNDARIES, INERTIAS, (ENDS, ALONG)),
    ),
)
LINKS = 3


def piece_of(scene: Scene, y: np.ndarray | None = None, t: float = 0.3) -> MotionSlice:
    model = rodgen.build(scene, "numpy")
    p = model.parameters(**scene.parameters)
    return MotionSlice(model, p, scene.initial_state() if y is None else y, np.array(t))


@pytest.mark.parametrize("inertia", sets(["uniform"], slow=["lumped"]))
def test_a_chain_that_hangs_carries_what_is_below(make_scene: Make, inertia: str) -> None:
    down = {"phi": -np.pi / 2, "omega": 0.0}
    scene = make_scene(LINKS, "pinned", ("gravity",), {"inertia": inertia}, down)
    piece = piece_of(scene)
    weight = scene.rod.mass * 9.81
    below = weight * np.arange(LINKS, 0, -1) / LINKS
    np.testing.assert_allclose(piece.values("axial_force"), below, rtol=1e-12)
    np.testing.assert_allclose(piece.values("shear_force"), 0.0, atol=1e-12 * weight)
    np.testing.assert_allclose(piece.values("reaction"), [0.0, weight], atol=1e-12 * weight)


@pytest.mark.parametrize("inertia", ["uniform", "lumped"])
def test_no_shear_in_the_middle_of_an_arch_that_folds(make_scene: Make, inertia: str) -> None:
    """Half the arch pushes the other, of which it is the mirror image, along the line that both
    lie even to, whatever the angles of their links."""
    start = {"phi": [0.7, -0.7], "omega": [2.0, -2.0]}
    piece = piece_of(make_scene(2, "free", (), {"inertia": inertia}, start))
    (axial,), (shear,) = piece.values("axial_force"), piece.values("shear_force")
    assert abs(axial) > 1.0
    assert shear == pytest.approx(0.0, abs=1e-12 * abs(axial))


def test_a_circle_has_one_curvature_from_the_root_on(make_scene: Make) -> None:
    """Links that are chords of a circle turn by the angle of one from each to the next, and by half
    of it from the tangent in the clamp to the first."""
    length, curvature, clamp = 2.0, -0.8, 0.3
    turns = clamp + curvature * length / LINKS * (np.arange(LINKS) + 0.5)
    rod = {"clamp_angle": clamp, "length": length}
    piece = piece_of(make_scene(LINKS, "clamped", (), rod, {"phi": turns.tolist(), "omega": 0.0}))
    np.testing.assert_allclose(piece.values("curvature"), curvature, rtol=1e-12)


@RODS
def test_momenta_grow_by_loads_and_reaction(
    make_scene: Make, boundary: str, inertia: str, terms: tuple[str, ...]
) -> None:
    """Newton's and Euler's laws for the whole rod: what momenta gain along the motion is what all
    forces, and their moments about the same point, do to it; with dampers in the clamp."""
    scene = make_scene(LINKS, boundary, terms, {"inertia": inertia})
    rng = np.random.default_rng(5)
    at_start = scene.initial_state()
    piece = piece_of(scene, at_start + 0.3 * rng.standard_normal(len(at_start)))
    y, h = piece.y, 1e-6
    rates = piece.model.rhs(0.3, y, piece.p)
    sides = [MotionSlice(piece.model, piece.p, y + way * h * rates) for way in (1, -1)]
    gained, turned = (
        (sides[0].values(name) - sides[1].values(name)) / (2 * h)
        for name in ("momentum", "angular_momentum")
    )
    joints, first = piece.values("joints"), scene.boundary_condition.first
    free = boundary == "free"
    about = piece.values("centre_of_gravity") if free else joints[first]
    # What acts on a joint that does not move is borne by what holds it.
    loads = sum(piece.values("forces").values())[0 if free else first + 1 :]
    arms = joints[0 if free else first + 1 :] - about
    middles = (joints[first:-1] + joints[first + 1 :]) / 2 - about
    weight = -9.81 * scene.rod.mass / LINKS * ("gravity" in terms)
    forces = loads.sum(axis=0) + np.array([0.0, weight * len(middles)])
    moment = np.sum(arms[:, 0] * loads[:, 1] - arms[:, 1] * loads[:, 0])
    moment += weight * middles[:, 0].sum()
    if not free:
        forces += piece.values("reaction")
        if hasattr(piece.model, "start_loads"):  # on the first link, at the joint that is held
            forces += piece.model.start_loads(0.3, y, piece.p)[0]
    moment += piece.values("reaction_moment") if boundary in ("clamped", "cantilever") else 0.0
    moment += piece.values("support_moment").sum() if "supports" in terms else 0.0
    moment += float(scene.parameters.get("moment_size", 0.0))
    # The difference has an error of h^2 and of eps/h.
    np.testing.assert_allclose(gained, forces, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(turned, moment, rtol=1e-7, atol=1e-7)


@pytest.mark.slow
def test_momenta_of_a_nonuniform_rod_are_those_of_its_energy() -> None:
    """With bodies beside the axis and mass that burns: kinetic energy is quadratic in the rates, so
    that what it gains by further rates, that carry all mass by 1 m/s or turn it about the centre by
    1 rad/s, is the momentum; a difference of any size is exact."""
    scene = Scene.example("sounding_rocket")
    piece = piece_of(scene, t=1.0)
    size = len(scene.initial_state()) // 2 - len(piece.extra_states) // 2
    rng = np.random.default_rng(6)
    y = piece.y + 0.1 * rng.standard_normal(len(piece.y))
    piece = piece_of(scene, y, t=1.0)
    turn = np.ones(size)
    out = piece.values("base") - piece.values("centre_of_gravity")
    turn[0], turn[1] = -out[1], out[0]
    found = []
    for further in (*np.eye(2, size), turn):
        energies = []
        for way in (1, -1):
            other = y.copy()
            other[size : 2 * size] += way * further
            energies.append(piece_of(scene, other, t=1.0).values("kinetic_energy"))
        found.append((energies[0] - energies[1]) / 2)
    expected = [*piece.values("momentum"), piece.values("angular_momentum")]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.nightly
def test_of_a_nonuniform_rod_they_solve_the_equations() -> None:
    """Bodies, mass that burns, drag, wind, feedback: with the accelerations of `rhs` and these
    forces the equations of derivation 3 have no residual; and each state stands for itself."""
    scene = Scene.example("sounding_rocket")
    model = rodgen.build(scene, "numpy")
    p, y = model.parameters(**scene.parameters), scene.initial_state()
    rng = np.random.default_rng(4)
    states = y + 1e-2 * rng.standard_normal((3, len(y)))
    times = np.array([0.0, 1.0, 2.5])
    force = forces_per_mass(model, times, states, p)
    size = (len(y) - len(model.STATES)) // 2
    for t, state, f in zip(times, states, force, strict=True):
        alpha = model.rhs(t, state, p)[size + 2 : 2 * size]
        residual = model.implicit(t, state, p, alpha, f)[0]
        assert np.abs(residual).max() < 1e-9 * max(np.abs(alpha).max(), np.abs(f).max())
    broken = states.copy()
    broken[1] = np.nan
    np.testing.assert_array_equal(forces_per_mass(model, times, broken, p)[::2], force[::2])
    assert np.isnan(forces_per_mass(model, times, broken, p)[1]).all()


@pytest.mark.parametrize("boundary", sets(["free"], slow=["cantilever"]))
def test_forces_of_supports_by_hand(make_scene: Make, boundary: str) -> None:
    """Springs and dampers of a point inside a link, by differences of its place."""
    n, at, to, rotation, damping = 4, 0.85, [0.3, 0.2], 7.0, [1.5, 2.5]
    scene = make_scene(n, boundary, ("foundation", "supports"))
    fixed = {"to": to, "stiffness": [20.0, 30.0], "damping": damping}
    turning = {"rotation": rotation, "rotation_damping": 0.4}
    piece = piece_of(scene.replace({"supports": [{"at": at, **fixed, **turning}]}))
    model, p, y, h = piece.model, piece.p, piece.y, 1e-6
    along = np.concatenate((y[len(y) // 2 :], np.zeros(len(y) // 2)))  # the rates stay
    before, after = (MotionSlice(model, p, y + way * h * along) for way in (-1, 1))
    link, share = int(at * n), at * n - int(at * n)

    def place(one: MotionSlice) -> np.ndarray:
        start, end = one.values("joints")[link : link + 2]
        return start + share * (end - start)

    speed = (place(after) - place(before)) / (2 * h)
    force = np.array([-20.0, -30.0]) * (place(piece) - to) - damping * speed
    clamp = scene.rod.clamp_angle or 0.0
    moment = -rotation * (piece.values("phi")[link] - clamp) - 0.4 * piece.values("omega")[link]
    found, turned = piece.values("support_force"), piece.values("support_moment")
    # The difference has an error of h^2 and of eps/h.
    np.testing.assert_allclose(found[link], force, rtol=1e-8)
    np.testing.assert_allclose(turned[link], moment, rtol=1e-12)
    for whole in (found, turned):
        assert not np.delete(whole, link, axis=0).any()

    with pytest.raises(KeyError):
        piece_of(make_scene(LINKS, "pinned", ("gravity",))).values("support_force")


def test_what_a_boundary_does_not_have_is_refused(make_scene: Make) -> None:
    for boundary, name in (("free", "reaction"), ("pinned", "reaction_moment"), ("pinned", "base")):
        with pytest.raises(KeyError, match=name):
            piece_of(make_scene(LINKS, boundary)).values(name)


def test_points_and_forces_that_are_none_are_refused(make_scene: Make) -> None:
    piece, kick = piece_of(make_scene(LINKS, "free", ENDS)), [0.7, -1.9]
    for name, link, share, force in (
        *(("link", link, 0.5, kick) for link in (-1, 5, 1.0, True, "1")),
        *(("share", 0, share, kick) for share in (-0.01, 1.01, float("nan"), "half")),
        *(("force", 0, 0.5, force) for force in (3.0, [1.0, 2.0, 3.0], [1.0, float("inf")], "xy")),
    ):
        with pytest.raises(ValueError, match=rf"^{name}\b"):
            piece.model.generalised_force(piece.y, piece.p, link, share, force)


@pytest.mark.parametrize(
    ("inertia", "terms", "target"),
    sets(
        [("lumped", ENDS, "numpy")],
        slow=[("lumped", ALONG, "c")],
        nightly=[("uniform", ALONG, "numpy")],
    ),
)
def test_quantities_of_a_sample_are_those_of_its_state_at_its_time(
    make_scene: Make, inertia: str, terms: tuple[str, ...], target: str
) -> None:
    """Whatever samples are beside it, and however many axes they have: loads change in time."""
    scene = make_scene(LINKS, "cantilever", terms, {"inertia": inertia})
    sol = rodgen.simulate(scene, target=target, rtol=1e-4, span=[0.0, 1.0], output_every=0.2)
    p = sol.model.parameters(**scene.parameters)
    folded = MotionSlice(
        sol.model,
        p,
        sol.y.reshape(2, 3, -1),
        sol.t.reshape(2, 3),
        timed=scene.time_dependent_loads,
    )
    single = [
        MotionSlice(sol.model, p, y, t, timed=scene.time_dependent_loads)
        for y, t in zip(sol.y, sol.t, strict=True)
    ]
    names = {
        row.name
        for row in QUANTITIES
        if not row.only or getattr(scene.boundary_condition, row.only)
    }
    names = {name for name in names if "{" not in name} - {"energy_balance"}  # which a run has
    names -= set() if "supports" in terms else {"support_force", "support_moment"}
    names |= {f"force_{term}" for term in sol.forces} | {f"power_{term}" for term in sol.work}
    for name in names:
        expected = np.array([one.values(name) for one in single])
        close = {"rtol": 1e-9, "atol": 1e-9, "err_msg": name}  # other orders of sums
        np.testing.assert_allclose(sol.values(name), expected, **close)
        np.testing.assert_allclose(np.concatenate(folded.values(name)), expected, **close)
