"""Small motions of a rod in flight by its angle of attack, without the turn of rod and path
together, which no force resists."""

from __future__ import annotations

import numpy as np
from scipy.linalg import null_space

from rodgen.analyse.pencil import DensePencil


def attack_pencil(flight: DensePencil, airspeed: float) -> DensePencil:
    """Pencil of bending, of the angle of attack a and of the rate of turning r.

    flight: the pencil of the displacement of joint 0 across the rod, of all angles and of added
    states, in which neither a displacement nor a turn of rod and path is resisted; airspeed [m/s].

    Motions are a displacement z, a turn about the centre of gravity and bending, orthogonal in the
    mass matrix. With z' = V (a - turn) and r = turn' the displacement and the turn themselves no
    longer occur, and their equations are of first order: they become added states, the first ones.
    """
    own = flight.size - flight.added
    turn = np.ones(own)
    turn[0] = -flight.S2[0, 1:own].sum() / flight.S2[0, 0]
    rigid = np.stack((turn, np.eye(own)[0]))
    bending = null_space(rigid @ flight.S2[:own, :own])
    K, C, M = flight.project(np.column_stack((bending, rigid.T))).parts
    k = own - 2
    r, a, rest = slice(k, k + 1), slice(k + 1, k + 2), slice(k + 2, None)
    whole = np.hstack((K[:, :k], C[:, r] - airspeed * M[:, a], airspeed * C[:, a], K[:, rest]))
    damping = np.hstack((C[:, :k], M[:, r], airspeed * M[:, a], C[:, rest]))
    sizes = np.ones(len(K))
    sizes[r], sizes[a] = M[r, r], airspeed * M[a, a]
    inertia = np.zeros_like(M)
    inertia[:k, :k] = M[:k, :k]
    return DensePencil(
        whole / sizes[:, None], damping / sizes[:, None], inertia, added=flight.added + 2
    )
