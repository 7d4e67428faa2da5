"""Forces and moments of the loads of a scene on its chain, and the rates of all states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from rodgen_evidence.verdicts.digits import Vector
from rodgen_evidence.verdicts.link_chain import ChainState, LinkChain, Table


def rates(chain: LinkChain, y: Sequence[Any]) -> Vector:
    """The time derivative of a state."""
    here = chain.at(y)
    loads = ChainLoads(here)
    for name, load in chain.table["loads"].items():
        getattr(loads, name)(load)
    for support in chain.table.get("supports", ()):
        loads.support(support)
    if "foundation" in chain.table:
        loads.foundation(chain.table["foundation"])
    loads.bend()
    states = chain.table.get("states", {}).values()
    own = [loads.value(state["rate"]) for state in states]
    return [*here.u, *here.rates(loads.forces, loads.moments), *own]


class ChainLoads:
    """Loads on a chain in a state: forces with their places, moments on links."""

    def __init__(self, here: ChainState):
        self.here, self.chain, self.of = here, here.chain, here.chain.numbers.of
        self.forces: list[tuple[Any, Any, Any]] = []
        self.moments: Vector = [self.of(0)] * here.chain.n

    def value(self, law: Any) -> Any:
        """A number, or an expression in sensors and added states."""
        if not isinstance(law, str):
            return self.of(law)
        sensors = {name: getattr(self, f"_{name}") for name in ("phi", "omega")}
        for at, axis in enumerate("xy"):
            sensors[axis] = lambda s, at=at: self.here.place(self._arms(s))[at]
            sensors[f"v{axis}"] = lambda s, at=at: self.here.velocity(self._arms(s))[at]
        return self.of(eval(law, {"__builtins__": {}}, sensors | self.here.added))

    def _arms(self, s: float) -> Any:
        return self.chain.arms(*self.chain.place(s))

    def _phi(self, s: float) -> Any:
        return self.here.phi[self.chain.place(s)[0]]

    def _omega(self, s: float) -> Any:
        return self.here.omega[self.chain.place(s)[0]]

    def _pair(self, before: int, after: int, moment: Any) -> None:
        """A moment between two links; -1 is the ground."""
        self.moments[after] -= moment
        if before >= 0:
            self.moments[before] += moment

    def _turn(self, before: int, after: int, of: Vector, ground: Any) -> Any:
        return of[after] - (of[before] if before >= 0 else ground)

    def bend(self) -> None:
        """Springs of the joints."""
        for before, after, k in self.chain.springs:
            turned = self._turn(before, after, self.here.phi, self.chain.axis)
            self._pair(before, after, k * turned)

    def material_damping(self, load: Table) -> None:
        for before, after, k in self.chain.springs:
            turned = self._turn(before, after, self.here.omega, 0)
            self._pair(before, after, self.of(load["time"]) * k * turned)

    def internal_damping(self, load: Table) -> None:
        c = self.of(load["coefficient"]) * self.chain.mass / self.chain.n
        for before, after, _ in self.chain.springs:
            turned = self._turn(before, after, self.here.omega, 0)
            self._pair(before, after, (1 if before >= 0 else 2) * c * turned)

    def follower(self, load: Any) -> None:
        for one in load if isinstance(load, list) else [load]:
            force, angle = self.value(one["force"]), self.value(one.get("angle", 0.0))
            link, along = self.chain.place(one.get("at", 1.0))
            (cos, sin), numbers = self.here.e[link], self.chain.numbers
            a, b = numbers.cos(angle), numbers.sin(angle)
            x, y = -force * (cos * a - sin * b), -force * (sin * a + cos * b)
            self.forces.append((self.chain.arms(link, along), x, y))

    def distributed_follower(self, load: Table) -> None:
        push = self.of(load["force_per_length"]) * self.chain.l
        angle, numbers = self.value(load.get("angle", 0.0)), self.chain.numbers
        a, b = numbers.cos(angle), numbers.sin(angle)
        for link, (cos, sin) in enumerate(self.here.e):
            x, y = -push * (cos * a - sin * b), -push * (sin * a + cos * b)
            self.forces.append((self.chain.arms(link, self.chain.l / 2), x, y))

    def moment(self, load: Any) -> None:
        for one in load if isinstance(load, list) else [load]:
            self.moments[self.chain.place(one.get("at", 1.0))[0]] += self.value(one["moment"])

    def gravity(self, load: Table) -> None:
        x, y = map(self.value, load.get("acceleration", (0.0, 0.0)))
        down = self.value(load.get("g", 0.0))
        for m, arms in self.chain.masses:
            self.forces.append((arms, m * x, m * (y - down)))

    def tip(self, load: Table) -> None:
        x, y = (self.value(load.get(axis, 0.0)) for axis in "xy")
        self.forces.append((self.chain.joints[-1], x, y))

    def _directions(self) -> list[tuple[Any, Any]]:
        """Directions of the mean angle of the links at every joint."""
        numbers, phi = self.chain.numbers, self.here.phi
        pairs = [(a + b) / 2 for a, b in pairwise(phi)]
        return [(numbers.cos(a), numbers.sin(a)) for a in (phi[0], *pairs, phi[-1])]

    def external_damping(self, load: Table) -> None:
        for s, (cos, sin) in enumerate(self._directions()):
            x, y = self.here.velocity(self.chain.joints[s])
            speed = self.chain.numbers.sqrt(x * x + y * y)
            if speed:
                across = abs(y * cos - x * sin) / speed
                m = self.chain.mass / self.chain.n * self.chain.at_joint(s)
                c = self.of(load["coefficient"]) * m * across
                self.forces.append((self.chain.joints[s], -c * x, -c * y))

    def drag(self, load: Table) -> None:
        self._resist(load, lambda speed: abs(speed) * speed)

    def viscous_drag(self, load: Table) -> None:
        self._resist(load, lambda speed: speed)

    def _resist(self, load: Table, law: Callable[[Any], Any]) -> None:
        wind = [self.value(part) for part in load.get("wind", (0.0, 0.0))]
        for s, (cos, sin) in enumerate(self._directions()):
            x, y = (
                v - w for v, w in zip(self.here.velocity(self.chain.joints[s]), wind, strict=True)
            )
            along, across = x * cos + y * sin, y * cos - x * sin
            weight = self.chain.l * self.chain.at_joint(s)
            a = -weight * self.of(load.get("tangential", 0.0)) * law(along)
            b = -weight * self.of(load.get("normal", 0.0)) * law(across)
            self.forces.append((self.chain.joints[s], a * cos - b * sin, a * sin + b * cos))

    def support(self, load: Table) -> None:
        link, along = self.chain.place(load["at"])
        arms, numbers = self.chain.arms(link, along), self.chain.numbers
        far = link * self.chain.l + along
        rest = far * numbers.cos(self.chain.axis), far * numbers.sin(self.chain.axis)
        rest = tuple(map(self.of, load["to"])) if "to" in load else rest
        k, c = (
            [self.of(one) for one in load.get(key, (0.0, 0.0))] for key in ("stiffness", "damping")
        )
        place, v = self.here.place(arms), self.here.velocity(arms)
        x, y = (-k[i] * (place[i] - rest[i]) - c[i] * v[i] for i in (0, 1))
        self.forces.append((arms, x, y))
        self.moments[link] -= (
            self.of(load.get("rotation", 0.0)) * (self.here.phi[link] - self.chain.axis)
            + self.of(load.get("rotation_damping", 0.0)) * self.here.omega[link]
        )

    def foundation(self, load: Table) -> None:
        a, b = self.chain.numbers.cos(self.chain.axis), self.chain.numbers.sin(self.chain.axis)
        for s, arms in enumerate(self.chain.joints):
            (x, y), (vx, vy) = self.here.place(arms), self.here.velocity(arms)
            weight = self.chain.l * self.chain.at_joint(s)
            k, c = self.of(load["stiffness"]), self.of(load.get("damping", 0.0))
            push = -weight * (k * (y * a - x * b) + c * (vy * a - vx * b))
            self.forces.append((arms, -push * b, push * a))
