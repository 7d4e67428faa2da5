"""Random loads of a rod: forces in time and with feedback, drag, and damping of every size."""

from __future__ import annotations

from typing import Any

from rodgen_evidence.verdicts.random_rod import RandomRod

Tables = dict[str, Any]

MOST, LONG = 20, 30  # links; those of one structure in ten
FORCES = (
    "{P}",
    "{P}",
    "{P}*(1 + {a}*sin({w}*t))",
    "{P}*min(t/{r}, 1)",
    "{P} if t < {r} else {Q}",
    "{P}*(1 + {a}*{sensed})",
)
ANGLES = ("", "", "{a}*{sensed}", "max(-{a}, min({a}, {b}*{sensed}))", "gimbal", "{a}*sin({w}*t)")


class Loads(RandomRod):
    """A random rod with its loads."""

    def links(self) -> int:
        return LONG if self.chance(0.1) else int(self.shape.integers(2, MOST + 1))

    def sensor(self) -> str:
        """Expression of an angle, or of a rate over T, of a point of the rod."""
        sign = "-" if self.chance(0.5) else ""
        if self.chance(0.5):
            return f"({sign}phi({self.spot()}))"
        return f"({sign}{self.T!r}*omega({self.spot()}))"

    def law(self, texts: tuple[str, ...], low: float, high: float) -> str:
        """A force or an angle; its own size is between low and high."""
        text = str(self.shape.choice(texts))
        given = {"P": self.size(low, high), "Q": self.size(low, high), "a": self.size(0.01, 0.5)}
        given |= {"w": self.size(0.3, 20) / self.T, "r": self.size(0.1, 10) * self.T}
        numbers = {name: repr(value) for name, value in given.items()}
        return text.format(sensed=self.sensor(), b=repr(self.size(0.05, 1)), **numbers)

    def loads(self) -> Tables:
        """Loads of all kinds, each with its chance."""
        F, T, found = self.F, self.T, dict[str, Any]()
        if self.chance(0.6):
            found["follower"] = [self.follower(1.0)]
            if self.chance(0.2):
                found["follower"].append(self.follower(self.spot()))
        if self.chance(0.15):
            found["distributed_follower"] = {"force_per_length": self.size(0.1, 15) * F / self.L}
        if self.chance(0.2):
            found["tip"] = {
                "x": self.signed_size(0.05, 3) * F,
                "y": self.law(FORCES, 0.05 * F, 2 * F),
            }
        if self.chance(0.35):
            found["gravity"] = {"g": self.size(0.1, 30) * F / self.M}
        return found | self.damping(T)

    def follower(self, at: float) -> Tables:
        found: Tables = {"force": self.law(FORCES, 0.2 * self.F, 20 * self.F), "at": at}
        angle = self.law(ANGLES, 0.01, 0.5)
        return found | ({"angle": angle} if angle else {})

    def damping(self, T: float) -> Tables:
        """Draw a damping from next to none to many times the critical one."""
        found: Tables = {}
        if self.chance(0.55):
            found["material_damping"] = {"time": self.size(1e-6, 0.1) * T}
        if self.chance(0.25):
            found["internal_damping"] = {"coefficient": self.size(1e-5, 0.3) * self.L**2 / T}
        if self.chance(0.2):
            found["external_damping"] = {"coefficient": self.size(1e-3, 10) / T}
        if self.chance(0.25):
            medium, speed = self.M / self.L**2, self.L / T
            found["drag"] = {"normal": self.size(0.05, 3) * medium}
            found["drag"]["tangential"] = self.size(0.01, 0.3) * medium
            wind: list[Any] = [self.signed_size(0.1, 3) * speed for _ in range(2)]
            if self.chance(0.3):
                wind[0] = f"{self.size(0.1, 3) * speed!r}*sin({self.size(0.3, 10) / T!r}*t)"
            found["drag"]["wind"] = wind
        return found
