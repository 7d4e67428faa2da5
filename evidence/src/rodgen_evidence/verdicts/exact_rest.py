"""Rest of a chain by Newton's method, first in floating point and then in 50 digits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from mpmath import mpf

from rodgen_evidence.verdicts.chain_loads import rates
from rodgen_evidence.verdicts.digits import FIFTY, FLOAT, Vector
from rodgen_evidence.verdicts.link_chain import LinkChain, Table

NUDGE = 1e-6  # of differences in floating point: they start a chord method alone
ITERATIONS, CHORDS = 20, 60
FARTHEST = 0.15  # rad or m, by which a rest may move in a step
MISSED = 0.01  # rad or m, by which a tangent may miss
SURE = 1e-4  # of the way: a sign that changes over it does so at a branch point
LEAST = 1e-7  # of the way, the smallest step
FOUND, EXACT = 1e-9, 1e-40  # the last correction, of angles and places
SINGULAR = 1e-11  # of the largest singular value: what nothing holds


class ChainFoldError(Exception):
    """Lack of a rest next to the last one; where: on the way, or at which load; z: the last one."""

    def __init__(self, where: float, z: Any = None):
        super().__init__(f"no rest beyond {where:.6g}")
        self.where, self.z = where, z


class ExactRest(NamedTuple):
    """The coordinates and added states of a chain at rest or in steady straight acceleration;
    stiffness: smallest singular value over the largest, in those that something holds."""

    z: Any
    stiffness: float


def state(chain: LinkChain, z: Any) -> Vector:
    """A state with these coordinates and added states, without rates."""
    zero = chain.numbers.of(0)
    return [*z[: chain.size], *[zero] * chain.size, *z[chain.size :]]


def residual(chain: LinkChain, z: Any) -> Vector:
    """Accelerations and rates of added states."""
    return rates(chain, state(chain, z))[chain.size :]


def slope(chain: LinkChain, z: Any) -> Any:
    """Derivatives of the residual in floating point."""
    steps = NUDGE * np.eye(len(z))
    pairs = [(residual(chain, z + d), residual(chain, z - d)) for d in steps]
    return np.array([np.subtract(a, b) / (2 * NUDGE) for a, b in pairs]).T


def kept(chain: LinkChain, J: Any) -> Any:
    """Numbers of the coordinates that something holds: joint 0 moves freely where nothing does."""
    free = np.abs(J).max(axis=0) <= 1e-8 * np.abs(J).max(initial=0.0)
    return [i for i in range(len(J)) if not (i < chain.base and free[i])]


def newton(chain: LinkChain, z: Any) -> Any:
    """The rest next to a state, None where there is none so near."""
    first = z
    for _ in range(ITERATIONS):
        J = slope(chain, z)
        own = kept(chain, J)
        by = np.zeros(len(z))
        g = np.array(residual(chain, z))[own]
        by[own] = np.linalg.lstsq(J[np.ix_(own, own)], -g, rcond=SINGULAR)[0]
        z = z + by
        moved = np.abs(z - first)[: chain.size]
        if not np.isfinite(z).all() or moved.max(initial=0.0) > FARTHEST:
            return None
        if np.abs(by).max(initial=0.0) < FOUND:
            return z
    return None


def follow(table: Callable[[float], Table], z: Any, longest: float = 0.1) -> Any:
    """The rest at the end of a way from 0 to 1 that begins near z, in steps up to the longest.
    Raises FoldError.

    A step is short where the tangent misses its end, and where the determinant changes its sign: at
    a fold, since no rest follows; at a branch point until the tangent leads on.
    """
    chain = LinkChain(table(0.0), FLOAT)
    found = newton(chain, np.asarray(z, dtype=float))
    if found is None:
        raise ChainFoldError(0.0)
    z, done, step, slant = found, 0.0, longest, np.zeros(len(found))
    sign = _sign(chain, z)
    if newton(LinkChain(table(1.0), FLOAT), z) is not None and _still(table, z):
        return z
    while done < 1:
        there = min(done + step, 1.0)
        guess = z + slant * (there - done)
        chain = LinkChain(table(there), FLOAT)
        near = np.abs(guess - z).max(initial=0.0) < FARTHEST
        found = newton(chain, guess) if near else None
        if found is not None:
            missed = np.abs(found - guess)[: chain.size].max(initial=0.0)
            turned = _sign(chain, found)
            sure = turned == sign or (step < SURE and missed < step)
            if missed < MISSED and sure:
                slant = (found - z) / (there - done)
                z, done, step, sign = found, there, min(2 * step, longest), turned
                continue
        step /= 2
        if step < LEAST:
            raise ChainFoldError(done, z)
    return z


def stiffness(chain: LinkChain, z: Any) -> Any:
    """Derivatives of the residual in what something holds."""
    J = slope(chain, np.asarray(z, dtype=float))
    own = kept(chain, J)
    return J[np.ix_(own, own)]


def _sign(chain: LinkChain, z: Any) -> float:
    """The sign of the determinant of the stiffness."""
    return float(np.linalg.slogdet(stiffness(chain, z))[0])


def _still(table: Callable[[float], Table], z: Any) -> bool:
    """Whether a straight rod rests all the way."""
    chain = LinkChain(table(0.5), FLOAT)
    angles = z[chain.base : chain.size]
    if np.ptp(np.append(angles, [chain.axis] * chain.held)) > 1e-13:
        return False
    found = newton(chain, z)
    return found is not None and float(np.abs(found - z).max(initial=0.0)) < 1e-13


def refine(table: Table, z: Any) -> ExactRest:
    """Refine a rest to 50 digits. Raises ChainFoldError where it is none."""
    chain, rough = LinkChain(table, FIFTY), LinkChain(table, FLOAT)
    J = slope(rough, np.asarray(z, dtype=float))
    own = kept(rough, J)
    J = J[np.ix_(own, own)]
    sizes = np.linalg.svd(J, compute_uv=False)
    inverse = np.linalg.pinv(J, rcond=SINGULAR)
    z = [mpf(float(v)) for v in z]
    for _ in range(CHORDS):
        g = residual(chain, z)
        scale = max([abs(v) for at, v in enumerate(g) if at in own], default=mpf(0))
        if not scale:
            break
        by = -inverse @ np.array([float(g[i] / scale) for i in own])
        for i, change in zip(own, by, strict=True):
            z[i] += scale * mpf(float(change))
        if scale * float(np.abs(by).max()) < EXACT:
            break
    else:
        raise ChainFoldError(0.0)
    return ExactRest(z, float(sizes.min(initial=np.inf) / sizes.max(initial=1.0)))
