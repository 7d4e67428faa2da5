"""Forces in the joints by the momentum of the links behind each: accelerations are those of `rhs`,
every load on every link is written down by hand."""

from __future__ import annotations

from typing import Any

import numpy as np

import rodgen
from rodgen import Scene
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.model.rod import BOUNDARIES, INERTIAS
from tests.palette import cases
from tests.scene.tables import scene_of

L, M, EI, CLAMP = 1.7, 2.3, 5.0, 0.3
INSIDE = (0.15, 0.55, 0.9)  # shares of the rod at which loads act, of three links all inside


def loads_of(rng: np.random.Generator) -> dict[str, Any]:
    """Every load that acts inside links or along them, of random sizes."""
    some = iter(rng.uniform(-3.0, 3.0, 40))
    sizes = iter(rng.uniform(0.1, 3.0, 40))
    follower = [{"at": at, "force": next(some), "angle": next(some)} for at in INSIDE]
    drag = {"normal": next(sizes), "tangential": next(sizes), "wind": [next(some), next(some)]}
    return {
        "loads": {
            "follower": follower,
            "distributed_follower": {"force_per_length": next(some)},
            "gravity": {"g": next(some)},
            "drag": drag,
            "external_damping": {"coefficient": next(sizes)},
            "internal_damping": {"coefficient": next(sizes)},
        },
        "supports": [
            {"at": at, "to": [next(some), next(some)], "stiffness": [next(sizes), next(sizes)]}
            | {"damping": [next(sizes), next(sizes)], "rotation": next(sizes)}
            for at in INSIDE
        ],
        "foundation": {"stiffness": next(sizes), "damping": next(sizes)},
    }


class Links:
    """Where the links are, how they move and what the loads do on each, by hand."""

    def __init__(self, scene: Scene, y: np.ndarray, rates: np.ndarray):
        self.scene, self.n = scene, scene.rod.links
        n, boundary_condition = self.n, scene.boundary_condition
        half, base = len(y) // 2, 2 * boundary_condition.translates
        zero = np.zeros(boundary_condition.first)
        self.clamp = CLAMP if boundary_condition.is_clamped else 0.0
        self.phi = np.concatenate((zero + self.clamp, y[base:half]))
        self.omega = np.concatenate((zero, y[half + base :]))
        alpha = np.concatenate((zero, rates[half + base :]))
        self.l, self.m = L / n, M / n
        e = np.stack((np.cos(self.phi), np.sin(self.phi)), -1)
        across = np.stack((-e[:, 1], e[:, 0]), -1)
        start = [y[:2], y[half : half + 2], rates[half : half + 2]] if base else np.zeros((3, 2))
        turned = self.omega[:, None] * across
        ways = (e, turned, alpha[:, None] * across - self.omega[:, None] ** 2 * e)
        self.place, self.velocity, self.acceleration = (
            self._joints(first, self.l * way) for first, way in zip(start, ways, strict=True)
        )
        self.e, self.across = e, across

    def _joints(self, start: np.ndarray, steps: np.ndarray) -> np.ndarray:
        return np.concatenate(([start], start + np.cumsum(steps, axis=0)))

    def momentum_rates(self) -> np.ndarray:
        """Both inertias have the centre in the middle."""
        return self.m * (self.acceleration[1:] + self.acceleration[:-1]) / 2

    def forces(self) -> np.ndarray:
        """On every link [N]."""
        loads, total = self.scene.loads, np.zeros((self.n, 2))
        for one in loads.follower:
            link = int(one.at * self.n)
            angle = self.phi[link] + one.angle
            total[link] -= one.force * np.array([np.cos(angle), np.sin(angle)])
        total -= loads.distributed_follower.force_per_length * self.l * self.e
        total[:, 1] -= self.m * loads.gravity.g
        for one in self.scene.supports:
            link, share = int(one.at * self.n), one.at * self.n % 1
            place, velocity = (
                (1 - share) * part[link] + share * part[link + 1]
                for part in (self.place, self.velocity)
            )
            total[link] -= np.array(one.stiffness) * (place - one.to)
            total[link] -= np.array(one.damping) * velocity
        for link in range(self.scene.boundary_condition.first, self.n):
            for at in (link, link + 1):  # half a link at either end
                total[link] += self._at_joint(at, link)
        return total

    def _at_joint(self, at: int, link: int) -> np.ndarray:
        """What a joint feels of the half of a link there: along the mean of those that meet."""
        still = self.scene.boundary_condition.is_held and at == self.scene.boundary_condition.first
        near = [link] if still else [one for one in (at - 1, at) if 0 <= one < self.n]
        angle = self.phi[near].mean()
        e = np.array([np.cos(angle), np.sin(angle)])
        loads, v, half = self.scene.loads, self.velocity[at], self.l / 2
        found = np.zeros(2)
        for c, unit in ((loads.drag.normal, [-e[1], e[0]]), (loads.drag.tangential, e)):
            part = (v - loads.drag.wind) @ unit
            found -= half * c * abs(part) * part * np.array(unit)
        if speed := np.hypot(*v):
            lean = abs(e[0] * v[1] - e[1] * v[0]) / speed
            found -= loads.external_damping.coefficient * lean * self.m / 2 * v
        held = self.scene.foundation
        axis = np.array([np.cos(self.clamp), np.sin(self.clamp)])
        normal = np.array([-axis[1], axis[0]])
        spring = held.stiffness * (normal @ self.place[at]) + held.damping * (normal @ v)
        return found - half * spring * normal


@cases("boundary, inertia", BOUNDARIES, INERTIAS)
def test_momentum_of_what_is_behind_a_joint(boundary: str, inertia: str) -> None:
    rod = {"links": 3, "length": L, "mass": M, "bending_stiffness": EI}
    rod |= {"boundary": boundary, "inertia": inertia}
    rod |= {"clamp_angle": CLAMP} if BOUNDARIES[boundary].is_clamped else {}
    model = None
    for seed in range(15):
        rng = np.random.default_rng(seed)
        tables = loads_of(rng)
        if BOUNDARIES[boundary].first:  # link 0 does not move
            del tables["supports"][0]
        scene = scene_of(rod=rod, **tables)
        model = model or rodgen.build(scene, "numpy")
        p = model.parameters(**scene.parameters)
        y = rng.normal(size=len(model.STATE))
        links = Links(scene, y, model.rhs(0.3, y, p))
        beyond = links.forces() - links.momentum_rates()
        expected = np.cumsum(beyond[::-1], axis=0)[::-1][scene.boundary_condition.first_force :]
        piece = MotionSlice(model, p, y, np.array(0.3))
        sizes = np.abs(links.forces()).max() + np.abs(links.momentum_rates()).max()
        np.testing.assert_allclose(
            piece.values("joint_forces"), expected, rtol=0, atol=1e-12 * sizes
        )
        if scene.boundary_condition.is_held:
            np.testing.assert_array_equal(
                piece.values("reaction"), -piece.values("joint_forces")[0]
            )
