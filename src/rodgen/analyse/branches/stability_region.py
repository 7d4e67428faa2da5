"""Outline of the stable region in a plane: boundaries of one motion after another, from corner to
corner."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from rodgen.analyse.branches.boundary_equations import BoundaryProblem, ParameterPlane
from rodgen.analyse.curves.continuation import StepControl, continue_curve
from rodgen.analyse.curves.curve import (
    Curve,
    CurvePoint,
    SpecialPoint,
    correct,
    follow_both_ways,
    point_at,
    resume_point,
)
from rodgen.analyse.curves.special_points import Chord
from rodgen.analyse.pencil import first_order_matrix
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

Ends = tuple[float, float]
Callback = Callable[[tuple[float, float, float]], None]
SLOW = -14.0  # logarithm of a frequency over that of the start, which is none
LIMIT = 1e-10  # of the units, a step: nothing changes any more
GROWS, ROUNDED = 1e-6, 1e-9  # of the modulus, and of the largest: less growth may be rounding
STILL = 1e-4  # of the largest, below which an eigenvalue beside a corner does not oscillate
EVERY = 10  # points of which all other motions are looked at
CORNERS = 20  # at most, on either side
ASIDE = 1e-3  # along a boundary, to see where it leads
# Of a unit tangent: what a cusp may leave of its part in the plane, and what stands still.
POINTED, STANDING = 1e-6, 1e-3
UNSTABLE = "another motion is unstable already"
TO_DIVERGENCE = "flutter becomes divergence, as its frequency goes to zero"
CORNER, SLOWEST, CUSP = "corner", "zero frequency", "cusp"


@dataclass(frozen=True)
class OutlineTracer:
    """Tracer of an outline. limits: bounds of both coordinates; callback: called at every point."""

    limits: list[Ends]
    steps: StepControl
    callback: Callback

    def trace(self, boundary: BoundaryProblem, omega: float, a: float, b: float) -> Curve:
        """Follow the outline to both sides of a point."""
        u = boundary.pack(omega or 1.0, a, b)
        boundary.adapt_to(u)
        row = np.append(np.zeros(len(u) - 1), 1.0)
        found = correct(boundary, u, row)

        def follow(way: float) -> Curve:
            boundary.adapt_to(found.u)  # after the other side, whose border may have another sign
            here = correct(boundary, found.u, row)
            return self._trace_on(boundary, point_at(boundary, here, way * row))

        return follow_both_ways(follow)

    def resume(self, boundary: BoundaryProblem, points: list[Array]) -> Curve:
        """Resume the outline from the first of these points, away from the second."""
        boundary.adapt_to(points[0])
        return self._trace_on(boundary, resume_point(boundary, points, "point of the boundary"))

    def _trace_on(self, boundary: BoundaryProblem, first: CurvePoint) -> Curve:
        """Follow the outline from a point along its tangent, through corners. Points of the result
        have both values, the frequency [Hz], and the length up to there."""
        whole = Curve()
        for _ in range(CORNERS):
            side = self._follow_side(boundary, first)
            corner, kind, omega = self._find_corner(boundary, side)
            if corner is not None:
                side.points.append(corner)
            begin = float(whole.points[-1].u[3]) if whole.points else 0.0
            told = _convert_side(boundary, side, begin)
            count = max(len(whole.points) - 1, 0)
            whole.points[-1:] = told.points
            whole.special += [one._replace(after=one.after + count) for one in told.special]
            whole.notes += told.notes
            whole.end, whole.complete = told.end, told.complete
            whole.interrupted = told.interrupted
            if corner is None or side.interrupted:
                break
            last = whole.points[-1].u
            whole.special.append(SpecialPoint(kind, last, len(whole.points) - 2, float(last[2])))
            try:
                boundary, first = self._start_next_side(boundary, corner, omega)
            except AnalysisError as error:
                whole.end = f"{kind}, beyond which the boundary was not found ({error})"
                break
        return whole

    def _follow_side(self, boundary: BoundaryProblem, first: CurvePoint) -> Curve:
        """Follow the boundary of one motion until another is unstable or a limit is reached."""
        (low, high), (least, largest) = self.limits
        before, count = first.u, 0

        def on_point(point: CurvePoint) -> None:
            self.callback(boundary.values(point.u))

        def stop_reason(curve: Curve) -> str:
            nonlocal before, count
            point, count = curve.points[-1], count + 1
            change = np.abs(point.u - before)
            before = point.u
            if not low <= point.u[-2] <= high:
                return f"{boundary.plane.keys[0]} leaves its range"
            if change[-2] < LIMIT and boundary.scales[1].damping and point.u[-1] > 1:
                return "the limit of much damping was reached"
            if len(point.u) > 2 and point.u[0] < SLOW and not boundary.scales[1].damping:
                return TO_DIVERGENCE
            if count % EVERY == 0 and has_other_growth(boundary, point.u):
                return UNSTABLE
            return ""

        side = continue_curve(
            boundary, first, least, largest, self.steps, callback=on_point, until=stop_reason
        )
        if not side.interrupted and has_other_growth(boundary, side.points[-1].u):
            side.end = UNSTABLE  # since they were looked at
        while len(side.points) > 1 and not low <= side.points[-1].u[-2] <= high:
            side.points.pop()
        if side.complete and side.points[-1].u[-1] == 0.0 and boundary.scales[1].damping:
            side.end = "the limit of vanishing damping was reached"
        return side

    def _find_corner(
        self, boundary: BoundaryProblem, side: Curve
    ) -> tuple[CurvePoint | None, str, float]:
        """Find the corner at the end of a side, and drop the points beyond it. Returns the corner,
        if any, its kind, and the frequency [rad/s] of the motion that begins to grow there."""
        if side.end == TO_DIVERGENCE:
            return side.points.pop(), SLOWEST, 0.0
        if side.end != UNSTABLE:
            return None, "", 0.0
        beyond = side.points[-1]
        while len(side.points) > 1 and has_other_growth(boundary, side.points[-1].u):
            beyond = side.points.pop()
        here = side.points[-1]
        boundary.adapt_to(here.u)
        try:
            corner = Chord(boundary, here, beyond).locate(lambda point: _margin(boundary, point.u))
        except AnalysisError:
            return None, "", 0.0
        omega = _next_frequency(boundary, _other_eigenvalues(boundary, corner.u))
        return corner, CORNER if omega or boundary.omega else SLOWEST, omega

    def _start_next_side(
        self, boundary: BoundaryProblem, corner: CurvePoint, omega: float
    ) -> tuple[BoundaryProblem, CurvePoint]:
        """Start the boundary of the other motion at a corner, in the direction in which the first
        motion no longer grows. Raises AnalysisError."""
        a, b, frequency = boundary.values(corner.u)
        plane, damped = boundary.plane, boundary.damped
        slow = not (omega or frequency)  # flutter begins with no frequency on divergence
        usual = float(np.abs(eigenvalues_at(plane, a, b)).max())
        other = BoundaryProblem(plane, boundary.scales, omega or usual * slow, damped)
        u = other.pack((omega or 1.0) * (np.exp(SLOW + 1) if slow else 1.0), a, b)
        if slow:
            u[0] = SLOW + 1
        other.adapt_to(u)
        last = np.eye(len(u))[0 if slow else -1]
        try:
            found = correct(other, u, last)
        except AnalysisError:
            last = np.eye(len(u))[-2]
            found = correct(other, u, last)
        first = point_at(other, found, last)
        ways = [first.tangent, -first.tangent]
        if slow:
            free = [way for way in ways if way[0] > 0]
        else:
            free = [way for way in ways if not has_other_growth(other, found.u + ASIDE * way)]
        if len(free) != 1:
            raise AnalysisError("which way the boundary goes on cannot be told")
        other.adapt_to(found.u)
        return other, point_at(other, found, other.weights * free[0])


def eigenvalues_at(plane: ParameterPlane, a: float, b: float) -> Any:
    """All eigenvalues [1/s] at a point of the plane."""
    return np.linalg.eigvals(
        first_order_matrix(*plane.matrices(a, b).parts, plane.n_added_states)
    ).astype(complex)


def _other_eigenvalues(boundary: BoundaryProblem, u: Array) -> Any:
    """Eigenvalues at a boundary point except those of the motion whose boundary it is."""
    a, b, frequency = boundary.values(u)
    s = eigenvalues_at(boundary.plane, a, b)
    omega = 2 * np.pi * frequency
    apart = np.minimum(np.abs(s - 1j * omega), np.abs(s + 1j * omega))
    # One that diverges; one that oscillates, and its conjugate; without damping two that meet.
    own = (2 if omega else 1) * (1 if boundary.damped else 2)
    return s[np.argsort(apart)[own:]]


def count_growing(s: Any) -> int:
    """Number of eigenvalues that grow beyond rounding."""
    return int((s.real > GROWS * np.abs(s) + ROUNDED * np.abs(s).max(initial=0.0)).sum())


def has_other_growth(boundary: BoundaryProblem, u: Array) -> bool:
    """Whether a motion grows at a boundary point other than the one whose boundary it is."""
    return count_growing(_other_eigenvalues(boundary, u)) > 0


def _margin(boundary: BoundaryProblem, u: Array) -> float:
    """Distance of all other motions from growing; negative where one grows."""
    s = _other_eigenvalues(boundary, u)
    if boundary.damped:
        return -float(s.real.max(initial=-np.inf))
    squares = s**2  # of undamped motions, in pairs
    squares = squares[np.argsort(squares.real)][::2] / np.abs(s).max() ** 2
    meeting = [float(((p - q) ** 2).real) for p, q in pairwise(squares)]
    return min([*meeting, -float(squares.real.max())])


def _next_frequency(boundary: BoundaryProblem, s: Any) -> float:
    """Frequency [rad/s] of that of other motions, of these eigenvalues, that is the next to grow;
    zero where it does not oscillate."""
    if boundary.damped:
        omega = abs(s[np.argmax(s.real)].imag)
        return float(omega) if omega >= STILL * np.abs(s).max() else 0.0
    # Without damping a square reaches zero, or two meet. Which it is their distances tell: four
    # eigenvalues at zero are known to the fourth root of a rounding alone.
    order = np.argsort((s**2).real)
    squares = (s[order] ** 2)[::2]
    apart = np.abs(np.diff(squares))
    if not len(apart) or np.abs(squares[-1]) < apart.min():
        return 0.0
    return float(abs(s[order[2 * int(np.argmin(apart))]].imag))


def _convert_side(boundary: BoundaryProblem, side: Curve, begin: float) -> Curve:
    """Convert a side to points of both values, frequency and length, and find its cusps."""
    steps = [boundary.length(b.u - a.u) for a, b in pairwise(side.points)]
    lengths = begin + np.cumsum([0.0, *steps])

    def values(u: Array, length: float) -> Array:
        return np.array([*boundary.values(u), length])

    points = [
        point._replace(u=values(point.u, length), tangent=np.zeros(4))
        for point, length in zip(side.points, lengths.tolist(), strict=True)
    ]
    special = []
    for after, (a, b) in enumerate(pairwise(side.points)):
        cusp = _find_cusp(boundary, a, b)
        if cusp is not None:
            u = values(cusp, float(lengths[after]))
            special.append(SpecialPoint(CUSP, u, after, float(u[2])))
    return replace(side, points=points, special=special)


def _find_cusp(boundary: BoundaryProblem, a: CurvePoint, b: CurvePoint) -> Array | None:
    """Find the cusp between two points, where the boundary reverses in the plane, if any."""
    before, after = a.tangent[-2:], b.tangent[-2:]
    # Next to zero frequency both numbers hardly change, whatever the frequency does.
    moved = min(np.linalg.norm(before), np.linalg.norm(after)) > STANDING
    if not (boundary.omega and before @ after < 0 and moved):
        return None
    way = (after - before) / np.linalg.norm(after - before)
    boundary.adapt_to(a.u)
    try:
        here = Chord(boundary, a, b).locate(lambda point: float(point.tangent[-2:] @ way))
    except AnalysisError:
        return None
    return here.u if np.linalg.norm(here.tangent[-2:]) < POINTED else None
