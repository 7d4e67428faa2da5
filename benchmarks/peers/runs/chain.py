"""The O(n) accelerations of a free uniform rod as scalar expressions, for symbols or numbers.

Joint by joint from the tail: the force in a joint is A a + b in the acceleration a of the joint
(forces in m l, accelerations in l), which eliminates the rate of the link before it,

    D = 1/3 + n A n,  v = n/2 + A n,  b' = b + A c,  z = torque - n b',  c = -omega^2 e,
    A <- 1 + A - v v/D,  b <- c/2 + b' + v z/D,

and back from the start, where no force is left: alpha = (z - v a)/D, a <- a + alpha n + c. With
some 27 products and quotients a link, 40 in the elimination of 2x2 blocks of forces: products are
what a Taylor series pays for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import rodgen


def accelerations(
    scene: rodgen.Scene,
    phi: Sequence[Any],
    omega: Sequence[Any],
    cos: Callable[[Any], Any],
    sin: Callable[[Any], Any],
    real: Callable[[float], Any] = float,
) -> list[Any]:
    """x0'', y0'', phi_0'', ...; real: what turns a parameter into the numbers reckoned with."""
    given = scene.parameters
    n, one = scene.rod.links, real(1.0)
    m, l = real(given["mass"]) / n, real(given["length"]) / n
    spring = real(given["bending_stiffness"]) / (m * l**3)
    drag = real(given.get("internal_damping", 0.0)) / l**2
    thrust = real(given["follower_force"]) / (m * l)
    c, s = [cos(angle) for angle in phi], [sin(angle) for angle in phi]
    joints = [spring * (phi[i + 1] - phi[i]) for i in range(n - 1)]
    if "internal_damping" in given:
        joints = [at + drag * (omega[i + 1] - omega[i]) for i, at in enumerate(joints)]
    torque = [(joints[i] if i < n - 1 else 0.0) - (joints[i - 1] if i else 0.0) for i in range(n)]
    third, half = one / 3, one / 2
    a11 = a12 = a22 = 0.0 * one
    bx, by = thrust * c[-1], thrust * s[-1]
    passed = []
    for i in reversed(range(n)):
        square = omega[i] * omega[i]
        cx, cy = -square * c[i], -square * s[i]
        nx, ny = -s[i], c[i]
        if i < n - 1:
            wx, wy = a11 * nx + a12 * ny, a12 * nx + a22 * ny
            over = one / (third + nx * wx + ny * wy)
            bx, by = bx + a11 * cx + a12 * cy, by + a12 * cx + a22 * cy
            vx, vy = half * nx + wx, half * ny + wy
        else:  # nothing hangs on the last link
            over, vx, vy = one / third, half * nx, half * ny
        gx, gy = vx * over, vy * over
        z = torque[i] - nx * bx - ny * by
        passed.append((nx, ny, cx, cy, gx, gy, z * over))
        a11, a12, a22 = one + a11 - vx * gx, a12 - vx * gy, one + a22 - vy * gy
        bx, by = half * cx + bx + gx * z, half * cy + by + gy * z
    over = one / (a11 * a22 - a12 * a12)
    ax, ay = (a12 * by - a22 * bx) * over, (a12 * bx - a11 * by) * over
    found = [l * ax, l * ay]
    for nx, ny, cx, cy, gx, gy, rest in reversed(passed):
        alpha = rest - gx * ax - gy * ay
        ax, ay = ax + alpha * nx + cx, ay + alpha * ny + cy
        found.append(alpha)
    return found
