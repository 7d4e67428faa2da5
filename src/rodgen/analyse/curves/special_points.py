"""Special points of a curve between two of its points: folds, simple branch points, and those that
the problem itself finds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from rodgen.analyse.bordered import BorderedMatrix
from rodgen.analyse.curves.curve import (
    BRANCH,
    FOLD,
    NOISE,
    ContinuationProblem,
    CurvePoint,
    SpecialPoint,
    correct,
    point_at,
)
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

ITERATIONS = 30
CLOSE = 1e-12  # of the way between two points: a special point is known
ROUNDED = 1e-6  # of u: a correction that may be rounding, of long rods
NUDGE = 1e-5  # of u, of differences of the derivatives: their error slows Newton's method alone
WAYS = 3  # steps of inverse iteration
IMPERFECT = 1e-11  # of what is not in balance in a branch point: there is none
FAR = 2.0  # times the way between two points, from either


def find_special_points(
    problem: ContinuationProblem, a: CurvePoint, b: CurvePoint
) -> list[SpecialPoint]:
    """Find the special points between two points of a curve, in order. Raises AnalysisError if the
    signs of the two promise one that is not there, as between points of two branches."""
    found: list[SpecialPoint] = []
    if a.sign * b.sign < 0:
        found.append(locate_branch_point(problem, a, b))
    # In a branch point, which has no sign, a branch that is left may have a fold.
    if a.sign and a.tangent[-1] * b.tangent[-1] < 0:
        fold = Chord(problem, a, b).locate(lambda point: float(point.tangent[-1]))
        found.append(SpecialPoint(FOLD, fold.u))
    if a.unstable is not None and b.unstable is not None and a.unstable != b.unstable:
        found += problem.crossings(a, b)
    row = problem.weights * a.tangent
    return sorted(found, key=lambda one: float(row @ one.u))


class Chord:
    """The part of a curve between two points, by the share of the way along the tangent of the
    first."""

    def __init__(self, problem: ContinuationProblem, a: CurvePoint, b: CurvePoint):
        self.problem, self.a, self.b = problem, a, b
        self.row = problem.weights * a.tangent
        self.reach = float(self.row @ (b.u - a.u))

    def point(self, share: float) -> CurvePoint:
        """Find the point of the curve at a share (0 to 1) of the way."""
        a, b = self.a, self.b
        if share in (0, 1):
            return b if share else a
        # Along a cubic through both points and tangents.
        x, y = share, 1 - share
        h = self.reach
        guess = y * y * (1 + 2 * x) * a.u + x * x * (1 + 2 * y) * b.u
        along = b.tangent / max(float(self.row @ b.tangent), 1e-3)
        guess = guess + h * (x * y * y * a.tangent - x * x * y * along)
        return point_at(self.problem, correct(self.problem, guess, self.row), a.tangent)

    def locate(self, measure: Callable[[CurvePoint], float]) -> CurvePoint:
        """Find the point at which a test function that changes its sign is zero, to rounding.
        Raises AnalysisError."""
        try:
            share = brentq(lambda x: measure(self.point(x)), 0.0, 1.0, xtol=CLOSE, rtol=4 * CLOSE)
        except ValueError:
            raise AnalysisError("its measure has no change of sign") from None
        return self.point(float(share))


def locate_branch_point(problem: ContinuationProblem, a: CurvePoint, b: CurvePoint) -> SpecialPoint:
    """Find the simple branch point between two points, where the Jacobian loses a rank.

    With J bordered by a column and two rows, J^T psi + C^T g = 0, b psi = 1: g (2,) is zero where J
    has a rank less. Newton's method solves g = 0 on the two-dimensional surface F(u) + beta b = 0,
    on which beta is zero at a branch point of F. The derivatives of g are those of the quadratic
    form psi F''(v, v) in the plane of tangents v, whose zeros are both branches (W. Govaerts,
    Numerical Methods for Bifurcations of Dynamical Equilibria, SIAM 2000, ch. 3, 8). Raises
    AnalysisError where there is none.
    """
    near = a if abs(a.tangent[-1]) >= abs(b.tangent[-1]) else b
    rows, column = _borders(problem, near)
    u, beta = (a.u + b.u) / 2, 0.0
    reach, size, quick = problem.length(b.u - a.u), len(near.u), False
    before = np.inf
    for _ in range(ITERATIONS):
        F, J = problem.evaluate(u)
        factors = BorderedMatrix(J, rows, column[:, None])
        back = factors.solve(np.append(-(F + beta * column), [0.0, 0.0]))
        u, beta = u + back[:-1], beta + back[-1]
        if np.abs(back).max() > NOISE and not quick:
            quick = True
            continue
        quick = False
        V = factors.solve(np.vstack((np.zeros((size - 1, 2)), np.eye(2))))
        left = factors.solve(np.append(np.zeros(size), 1.0), transposed=True)
        psi, g = left[:-2], left[-2:]
        form = _quadratic_form(problem, u, psi, V[:-1])
        try:
            turn = np.linalg.solve(form, g)
        except np.linalg.LinAlgError:
            raise AnalysisError("the derivatives lose more than one rank") from None
        change = V @ turn
        u, beta = u + change[:-1], beta + change[-1]
        if not problem.length(u - near.u) < FAR * reach:
            raise AnalysisError("Newton's method leaves the branch")
        moved = float(np.abs(change[:-1]).max())
        settled, before = moved <= CLOSE or (moved < ROUNDED and moved >= before / 2), moved
        if settled:
            if abs(beta) > IMPERFECT:
                raise AnalysisError(f"two branches pass each other by {abs(beta):.1e}")
            return SpecialPoint(
                BRANCH, u, ways=_branch_tangents(problem, form, V[:-1], near.tangent)
            )
    raise AnalysisError("Newton's method does not converge")


def _borders(problem: ContinuationProblem, near: CurvePoint) -> tuple[Array, Array]:
    """Two border rows, the tangent and a second vector near the kernel of the Jacobian, and a
    border column near its left kernel."""
    row = problem.weights * near.tangent
    factors = BorderedMatrix(problem.evaluate(near.u)[1], row[None])
    x = y = np.cos(np.arange(len(row)) ** 2 / 7.0)
    for _ in range(WAYS):
        x, y = factors.solve(x), factors.solve(y, transposed=True)
        x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
    # Of what is measured in the length along the curve alone: long borders fill sparse factors.
    x, left = x * (problem.weights > 0), y[:-1] * (problem.weights[:-1] > 0)
    x, left = x - (x @ row) / (row @ row) * row, left / np.linalg.norm(left)
    return np.stack((row / np.linalg.norm(row), x / np.linalg.norm(x))), left


def _quadratic_form(problem: ContinuationProblem, u: Array, psi: Array, V: Array) -> Array:
    """Quadratic form psi F''(v, v) (2, 2) on the columns v of V, by differences of the Jacobian."""
    made = np.zeros((2, 2))
    for at, v in enumerate(V.T):
        step = NUDGE / np.abs(v).max() * v
        up, down = problem.evaluate(u + step)[1], problem.evaluate(u - step)[1]
        scale = np.abs(v).max() / (2 * NUDGE)
        made[at] = scale * (psi @ (up @ V) - psi @ (down @ V))
    return (made + made.T) / 2


def _branch_tangents(problem: ContinuationProblem, form: Array, V: Array, like: Array) -> Array:
    """Both unit tangents (2, N + 1) at a branch point, first the one closer to another tangent."""
    sizes, axes = np.linalg.eigh(form)
    if sizes[0] * sizes[1] >= 0:
        raise AnalysisError("no other branch crosses: its curvatures have one sign")
    first, second = np.sqrt(sizes[1]), np.sqrt(-sizes[0])
    ways = [V @ (axes @ [first, sign * second]) for sign in (1.0, -1.0)]
    ways = [way / problem.length(way) for way in ways]
    alike = [float(like @ (problem.weights * way)) for way in ways]
    if abs(alike[1]) > abs(alike[0]):
        ways, alike = ways[::-1], alike[::-1]
    return np.stack([way * (np.sign(part) or 1.0) for way, part in zip(ways, alike, strict=True)])
