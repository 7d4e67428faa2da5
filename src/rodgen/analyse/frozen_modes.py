"""Modes about any shape, as if the rod stood still in it; what of eigenvalues is a mode."""

from __future__ import annotations

from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.eigenvalues import Complex
from rodgen.arrays import Array

STILL = 1e-7  # of the modulus: a real part below it is rounding
GONE = 2 * np.pi / np.log(1e16)  # of the decay: a slower oscillation is rounding after a period
UNSEEN = 1e-5  # rad over the span of a run: slower motions are rounding
NUDGE = 1e-6  # rad, of the differences by which shapes are drawn: errors are its square


def select_modes(s: Complex, count: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Flags of eigenvalues that oscillate before they have died away; numbers of the lowest
    ``count`` of them and of all that grow, by frequency."""
    moves = s.imag > np.maximum(STILL * np.abs(s), -GONE * s.real)
    grows = (s.real > STILL * np.abs(s)) & (s.imag >= 0)  # a pair once
    kept = np.flatnonzero(moves | grows)
    kept = kept[np.argsort(s[kept].imag, kind="stable")]
    return moves, kept[(np.arange(len(kept)) < count) | grows[kept]]


def joint_displacements(
    model: ModuleType, y: Array, p: Array, q: Complex
) -> tuple[Complex, NDArray[np.complex128]]:
    """Displacements (k, n+1, 2) of joints for small changes (k, coordinates) of the positions of a
    state, and the largest component of each (k,)."""

    def displacements(part: Array) -> Array:
        sides = np.tile(y, (2, len(q), 1))
        sides[..., : q.shape[1]] += NUDGE * np.array((part, -part))
        up, down = (model.joints(side, p) for side in sides)
        return np.asarray((up - down) / (2 * NUDGE))

    moved = displacements(q.real) + 1j * displacements(q.imag)
    flat = moved.reshape(len(q), moved[0].size if len(q) else 1)
    return moved, flat[np.arange(len(q)), np.abs(flat).argmax(axis=1)]


class FrozenMotions(NamedTuple):
    """Small motions about a shape in which a rod is taken to stand still, y = Re(q exp(s t)).

    s: (k,) [1/s], by frequency; q: (k, coordinates), shapes as changes of the coordinates;
    displacements: (k, n+1, 2), of the joints, the largest 1; still: number of motions at no rate,
    which are left out; overdamped: number of those without oscillation, which are left out too;
    accelerations: (coordinates,), at rest there, which are left out.
    """

    s: Complex
    q: Complex
    displacements: Complex
    still: int
    overdamped: int
    accelerations: Array


def frozen_motions(
    model: ModuleType, t: float, y: Array, p: Array, count: int, span: float
) -> FrozenMotions:
    """Compute the ``count`` motions of lowest frequency, and all that grow, about the positions of
    a state y (states,) at time t [s], by all eigenvalues of the module's Jacobian at rates of zero.
    Forces that drive the rod away from there are left out. span: of a run [s], in which a motion
    is seen."""
    half = (len(y) - len(getattr(model, "STATES", ()))) // 2
    at = y.copy()
    at[half : 2 * half] = 0.0
    s, vectors = np.linalg.eig(np.asarray(model.jac(t, at, p)))
    moving = np.abs(s) > max(STILL * np.abs(s).max(initial=0.0), UNSEEN / span)
    s, vectors = s[moving].astype(complex), vectors[:half, moving]
    moves, kept = select_modes(s, count)
    q = vectors[:, kept].T.astype(complex)
    q /= np.abs(q).max(axis=1, keepdims=True)
    moved, largest = joint_displacements(model, at, p, q)
    return FrozenMotions(
        s[kept],
        q / largest[:, None],
        moved / largest[:, None, None],
        still=int((~moving).sum()) // 2,
        overdamped=int((~moves & (s.imag >= 0) & (s.real < -STILL * np.abs(s))).sum()),
        accelerations=model.rhs(t, at, p)[half : 2 * half],
    )
