"""The O(n) accelerations of a rod as scalar expressions, for symbols or numbers.

Joint by joint from the tail: the force in a joint is A a + b in the acceleration a of the joint
(forces in m l, accelerations in l), which eliminates the rate of the link before it,

    D = j + n A n,  v = n/2 + A n,  b' = b + A c,  z = torque - n b',  c = -omega^2 e,
    A <- 1 + A - v v/D,  b <- c/2 + b' + v z/D,

with j = 1/3 for mass along the link, 1/2 for mass at its ends; and back from the start, where no
force is left or the joint is held: alpha = (z - v a)/D, a <- a + alpha n + c. With some 27 products
and quotients a link, 40 in the elimination of 2x2 blocks of forces: products are what a Taylor
series pays for. Gravity is an acceleration of the frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rodgen import Structure

KNOWN = ("follower", "gravity", "internal_damping", "tip_load")
Pair = tuple[Any, Any]
Function = Callable[[Any], Any]


@dataclass(frozen=True)
class Algebra:
    """Functions that expressions are made of, of symbols or of numbers.

    real: turns a number into what is reckoned with; or_one: its argument where that is positive,
    else 1. sqrt, abs and or_one are asked for by external damping alone.
    """

    cos: Function
    sin: Function
    sqrt: Function = math.sqrt
    abs: Function = abs
    or_one: Function = lambda square: square if square > 0 else 1
    real: Function = float


NUMBERS = Algebra(math.cos, math.sin)


def accelerations(
    rod: Structure, given: Mapping[str, Any], q: Sequence[Any], u: Sequence[Any], by: Algebra
) -> list[Any]:
    """x0'', y0'' of a free rod, and phi'' of the links that move.

    given: parameters by name; q, u: coordinates and speeds in rodgen's order.
    """
    held, one, base = (
        rod.boundary_condition.first,
        by.real(1.0),
        2 * rod.boundary_condition.translates,
    )
    phi, omega, velocity = list(q[base:]), list(u[base:]), list(u[:base])
    m, l = given["mass"] / by.real(rod.n_links), given["length"] / by.real(rod.n_links)
    c, s = [by.cos(angle) for angle in phi], [by.sin(angle) for angle in phi]
    torque = _torques(rod, given, [*[given.get("clamp_angle")] * held, *phi], omega, m, l)
    forces = _drag(rod, given, phi, omega, velocity, by)
    start = one / (3 if rod.inertia == "uniform" else 2)
    half, fall = one / 2, given.get("gravity", 0.0) / l
    a11 = a12 = a22 = 0.0 * one
    fx, fy = _tail(rod, given, (c[-1], s[-1]), phi[-1], m * l, by)
    passed = []
    for i in reversed(range(len(phi))):
        if forces:
            fx, fy = fx - forces[i + 1][0], fy - forces[i + 1][1]
        square = omega[i] * omega[i]
        cx, cy = -square * c[i], -square * s[i]
        nx, ny = -s[i], c[i]
        if i < len(phi) - 1:
            wx, wy = a11 * nx + a12 * ny, a12 * nx + a22 * ny
            over = one / (start + nx * wx + ny * wy)
            fx, fy = fx + a11 * cx + a12 * cy, fy + a12 * cx + a22 * cy
            vx, vy = half * nx + wx, half * ny + wy
        else:  # nothing hangs on the last link
            over, vx, vy = one / start, half * nx, half * ny
        gx, gy = vx * over, vy * over
        z = torque[i] - nx * fx - ny * fy
        passed.append((nx, ny, cx, cy, gx, gy, z * over))
        a11, a12, a22 = one + a11 - vx * gx, a12 - vx * gy, one + a22 - vy * gy
        fx, fy = half * cx + fx + gx * z, half * cy + fy + gy * z
    if rod.boundary_condition.translates:
        if forces:
            fx, fy = fx - forces[0][0], fy - forces[0][1]
        over = one / (a11 * a22 - a12 * a12)
        ax, ay = (a12 * fy - a22 * fx) * over, (a12 * fx - a11 * fy) * over
        found = [l * ax, l * (ay - fall)]
    else:
        ax, ay = 0.0 * one, fall
        found = []
    for nx, ny, cx, cy, gx, gy, rest in reversed(passed):
        alpha = rest - gx * ax - gy * ay
        ax, ay = ax + alpha * nx + cx, ay + alpha * ny + cy
        found.append(alpha)
    return found


def _torques(
    rod: Structure,
    given: Mapping[str, Any],
    phi: Sequence[Any],
    omega: Sequence[Any],
    m: Any,
    l: Any,
) -> list[Any]:
    """Torques on the links that move, by springs and dampers; in m l^2. phi: of all links."""
    n, held = rod.n_links, rod.boundary_condition.first
    spring = given["bending_stiffness"] / (m * l * l * l)
    joints = [spring * (phi[i + 1] - phi[i]) for i in range(n - 1)]
    if "internal_damping" in given:
        drag = given["internal_damping"] / (l * l)
        rates = [*[None] * held, *omega]
        for i in range(n - 1):
            turn = rates[i + 1] - rates[i] if i >= held else rates[i + 1]
            joints[i] = joints[i] + drag * turn
    root: Any = 0.0
    if rod.boundary_condition.root:
        root = 2 * spring * (phi[0] - given["clamp_angle"])
        if "internal_damping" in given:
            root = root + 2 * drag * omega[0]
    before, after = [root, *joints], [*joints, 0.0]
    return [after[i] - before[i] for i in range(held, n)]


def _tail(
    rod: Structure, given: Mapping[str, Any], e: Pair, phi: Any, unit: Any, by: Algebra
) -> Pair:
    """Force that the loads at the tail take off there, in m l; e, phi: of the last link."""
    fx: Any = 0.0
    fy: Any = 0.0
    if "follower" in rod.terms:
        thrust, nu = given["follower_force"] / unit, given["follower_angle"]
        e = (by.cos(phi + nu), by.sin(phi + nu)) if nu else e
        fx, fy = thrust * e[0], thrust * e[1]
    if "tip_load" in rod.terms:
        fx, fy = fx - given["tip_force_x"] / unit, fy - given["tip_force_y"] / unit
    return fx, fy


def _drag(
    rod: Structure,
    given: Mapping[str, Any],
    phi: Sequence[Any],
    omega: Sequence[Any],
    velocity: Sequence[Any],
    by: Algebra,
) -> list[Pair]:
    """External damping at the joints of the links that move, in m l; velocity: of joint 0, empty
    where it is held.

    At joint i the force is -c_ext s_i a_i m_i v_i, where a_i is the share of the velocity v_i
    across the rod, whose angle there is the mean of the links that meet.
    """
    if "external_damping" not in rod.terms:
        return []
    held, l = rod.boundary_condition.first, given["length"] / rod.n_links
    vx, vy = velocity or (0.0, 0.0)
    found: list[Pair] = []
    for joint in range(len(phi) + 1):
        if joint:
            turn = l * omega[joint - 1]
            vx = vx - turn * by.sin(phi[joint - 1])
            vy = vy + turn * by.cos(phi[joint - 1])
        elif not velocity:
            found.append((0.0, 0.0))
            continue
        meet = phi[max(0, joint - 1) : joint + 1]
        angle, mass = sum(meet) / len(meet), len(meet) / 2
        across = by.abs(vy * by.cos(angle) - vx * by.sin(angle))
        factor = given["external_damping"] * given["fin_factor"][held + joint] * mass / l
        share = -factor * across / by.sqrt(by.or_one(vx * vx + vy * vy))
        found.append((share * vx, share * vy))
    return found
