"""Beck's column with a tip mass as a continuum in a few shapes: Galerkin's method, to third order.

The column is clamped, inextensible, of unit length, mass and stiffness: w(s, t) = sum q_i shape_i
across, sin(theta) = w', and a body of mass mu and moment of inertia beta at the tip, pushed by a
force P that follows it. With the axial velocity from w, the energies are, to fourth order,

  T = 1/2 int w_t^2 + 1/2 int u_t^2 + mu/2 (w_t^2 + u_t^2)(1) + beta/2 (w'_t^2 (1 + w'^2))(1),
  V = 1/2 int w''^2 (1 + w'^2),  u = -1/2 int_0^s w'^2.

Bending is damped by tau times the rate of curvature, motion across the clamp axis by c per length.
The equations are odd, so that no quadratic terms count, and the normal form of a Hopf point is
z' = s z + k z |z|^2 with k from the third order alone. Nothing of rodgen is used here: it is
another way to the same numbers, without links.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
import scipy.linalg
from numpy.polynomial import Legendre, legendre
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]
Damping = Literal["curvature", "deflection"]
POINTS = 32  # Gauss points: exact for the products of four polynomials to degree 15
PHASES = 8  # instants of a period, from which a third harmonic does not pass for the first
FORCES = np.linspace(0.5, 60.0, 120)


@dataclass(frozen=True)
class Shapes:
    """Shape functions of w, clamped at s = 0.

    values: at the Gauss points, (shapes, points), with two derivatives by s; tip, slope: at the
    tip.
    """

    values: tuple[Array, Array, Array]
    tip: Array
    slope: Array


def polynomials(count: int) -> Shapes:
    """Shapes whose second derivatives are Legendre polynomials: eight are as good as all."""
    bent = [Legendre.basis(k, domain=[0, 1]) for k in range(count)]
    turned = [one.integ(lbnd=0) for one in bent]
    moved = [one.integ(lbnd=0) for one in turned]
    at = [np.array([one(POINT) for one in every]) for every in (moved, turned, bent)]
    ends = [np.array([float(one(1.0)) for one in every]) for every in (moved, turned)]
    return Shapes((at[0], at[1], at[2]), *ends)


def bare(count: int) -> Shapes:
    """The first modes of the column without load and tip mass."""
    full = polynomials(count + 16)
    return _combine(full, (full.values[0] * WEIGHT) @ full.values[0].T, count)


def own(count: int, mass: float, inertia: float) -> Shapes:
    """The first modes of the column without load, with its tip mass."""
    full = polynomials(count + 16)
    M = (full.values[0] * WEIGHT) @ full.values[0].T
    M += mass * np.outer(full.tip, full.tip) + inertia * np.outer(full.slope, full.slope)
    return _combine(full, M, count)


def _combine(full: Shapes, M: Array, count: int) -> Shapes:
    stiffness = (full.values[2] * WEIGHT) @ full.values[2].T
    V = scipy.linalg.eigh(stiffness, M)[1][:, :count].T
    moved, turned, bent = (V @ one for one in full.values)
    return Shapes((moved, turned, bent), V @ full.tip, V @ full.slope)


def _points() -> tuple[Array, Array, Array]:
    """Gauss points on [0, 1], their weights, and the matrix of integrals from 0 to each."""
    x, weight = legendre.leggauss(POINTS)
    integrals = [legendre.legval(x, legendre.legint(one, lbnd=-1)) for one in np.eye(POINTS)]
    until = np.array(integrals).T @ np.linalg.inv(legendre.legvander(x, POINTS - 1)) / 2
    return (x + 1) / 2, weight / 2, until


POINT, WEIGHT, UNTIL = _points()


@dataclass(frozen=True)
class FlutterOnset:
    """Onset of flutter: force, frequency; turn: how much force cycles need beyond it for the
    square of half their largest angle [rad^2]. Below 0, they lie before it: subcritical."""

    force: float
    frequency: float
    turn: float


@dataclass(frozen=True)
class GalerkinColumn:
    """Column discretised by Galerkin's method; numbers as in the docstring of this module.

    damping: whether tau works on the rate of curvature, as in a material, or on the rate of w'', as
    in equations that are linear in it; along: whether c resists the motion along the clamp axis as
    well.
    """

    shapes: Shapes
    mass: float
    inertia: float
    external: float
    internal: float
    damping: Damping = "curvature"
    along: bool = False

    @cached_property
    def M(self) -> Array:
        across, tip, slope = self.shapes.values[0], self.shapes.tip, self.shapes.slope
        M = (across * WEIGHT) @ across.T + self.mass * np.outer(tip, tip)
        return np.asarray(M + self.inertia * np.outer(slope, slope))

    @cached_property
    def stiffness(self) -> Array:
        bent = self.shapes.values[2]
        return np.asarray((bent * WEIGHT) @ bent.T)

    @cached_property
    def D(self) -> Array:
        across = self.shapes.values[0]
        return np.asarray(
            self.internal * self.stiffness + self.external * (across * WEIGHT) @ across.T
        )

    @cached_property
    def thrust(self) -> Array:
        """The share of the stiffness that goes with the force."""
        turned = self.shapes.values[1]
        follows = np.outer(self.shapes.tip, self.shapes.slope)
        return np.asarray(follows - (turned * WEIGHT) @ turned.T)

    def growing(self, force: float) -> complex:
        """The eigenvalue of the oscillation that grows most; of none, -1."""
        n = len(self.M)
        pushed = self.stiffness + force * self.thrust
        back = -np.linalg.solve(self.M, np.hstack([pushed, self.D]))
        s = np.linalg.eigvals(np.vstack([np.eye(n, 2 * n, n), back]))
        s = s[s.imag > 1e-6]
        return complex(s[s.real.argmax()]) if len(s) else -1.0 + 0.0j

    def onset(self) -> FlutterOnset:
        """The first Hopf point. Raises ValueError where there is none."""
        before = self.growing(float(FORCES[0])).real
        for low, high in pairwise(FORCES.tolist()):
            after = self.growing(high).real
            if before < 0 < after:
                root = brentq(lambda P: self.growing(P).real, low, high, xtol=1e-12)
                return self._at(float(root))
            before = after
        raise ValueError("no flutter in the range")

    def _at(self, force: float) -> FlutterOnset:
        w = self.growing(force).imag
        dynamic = -(w**2) * self.M + 1j * w * self.D + self.stiffness + force * self.thrust
        left, _, right = scipy.linalg.svd(dynamic)
        p, v = left[:, -1].conj(), right[-1].conj()
        angles = np.append(v @ self.shapes.values[1], v @ self.shapes.slope)
        v = v / angles[np.abs(angles).argmax()]
        third = np.zeros(len(v), complex)
        for phase in np.exp(2j * np.pi * np.arange(PHASES) / PHASES):
            q, rate = 2 * (v * phase).real, 2 * (1j * w * v * phase).real
            third += self.third(force, q, rate, -(w**2) * q) * phase.conj() / PHASES
        # Both over p (2 i w M + D) v, of which the turn keeps nothing but the direction.
        unit = p @ (2j * w * self.M + self.D) @ v
        coefficient, slope = -(p @ third) / unit, -(p @ self.thrust @ v) / unit
        return FlutterOnset(force, w, float(-coefficient.real / slope.real))

    def third(self, force: float, q: Array, rate: Array, second: Array) -> Array:
        """The terms of third order of the equations, on the side of M, for q and its derivatives
        by time (shapes,)."""
        _, turned, bent = self.shapes.values
        slope = self.shapes.slope
        a, a1, a2 = q @ turned, rate @ turned, second @ turned
        b, b1 = q @ bent, rate @ bent
        end, end1, end2 = q @ slope, rate @ slope, second @ slope
        along = -(UNTIL @ (a * turned).T).T  # derivatives of u by q
        whole = -(turned * WEIGHT) @ a
        r = along @ (WEIGHT * -(UNTIL @ (a1**2 + a * a2)))
        r += self.mass * whole * -(WEIGHT @ (a1**2 + a * a2))
        r += self.inertia * (end2 * end**2 + end * end1**2) * slope
        r += (bent * WEIGHT) @ (b * a**2) + (turned * WEIGHT) @ (b**2 * a)
        r -= force * ((turned * WEIGHT) @ (a**3 / 2) + end**2 / 2 * whole)
        if self.along:
            r += self.external * along @ (WEIGHT * -(UNTIL @ (a * a1)))
        if self.damping == "curvature":
            r += self.internal * ((bent * WEIGHT) @ (b1 * a**2 + b * a * a1))
            r += self.internal * ((turned * WEIGHT) @ (b1 * b * a))
        return np.asarray(r)
