"""Loads and moments at a joint, and a link cut free."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodgen.view.model_parts import (
    FORCE,
    SPRING,
    VELOCITY,
    Point,
    across,
    along,
    arrow,
    by,
    guide,
    joints,
    rod,
    sheet,
    text,
    turn,
)


def damping() -> Figure:
    """What external and internal damping and the spring do at a joint."""
    figure, axes = sheet(5.4, 2.2, 1.33)
    phi = [0.5, -0.05]
    mean = sum(phi) / 2
    r = joints("free", phi, by(0.25, 0.3))
    text(axes, by(1.3, 2.08), "external damping")
    rod(axes, r)
    guide(axes, r[1] - along(mean, 0.75), r[1] + along(mean, 0.9))
    text(axes, r[1] + along(mean, 1.02), r"$\bar\varphi_s$")
    velocity = along(mean + 0.9, 1.1)
    part = across(mean) * (velocity @ across(mean))
    arrow(axes, [r[1], r[1] + velocity], VELOCITY)
    arrow(axes, [r[1], r[1] + part], VELOCITY, 1.0)
    guide(axes, r[1] + part, r[1] + velocity, ":")
    text(axes, r[1] + velocity + by(0.15, 0.04), "$v_s$", VELOCITY)
    text(axes, r[1] + part + by(-0.17, -0.1), r"$v_{s\perp}$", VELOCITY)
    arrow(axes, [r[1], r[1] - 0.6 * velocity], FORCE, 2.2)
    text(axes, r[1] - 0.6 * velocity + by(0.16, 0.02), "$F_s$", FORCE)
    text(axes, by(4.0, 2.08), "moments across a joint")
    before, after = r + by(2.4, 0.35), r + by(3.1, 0.35)
    rod(axes, before[:2])
    rod(axes, after[1:])
    _name(axes, before[:2], 0.3, "s-1")
    _name(axes, after[1:], 0.68, "s")
    _moments(axes, before[1], after[1], phi, r"$\tau_s$")
    return figure


def _name(axes: Axes, ends: np.ndarray, share: float, index: str) -> None:
    """The name of a link below it, at a share of its length."""
    step = ends[1] - ends[0]
    turned = float(np.arctan2(step[1], step[0]))
    at = ends[0] + share * step + across(turned, -0.2)
    text(axes, at, f"link ${index}$", rotation=np.degrees(turned))


def _moments(axes: Axes, end: Point, start: Point, phi: list[float], name: str) -> None:
    """A moment on the link that starts here, and its opposite on the link that ends there."""
    turn(axes, end, 0.3, (phi[0] + np.pi + 1.0, phi[0] + np.pi - 1.0), SPRING)
    turn(axes, start, 0.3, (phi[1] - 1.0, phi[1] + 1.0), SPRING)
    text(axes, end + along(phi[0] + np.pi - 1.0, 0.44), name, SPRING)
    text(axes, start + along(phi[1] + 1.0, 0.44), name, SPRING)


def cut() -> Figure:
    """A link cut free: the forces and moments in the joints at its ends."""
    figure, axes = sheet(6.4, 2.2, 1.12)
    phi = [0.45, 0.2, -0.05]
    r = joints("free", phi, by(-0.68, 0.02), 2.0)
    gap = by(0.95, 0.0)
    stubs = (r[1] - along(phi[0], 0.95), r[2] + along(phi[2], 0.95))
    parts = (np.array([stubs[0], r[1]]), r[1:3] + gap, np.array([r[2], stubs[1]]) + 2 * gap)
    for part, share, name in zip(parts, (0.27, 0.7, 0.73), ("s-1", "s", "s+1"), strict=True):
        rod(axes, part)
        _name(axes, part, share, name)
    forces = (along(0.95, 0.65), along(0.75, 0.65))
    for at, (force, name) in enumerate(zip(forces, ("s", "s+1"), strict=True)):
        end, start = parts[at][1], parts[at + 1][0]
        arrow(axes, [end, end + force], FORCE)
        arrow(axes, [start, start - force], FORCE)
        text(axes, end + force + by(0.05, 0.13), rf"$m\lambda_{{{name}}}$", FORCE)
        text(axes, start - force + by(0.0, -0.13), rf"$-m\lambda_{{{name}}}$", FORCE)
        _moments(axes, end, start, phi[at : at + 2], rf"$\tau_{{{name}}}$")
    middle = parts[1].mean(axis=0)
    arrow(axes, [middle, middle - by(0.0, 0.75)], FORCE)
    text(axes, middle + by(0.18, -0.62), "$mg$", FORCE)
    return figure
