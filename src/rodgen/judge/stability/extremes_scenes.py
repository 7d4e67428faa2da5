"""Scenes of the matrix: one of moderate size, and the same in other units."""

from __future__ import annotations

from typing import Any

import numpy as np

from rodgen.judge.stability.extremes_case import Array, Tables
from rodgen.judge.stability.extremes_truth import Route, same_as, tight

N, LENGTH, STIFFNESS, MASS, SPAN = 4, 2.0, 30.0, 3.0, 0.3
CRITICAL = 109.9 * STIFFNESS / LENGTH**2  # follower force at which a free rod flutters [N]


# Every load, none of it acting: with the module of `loaded`.
IDLE: Tables = {
    "follower": {"force": 0.0},
    "gravity": {"g": 0.0},
    "internal_damping": {"coefficient": 0.0},
    "external_damping": {"coefficient": 0.0},
}


def rod(links: int = N, span: float = SPAN, **tables: Any) -> Tables:
    """A rod of 2 m, 30 N m^2 and 3 kg, bent and turning, if not told otherwise."""
    shape = {"links": links, "length": LENGTH, "bending_stiffness": STIFFNESS, "mass": MASS}
    return {
        "name": "extreme",
        "rod": {**shape, **tables.pop("rod", {})},
        "initial": {"phi": "0.4*cos(pi*s)", "omega": "0.5*s", **tables.pop("initial", {})},
        "integrate": {"span": [0.0, span], **tables.pop("integrate", {})},
        **tables,
    }


def loaded(length: float = 1.0, mass: float = 1.0, time: float = 1.0, links: int = N) -> Tables:
    """Every load at once, with units of length, mass and time so many times larger."""
    force = mass * length / time**2
    return rod(
        links,
        span=SPAN * time,
        rod={
            "length": LENGTH * length,
            "bending_stiffness": STIFFNESS * force * length**2,
            "mass": MASS * mass,
        },
        loads={
            "follower": {"force": 40.0 * force, "angle": 0.1},
            "gravity": {"g": 9.81 * length / time**2},
            "internal_damping": {"coefficient": 0.2 * length**2 / time},
            "external_damping": {"coefficient": 0.7 / time, "fin_factor": {"tail": 5.0}},
        },
        initial={
            "position": [0.0, 1.0 * length],
            "velocity": [1.0 * length / time, 0.3 * length / time],
            "omega": f"{0.5 / time!r}*s",
        },
    )


def rescaled(length: float, time: float) -> Route:
    """The motion of the scene in plain units, in other ones."""

    def carry(y: Array) -> Array:
        half = y.shape[1] // 2
        q, u = y[:, :half].copy(), y[:, half:] / time
        q[:, :2] *= length
        u[:, :2] *= length
        return np.concatenate((q, u), axis=1)

    return same_as(loaded(), carry)


def shifted(tables: Tables, by: dict[str, float], route: Route = tight) -> tuple[Tables, Route]:
    """A free rod displaced by x, y, turned by phi or flying by vx, and how it moves then."""
    initial = dict(tables["initial"])
    x, y = initial.get("position", [0.0, 0.0])
    vx, vy = initial.get("velocity", [0.0, 0.0])
    dx, dy, turn, speed = (by.get(name, 0.0) for name in ("x", "y", "phi", "vx"))
    phi = initial["phi"]
    initial["position"], initial["velocity"] = [x + dx, y + dy], [vx + speed, vy]
    initial["phi"] = [a + turn for a in phi] if isinstance(phi, list) else f"{turn!r} + ({phi})"
    span = tables["integrate"]["span"]

    def carry(states: Array) -> Array:
        half = states.shape[1] // 2
        out = states.copy()
        t = np.linspace(0.0, span[1] - span[0], len(out))
        cos, sin = np.cos(turn), np.sin(turn)
        for at in (0, half):
            a, b = states[:, at].copy(), states[:, at + 1].copy()
            out[:, at], out[:, at + 1] = cos * a - sin * b, sin * a + cos * b
        out[:, 0] += dx + speed * t
        out[:, 1] += dy
        out[:, half] += speed
        out[:, 2:half] += turn
        return out

    return {**tables, "initial": initial}, same_as(tables, carry, route)
