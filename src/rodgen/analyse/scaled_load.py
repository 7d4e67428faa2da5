"""The load that is scaled while the others stay: its parameters for every size that it has."""

from __future__ import annotations

from dataclasses import dataclass

from rodgen.analyse.system import System
from rodgen.scene import SceneError
from rodgen.scene.tables import PLACES

FOLLOWER, TIP, GRAVITY, ALL = "follower", "tip", "gravity", "all"
LOADS = (FOLLOWER, TIP, GRAVITY, ALL)
UNITS = {FOLLOWER: "N", TIP: "N", GRAVITY: "m/s^2", ALL: "times the loads"}
PARAMETERS = {
    FOLLOWER: ("follower_force",),
    TIP: ("tip_force_x", "tip_force_y"),
    GRAVITY: ("gravity",),
}
PARAMETERS[ALL] = sum(PARAMETERS.values(), ())


@dataclass(frozen=True)
class ScaledLoad:
    """name: which load; direction: its parameters at the size one; unit: a size that matters, by
    which a search steps; reference: the size whose multiple is the factor of a critical load."""

    name: str
    direction: dict[str, float]
    unit: float
    reference: float

    def parameters(self, size: float) -> dict[str, float]:
        """Parameters of the module at a size."""
        return {name: float(size * part) for name, part in self.direction.items()}

    @classmethod
    def of(cls, name: str, system: System) -> ScaledLoad:
        """A follower force [N] whatever the scene's own is; a dead force at the tail [N] in the
        direction of the scene's; gravity [m/s^2]; or all three as multiples of what the scene has.
        Raises SceneError for a load that the scene lacks."""
        if name not in LOADS:
            raise SceneError("load", name, f"one of {', '.join(LOADS)}")
        rod, given = system.scene.rod, system.given
        if rod.bending_stiffness == 0:
            raise SceneError("rod.bending_stiffness", 0.0, "positive: a chain bears no thrust")
        here = {key: given[key] for key in PARAMETERS[name] if key in given}
        if not here:
            table = PLACES[PARAMETERS[name][0]][0]
            allowed = "a table: the critical size of its load is asked for"
            raise SceneError("loads" if name == ALL else f"loads.{table}", None, allowed)
        force = rod.bending_stiffness / rod.length**2
        if name == FOLLOWER:
            return cls(name, dict.fromkeys(here, 1.0), force, force)
        if name == GRAVITY:
            return cls(name, dict.fromkeys(here, 1.0), force / rod.mass, force / rod.mass)
        if not any(here.values()):
            place = "loads" if name == ALL else "loads.tip"
            raise SceneError(place, 0.0, "not zero: its direction is that of the scene")
        if name == TIP:
            size = sum(part**2 for part in here.values()) ** 0.5
            return cls(name, {key: part / size for key, part in here.items()}, force, force)
        size = sum(abs(part) * (rod.mass if key == "gravity" else 1) for key, part in here.items())
        return cls(name, here, force / size, 1.0)
