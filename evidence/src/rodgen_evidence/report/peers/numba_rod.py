"""Numba: the elimination of joint forces by blocks, written by hand in Python and compiled."""

from __future__ import annotations

from functools import partial
from math import cos, sin

import numpy as np
from numba import njit

from rodgen.arrays import Array
from rodgen_evidence.report.interleaved_timing import calls
from rodgen_evidence.report.peers.peer import Prepared, rod

NAMES = ("mass", "length", "bending_stiffness", "follower_force", "follower_angle")


def prepare(links: int) -> Prepared:
    """Compiled at the first call, for any number of links."""
    y, dy = np.zeros(2 * links + 4), np.empty(2 * links + 4)
    given, work = rod(links).parameters, np.empty((10, links))
    p = np.array([given[name] for name in NAMES])
    _rhs(0.0, y, p, dy, work)

    def rhs(given: Array) -> Array:
        y[:] = given
        _rhs(0.0, y, p, dy, work)
        return dy.copy()

    return Prepared(rhs, calls(partial(_rhs, 0.0, y, p, dy, work)))


@njit(error_model="numpy", fastmath={"contract"})  # as the flags of the C target
def _rhs(t, y, p, dy, work):  # type: ignore[no-untyped-def]  # numba types it
    c, s, torque, wx, wy, g11, g12, g21, g22, q = work[:10]
    n = len(c)
    m, l = p[0] / n, p[1] / n
    k = p[2] / l
    phi, omega, rates, alpha = y[2 : n + 2], y[n + 4 :], dy[n + 2 : n + 4], dy[n + 4 :]
    qx, qy = q, dy[n + 4 :]  # alpha[j] is written after qy[j] was read

    along, across = -p[3] * cos(p[4]), -p[3] * sin(p[4])
    before = 0.0
    for i in range(n):
        c[i], s[i] = cos(phi[i]), sin(phi[i])
        after = k * (phi[i + 1] - phi[i]) if i < n - 1 else 0.5 * l * across
        torque[i] = after - before
        before = after
        turn, swing = 6.0 / l * torque[i], 0.5 * m * l * omega[i] ** 2
        wx[i], wy[i] = -turn * s[i] - swing * c[i], turn * c[i] - swing * s[i]
    fx, fy = along * c[n - 1] - across * s[n - 1], along * s[n - 1] + across * c[n - 1]

    e11, e12, e22 = 3.0 * s[0] ** 2 - 1.0, -3.0 * s[0] * c[0], 3.0 * c[0] ** 2 - 1.0
    d11, d12, d22, rx, ry = e11 + 4.0, e12, e22 + 4.0, wx[0], wy[0]
    for j in range(1, n):
        e11, e12, e22 = 3.0 * s[j] ** 2 - 1.0, -3.0 * s[j] * c[j], 3.0 * c[j] ** 2 - 1.0
        d11, d12, d22 = d11 + e11, d12 + e12, d22 + e22
        rx, ry = rx + wx[j], ry + wy[j]
        if j == n - 1:
            rx, ry = rx - fx, ry - fy
        over = 1.0 / (d11 * d22 - d12 * d12)
        h11, h12 = d22 * e11 - d12 * e12, d22 * e12 - d12 * e22
        h21, h22 = d11 * e12 - d12 * e11, d11 * e22 - d12 * e12
        g11[j], g12[j], g21[j], g22[j] = over * h11, over * h12, over * h21, over * h22
        qx[j], qy[j] = over * (d22 * rx - d12 * ry), over * (d11 * ry - d12 * rx)
        d11 = e11 + 4.0 - over * (e11 * h11 + e12 * h21)
        d12 = e12 - over * (e11 * h12 + e12 * h22)
        d22 = e22 + 4.0 - over * (e12 * h12 + e22 * h22)
        rx, ry = wx[j] - (e11 * qx[j] + e12 * qy[j]), wy[j] - (e12 * qx[j] + e22 * qy[j])

    lx, ly = 0.0, 0.0
    for j in range(n - 1, -1, -1):
        bx = qx[j] - (g11[j] * lx + g12[j] * ly) if j else 0.0
        by = qy[j] - (g21[j] * lx + g22[j] * ly) if j else 0.0
        moment = torque[j] - 0.5 * l * (c[j] * (by + ly) - s[j] * (bx + lx))
        alpha[j] = 12.0 / (m * l * l) * moment
        if j:
            lx, ly = bx, by
    turn, swing = 0.5 * l * alpha[0], 0.5 * l * omega[0] ** 2
    rates[0] = -lx / m + turn * s[0] + swing * c[0]
    rates[1] = -ly / m - turn * c[0] + swing * s[0]
    dy[: n + 2] = y[n + 2 :]
