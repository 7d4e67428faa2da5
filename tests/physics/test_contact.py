"""Stops, walls and friction in runs: against exact solutions, programs by hand, and the balance."""

from __future__ import annotations

import math
import re
from functools import cache
from itertools import count
from typing import Any

import mpmath as mp
import numpy as np
import pytest
import scipy

import rodgen
from rodgen.arrays import Array
from rodgen.integrate.events import EventDetector
from rodgen.integrate.stepper import BounceError
from rodgen.scene import Scene
from rodgen.scene.model_contents import model_parts

G = 9.81
LINK = {"links": 1, "length": 0.4, "bending_stiffness": 1.0, "mass": 2.0}
TARGETS = ["numpy", pytest.param("c", marks=pytest.mark.compiler)]


def touches(sol: rodgen.Solution, what: str = "touches") -> list[float]:
    """Times at which something touches [s]."""
    return [event.t for event in sol.events if what in event.name]


# Between two stops --------------------------------------------------------------------------------


def bouncing_link(law: dict[str, float], **integrate: Any) -> Scene:
    """A free link of 2 kg that flies at 1 m/s between two stops for its middle, 0.1 m away."""
    stop = {"at": 0.5, "gap": 0.1, **law}
    return Scene.from_dict(
        {
            "name": "bouncing",
            "rod": LINK | {"inertia": "lumped"},
            "stops": [{"direction": "pi/2", **stop}, {"direction": "-pi/2", **stop}],
            "initial": {"velocity": [0.0, 1.0]},
            "integrate": {"span": [0.0, 7.0], "rtol": 1e-12, "atol": 1e-14, "method": "dop853"}
            | integrate,
        }
    )


@cache
def exact_touches(k: float, e: float, c: float, count: int) -> list[float]:
    """Times of touching by the one equation m v dv/dd = -k d^e (1 + c v), in 30 digits: while it
    touches H(v) + k d^(e+1)/(e+1) is kept, H the integral of m w/(1 + c w) from 0 to v."""
    with mp.workdps(30):
        m, gap, v = mp.mpf(2), mp.mpf("0.1"), mp.mpf(1)
        k, e, c = map(mp.mpf, (str(k), str(e), str(c)))

        def kept(w: Any) -> Any:
            return m * (w / c - mp.log(1 + c * w) / c**2) if c else m * w * w / 2

        times, t = [], gap / v
        for _ in range(count):
            times.append(t)
            whole, v_in = kept(v), v
            left = mp.findroot(lambda w, whole=whole: kept(-w) - whole, v * (1 - c * v / 2))

            def slowness(w: Any, whole: Any = whole) -> Any:
                depth = abs((e + 1) / k * (whole - kept(w))) ** (1 / (e + 1))
                return m / (k * depth**e * (1 + c * w))

            t += mp.quad(slowness, [-left, -left / 2, 0, v_in / 2, v_in]) + 2 * gap / left
            v = left
        return [float(one) for one in times]


@pytest.mark.parametrize("target", TARGETS)
def test_times_of_ten_touches(target: str) -> None:
    """Found to the last digit: 1e-10 is what the tolerance of some thousand steps leaves."""
    for law in ({"stiffness": 1e3, "exponent": 1.5, "damping": 0.3}, {"stiffness": 2e3}):
        count = 10 if target == "c" else 3
        sol = rodgen.simulate(bouncing_link(law, span=[0.0, 0.7 * count]), target=target)
        found = touches(sol)[:count]
        usual = {"stiffness": 0.0, "exponent": 1.0, "damping": 0.0}
        exact = exact_touches(*(usual | law).values(), 10)
        np.testing.assert_allclose(found, exact[: len(found)], rtol=0, atol=1e-10)
        assert len(found) == count
        names = [event.name for event in sol.events][:4]
        assert names == ["stop touches", "stop leaves", "stop 2 touches", "stop 2 leaves"]
        # Of a kinetic energy of 1 J.
        assert sol.energy_error < 1e-9


def test_methods_of_equal_steps_record_touches_too() -> None:
    law = {"stiffness": 2e3}
    sol = rodgen.simulate(
        bouncing_link(law, method="rk4", step=1e-3, span=[0.0, 1.0]), progress=False
    )
    half = math.pi * math.sqrt(2.0 / 2e3)
    np.testing.assert_allclose(touches(sol)[:2], [0.1, 0.3 + half], atol=1e-5)


def test_files_keep_touches(tmp_path: Any) -> None:
    sol = rodgen.simulate(bouncing_link({"stiffness": 1e3}, span=[0.0, 1.0]), progress=False)
    sol.save(tmp_path / "run.nc")
    again = rodgen.load(tmp_path / "run.nc")
    assert [(e.name, e.t) for e in again.events] == [(e.name, e.t) for e in sol.events]
    np.testing.assert_array_equal(again.values("push_stop"), sol.values("push_stop"))


def test_pushes_are_watched_and_stop_a_run() -> None:
    """The stop has pushed with 100 N where its spring is pressed by 0.05 m."""
    event = {"quantity": "push_stop", "value": 100.0, "action": "stop", "name": "hard"}
    scene = bouncing_link({"stiffness": 2e3}).replace({"events": [event]})
    # At 1 m/s it is pressed by v sqrt(m/k) = 0.032 m at most, at 2 m/s by twice as much.
    assert not touches(rodgen.simulate(scene, progress=False), "hard")
    faster = scene.replace({"initial.velocity": [0.0, 2.0]})
    end = rodgen.simulate(faster, progress=False).events[-1]
    omega = math.sqrt(2e3 / 2.0)
    assert end.t == pytest.approx(0.05 + math.asin(0.05 * omega / 2.0) / omega, abs=1e-10)


# A block on a wall --------------------------------------------------------------------------------


def block(v: float, slow: float, tilt: float = 0.0, **integrate: Any) -> Scene:
    """One link that lies on a floor, as deep as it weighs, mu = 0.3."""
    k, m, length = 1e5, LINK["mass"], LINK["length"]
    rubs = {"friction": 0.3, "friction_speed": slow}
    return Scene.from_dict(
        {
            "name": "block",
            "rod": LINK,
            "loads": {
                "gravity": {"acceleration": [G * math.sin(tilt), -G * math.cos(tilt)]},
            },
            "walls": [{"normal": "pi/2", "stiffness": k, "damping": 1.0} | rubs],
            "initial": {
                "position": [0.0, -m * G * math.cos(tilt) / (k * length)],
                "velocity": [v, 0.0],
            },
            "integrate": {"span": [0.0, 2.0], "rtol": 1e-11, "atol": 1e-13} | integrate,
        }
    )


def test_a_block_slides_as_far_as_coulomb_has_it() -> None:
    """v^2/(2 mu g) and, of the regularised friction mu N tanh(v/v_s), the integral of
    v (coth(v/v_s) - 1)/(mu g) over v beside it: pi^2 v_s^2/(12 mu g)."""
    coulomb, beside = 1.0 / (2 * 0.3 * G), math.pi**2 / (12 * 0.3 * G)
    for slow in (0.04, 0.01):
        sol = rodgen.simulate(block(1.0, slow), progress=False)
        assert sol.y[-1, 0] - coulomb == pytest.approx(beside * slow**2, rel=1e-5)
        assert sol.energy_error < 1e-12
        # Down to the heat of the friction, which is all that is lost.
        assert sol.work["wall"][-1] == pytest.approx(-1.0, rel=1e-6)


def test_show_tells_how_fast_friction_creeps() -> None:
    scene = block(0.0, 0.01, tilt=0.2, span=[0.0, 1.0])
    sol = rodgen.simulate(scene, progress=False)
    (part,) = [one for one in model_parts(scene) if one.piece == "wall"]
    said = re.search(r"at ([\d.e+-]+) m/s$", part.reason)
    assert said is not None
    assert float(said[1]) == pytest.approx(sol.y[-1, 3], rel=1e-5)
    assert sol.y[-1, 3] == pytest.approx(0.01 * math.atanh(math.tan(0.2) / 0.3), rel=1e-9)
    steep = block(0.0, 0.01, tilt=0.4)
    (part,) = [one for one in model_parts(steep) if one.piece == "wall"]
    assert part.reason.endswith("slides under its weight")


# A chain and a table ------------------------------------------------------------------------------


def chain_by_hand(links: int, over: float, k: float, c: float, deep: float) -> float:
    """Time at which the last point of a chain leaves a table: point masses in places of their own,
    which rods hold together (multipliers), on a quarter plane. Nothing of it is rodgen's."""
    points, l = links + 1, 1.0 / links
    mass = np.full(points, l)
    mass[[0, -1]] /= 2
    width = mass.copy()  # of 1 kg and 1 m
    angles = np.where((np.arange(links) + 0.5) / links < 1 - over, 0.0, -np.pi / 2)
    places = np.zeros((points, 2))
    places[0] = over - 1.0 + 1e-3, -deep
    places[1:] = places[0] + np.cumsum(l * np.stack((np.cos(angles), np.sin(angles)), -1), 0)

    def rates(_: float, y: Array) -> Array:
        r, v = y.reshape(2, points, 2)
        force = np.outer(mass, (0.0, -G))
        for j in range(points):
            top, side = -r[j, 1], -r[j, 0]
            normal, depth = ((0.0, 1.0), top) if top <= side else ((1.0, 0.0), side)
            if depth > 0:
                rate = -float(np.dot(v[j], normal))
                push = width[j] * k * depth * max(0.0, 1.0 + c * rate)
                force[j] += push * np.array(normal)
        d, dv = np.diff(r, axis=0), np.diff(v, axis=0)
        jacobian = np.zeros((links, points, 2))
        for i in range(links):
            jacobian[i, i], jacobian[i, i + 1] = -d[i], d[i]
        flat = jacobian.reshape(links, -1)
        weights = np.repeat(1 / mass, 2)
        free = force.ravel() * weights
        right = -(dv**2).sum(axis=1) - flat @ free
        tension = np.linalg.solve(flat * weights @ flat.T, right)
        return np.concatenate((v.ravel(), free + weights * (flat.T @ tension)))

    def depth(_: float, y: Array) -> float:
        return -float(max(y[0], y[1]))

    depth.terminal, depth.direction = True, -1  # type: ignore[attr-defined]
    start = np.concatenate((places.ravel(), np.zeros(2 * points)))
    how = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "max_step": 2e-4}
    found = scipy.integrate.solve_ivp(rates, (0.0, 2.0), start, events=depth, **how)
    return float(found.t_events[0][0])


def test_a_chain_leaves_a_table_as_by_hand() -> None:
    k, c, links = 2e3, 2.0, 4
    scene = Scene.example("chain_off_a_table").replace(
        {
            "rod.links": links,
            "rod.inertia": "lumped",
            "walls.0.stiffness": k,
            "walls.0.damping": c,
            "initial.phi": "0 if s < 0.5 else -pi/2",
            "initial.position": [-0.499, -G / k],
            "integrate.rtol": 1e-12,
            "integrate.atol": 1e-14,
            "integrate.span": [0.0, 0.8],
        }
    )
    sol = rodgen.simulate(scene, progress=False)
    first = next(event.t for event in sol.events if event.name == "wall leaves at joint 0")
    assert first == pytest.approx(chain_by_hand(links, 0.5, k, c, G / k), abs=1e-8)
    assert sol.energy_error < 1e-8


@pytest.mark.slow
@pytest.mark.compiler
@pytest.mark.parametrize("name", ["chain_off_a_table", "dropped_rod", "column_with_stop"])
def test_scenes_with_contacts_keep_the_balance(name: str) -> None:
    scene = Scene.example(name)
    fewer = {"rod.links": 6, "integrate.span": [0.0, 9.0 if "column" in name else 0.8]}
    sol = rodgen.simulate(scene.replace(fewer), target="c", progress=False)
    assert sol.status == "finished"
    assert touches(sol)
    assert touches(sol, "leaves")
    moved = max(np.ptp(sol.energy.kinetic), np.ptp(sol.energy.spring))
    assert sol.energy_error < 1e-8 * max(1.0, moved)


def swinging_link(**integrate: Any) -> Scene:
    """A pendulum that swings down onto an upright wall without damping, 20 kN/m^2 of its metre."""
    return Scene.from_dict(
        {
            "name": "pendulum",
            "rod": LINK | {"length": 1.0, "mass": 1.0, "boundary": "pinned"},
            "loads": {"gravity": {}},
            "walls": [{"normal": 0.0, "stiffness": 2e4}],
            "integrate": {"span": [0.0, 1.0]} | integrate,
        }
    )


@pytest.mark.parametrize("how", [{"target": "numpy"}, {"method": "lsoda"}])
def test_a_wall_that_takes_no_energy_does_no_work(how: dict[str, Any]) -> None:
    """The energy of the fall, m g L/2, presses the tail in: k L d^2/4 of the half link there."""
    sol = rodgen.simulate(swinging_link(rtol=1e-10), output_every=1e-4, progress=False, **how)
    assert "wall" not in sol.work
    assert sol.energy_error < 1e-7
    deepest = sol.values("depth_wall_1").max()
    assert 1e4 * deepest**2 / 2 == pytest.approx(0.5 * G, rel=1e-3)
    for absent in ("push_wall_0", "push_wall_2", "push_wall_x", "depth_stop"):
        with pytest.raises(KeyError, match="is no quantity"):
            sol.values(absent)


def test_a_fixed_step_is_held_against_the_contacts() -> None:
    """By the spring k/2 of the tail, sqrt(3 k/(2 m)) = 173 rad/s, though it is apart at the start
    and acts along the link there; the limit of rk4 is 2.83 over that."""
    scene = swinging_link()
    limit = rodgen.describe(scene).largest_stable_steps["rk4"]
    assert limit == pytest.approx(2.8284 / math.sqrt(3e4), rel=1e-3)
    with pytest.warns(rodgen.DoubtWarning, match="while contacts are pressed"):
        rodgen.simulate(scene, method="rk4", step=1.2 * limit, progress=False)


def test_what_begins_on_the_edge_of_a_stop_is_found_lying_on_it() -> None:
    scene = Scene.from_dict(
        {
            "name": "lying",
            "rod": {"links": 2, "length": 1.0, "mass": 1.0, "boundary": "pinned"}
            | {"bending_stiffness": 100.0},
            "loads": {"gravity": {}},
            "stops": [{"at": 1.0, "direction": "-pi/2", "stiffness": 1e3}],
        }
    )
    tail = rodgen.static_equilibrium(scene).joints[-1, 1]
    # Half of the weight, and less than a thousandth of it for the angle.
    assert tail == pytest.approx(-0.5 * G / 1e3, rel=1e-3)


# Joints -------------------------------------------------------------------------------------------


def flap(**more: Any) -> Scene:
    """One link on a clamp, its root spring of 2 EI/L = 6 N m/rad, pushed by a couple of 3 N m."""
    rod = {"links": 1, "length": 1.0, "bending_stiffness": 3.0, "mass": 1.5, "boundary": "clamped"}
    return Scene.from_dict(
        {"name": "flap", "rod": rod, "loads": {"moment": {"moment": 3.0}}} | more
    )


def test_a_limit_of_a_joint_is_a_spring_beyond_its_gap() -> None:
    """At rest k phi + k_s (phi - gap) = M; about it the frequency is that of both springs."""
    stop = {"at": 0.0, "direction": 1, "gap": 0.2, "stiffness": 14.0}
    scene = flap(joint_stops=[stop])
    rest = rodgen.static_equilibrium(scene)
    angle = (3.0 + 14.0 * 0.2) / (6.0 + 14.0)
    assert rest.phi[0] == pytest.approx(angle, abs=1e-12)
    modes = rodgen.natural_modes(scene, 1)
    inertia = 1.5 / 3
    assert modes.frequencies[0] == pytest.approx(
        math.sqrt(20.0 / inertia) / (2 * math.pi), rel=1e-9
    )
    # To the other side it does nothing.
    other = scene.replace({"joint_stops.0.direction": -1})
    assert rodgen.static_equilibrium(other).phi[0] == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize(("key", "size"), [("moment_per_joint", 4.0), ("moment_per_length", 8.0)])
def test_a_joint_creeps_under_less_than_its_friction(key: str, size: float) -> None:
    """At the rate rate_s atanh(M/m_f), m_f over the half link that bends in the root."""
    scene = flap(
        loads={"moment": {"moment": 3.0}, "joint_friction": {key: size, "rate": 0.05}},
        integrate={"span": [0.0, 2.0], "rtol": 1e-11, "atol": 1e-13},
    ).replace({"rod.bending_stiffness": 0.0})
    sol = rodgen.simulate(scene, progress=False)
    assert sol.y[-1, 1] == pytest.approx(0.05 * math.atanh(3.0 / 4.0), rel=1e-9)
    assert sol.energy_error < 1e-10


# At rest ------------------------------------------------------------------------------------------


def test_a_rod_lies_on_a_floor_as_deep_as_it_weighs() -> None:
    """At m g/(k L) everywhere, whose stiffness gives a lying rod the frequency sqrt(k/m)."""
    floor = {"initial.position": [0.0, -1e-4], "initial.phi": 0.0}
    scene = Scene.example("dropped_rod").replace(floor)
    np.testing.assert_allclose(
        rodgen.static_equilibrium(scene).joints[:, 1], -0.5 * G / 4e4, rtol=1e-9
    )
    lowest = rodgen.natural_modes(scene, 1).frequencies[0]
    # Half of the rod is gathered in the joints at the ends of links: 1/(2 n^2) less.
    assert lowest == pytest.approx(math.sqrt(4e4 / 0.5) / (2 * math.pi), rel=2e-3)


def test_a_beam_that_lies_on_a_stop_vibrates_as_if_propped() -> None:
    """Clamped and propped: (3.92660)^2 sqrt(EI/(m L^4)), of 40 links to a thousandth."""
    stop = {"at": 1.0, "direction": "-pi/2", "gap": 0.001, "stiffness": 1e7}
    rod = {"links": 40, "length": 1.0, "bending_stiffness": 1.0, "mass": 0.2, "boundary": "clamped"}
    scene = Scene.from_dict(
        {"name": "beam", "rod": rod, "loads": {"tip": {"y": -0.02}}, "stops": [stop]}
    )
    rest = rodgen.static_equilibrium(scene)
    assert rest.joints[-1, 1] == pytest.approx(-0.001, abs=1e-8)
    lowest = rodgen.natural_modes(scene, 1).frequencies[0]
    propped = 3.926602**2 * math.sqrt(1.0 / 0.2) / (2 * math.pi)
    assert lowest == pytest.approx(propped, rel=1e-3)


@pytest.mark.slow
@pytest.mark.compiler
def test_a_limit_cycle_grazes_the_stops_where_it_is_as_wide_as_they_are_apart() -> None:
    """Stops beside a column change neither its flutter load nor the cycles that do not reach them:
    those of the column without stops are followed from the onset on."""
    between = Scene.example("column_with_stop")
    free = between.replace({"stops": []})
    loads = [rodgen.critical_load(scene).value for scene in (between, free)]
    assert loads[0] == pytest.approx(loads[1], rel=1e-9)
    key = "loads.follower.force"
    plane, bounds = (key, "loads.material_damping.time"), ((5.0, 20.0), (0.002, 0.02))
    found = [rodgen.stability_boundary(scene, plane, bounds=bounds) for scene in (between, free)]
    for of in ("a", "b", "frequency"):
        np.testing.assert_allclose(*(curve[of] for curve in found), rtol=1e-7)
    branch = rodgen.continue_cycles(free, key, (10.0, 10.8), target="c")
    for force, grazes in ((10.74, False), (10.749, True)):
        cycle = rodgen.find_cycle(free.replace({key: force}), start=branch, target="c")
        assert (np.abs(cycle.motion.values("tip")[:, 0]).max() > 0.1) is np.bool_(grazes)
        started = rodgen.System(between).at({key: force}, y0=cycle.motion.y[0])
        span = [0.0, 2 * cycle.period]
        sol = rodgen.simulate(started, target="c", span=span, progress=False)
        assert bool(touches(sol)) is grazes


# Without end --------------------------------------------------------------------------------------


def test_a_thousand_touches_in_a_moment_are_too_many() -> None:
    scene = bouncing_link({"stiffness": 1e3})
    system = rodgen.System(scene)
    watch = EventDetector(system.events, system.model("numpy"), system.p, moment=0.01)
    for at in range(999):
        assert not watch.record_event(0, 1e-4 * at, system.y0)  # within 0.1 s
    times = count(1.0, 9e-6)
    for _, at in zip(range(999), times, strict=False):
        watch.record_event(0, at, system.y0)
        watch.record_event(1, at, system.y0)  # leaves in between
    with pytest.raises(BounceError, match="stop touches"):
        watch.record_event(0, next(times), system.y0)


@pytest.mark.slow
@pytest.mark.compiler
def test_bouncing_without_end_ends_the_run() -> None:
    """By Hunt and Crossley a bounce loses a share that falls with its speed, so that bounces on
    what is very stiff grow ever more: a thousand within a thousandth of the span are too many."""
    law = {"stiffness": 1e12, "damping": 20.0, "gap": 0.0}
    scene = bouncing_link(law, span=[0.0, 10.0], rtol=1e-6, atol=1e-9)
    (_, floor) = scene.to_dict()["stops"]
    falls = {"stops": [floor], "loads.gravity": {}, "initial.velocity": [0.0, 0.1]}
    with pytest.raises(rodgen.RunError, match="stop touches") as told:
        rodgen.simulate(scene.replace(falls), target="c", progress=False)
    sol = told.value.solution
    assert sol.status == "bounces"
    last = touches(sol)[-1000:]
    assert last[-1] - last[0] <= 1e-3 * 10.0
