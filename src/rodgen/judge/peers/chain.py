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

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import rodgen

KNOWN = ("follower", "gravity", "internal_damping", "tip_load")
Pair = tuple[Any, Any]
Function = Callable[[Any], Any]


def accelerations(
    scene: rodgen.Scene,
    given: Mapping[str, Any],
    phi: Sequence[Any],
    omega: Sequence[Any],
    cos: Function,
    sin: Function,
    real: Function = float,
    forces: Sequence[Pair] = (),
) -> list[Any]:
    """x0'', y0'' of a free rod, and phi'' of the links that move.

    given: parameters by name; phi, omega: of the links that move; real: what turns a parameter
    into the numbers reckoned with; forces: further ones at the joints of these links, in m l.
    """
    held, one = scene.held, real(1.0)
    m, l = given["mass"] / real(scene.rod.links), given["length"] / real(scene.rod.links)
    c, s = [cos(angle) for angle in phi], [sin(angle) for angle in phi]
    torque = _torques(scene, given, [*[given.get("clamp_angle")] * held, *phi], omega, m, l)
    start = one / (3 if scene.rod.inertia == "uniform" else 2)
    half, fall = one / 2, given.get("gravity", 0.0) / l
    a11 = a12 = a22 = 0.0 * one
    bx, by = _tail(scene, given, (c[-1], s[-1]), _turn(phi[-1], cos, sin), m * l)
    passed = []
    for i in reversed(range(len(phi))):
        if forces:
            bx, by = bx - forces[i + 1][0], by - forces[i + 1][1]
        square = omega[i] * omega[i]
        cx, cy = -square * c[i], -square * s[i]
        nx, ny = -s[i], c[i]
        if i < len(phi) - 1:
            wx, wy = a11 * nx + a12 * ny, a12 * nx + a22 * ny
            over = one / (start + nx * wx + ny * wy)
            bx, by = bx + a11 * cx + a12 * cy, by + a12 * cx + a22 * cy
            vx, vy = half * nx + wx, half * ny + wy
        else:  # nothing hangs on the last link
            over, vx, vy = one / start, half * nx, half * ny
        gx, gy = vx * over, vy * over
        z = torque[i] - nx * bx - ny * by
        passed.append((nx, ny, cx, cy, gx, gy, z * over))
        a11, a12, a22 = one + a11 - vx * gx, a12 - vx * gy, one + a22 - vy * gy
        bx, by = half * cx + bx + gx * z, half * cy + by + gy * z
    if scene.hold.translates:
        if forces:
            bx, by = bx - forces[0][0], by - forces[0][1]
        over = one / (a11 * a22 - a12 * a12)
        ax, ay = (a12 * by - a22 * bx) * over, (a12 * bx - a11 * by) * over
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
    scene: rodgen.Scene,
    given: Mapping[str, Any],
    phi: Sequence[Any],
    omega: Sequence[Any],
    m: Any,
    l: Any,
) -> list[Any]:
    """On the links that move, by springs and dampers; in m l^2. phi: of all links."""
    n, held = scene.rod.links, scene.held
    spring = given["bending_stiffness"] / (m * l * l * l)
    joints = [spring * (phi[i + 1] - phi[i]) for i in range(n - 1)]
    if "internal_damping" in given:
        drag = given["internal_damping"] / (l * l)
        rates = [*[None] * held, *omega]
        for i in range(n - 1):
            turn = rates[i + 1] - rates[i] if i >= held else rates[i + 1]
            joints[i] = joints[i] + drag * turn
    root: Any = 0.0
    if scene.hold.root_spring:
        root = 2 * spring * (phi[0] - given["clamp_angle"])
        if "internal_damping" in given:
            root = root + 2 * drag * omega[0]
    before, after = [root, *joints], [*joints, 0.0]
    return [after[i] - before[i] for i in range(held, n)]


def _tail(
    scene: rodgen.Scene,
    given: Mapping[str, Any],
    e: Pair,
    turned: Callable[[float], Pair],
    unit: Any,
) -> Pair:
    """What the loads at the tail take off the force there, in m l; e: along the last link."""
    bx: Any = 0.0
    by: Any = 0.0
    if "follower" in scene.structure.terms:
        thrust, nu = given["follower_force"] / unit, given["follower_angle"]
        e = turned(nu) if nu else e
        bx, by = thrust * e[0], thrust * e[1]
    if "tip_load" in scene.structure.terms:
        bx, by = bx - given["tip_force_x"] / unit, by - given["tip_force_y"] / unit
    return bx, by


def _turn(angle: Any, cos: Function, sin: Function) -> Callable[[float], Pair]:
    return lambda nu: (cos(angle + nu), sin(angle + nu))
