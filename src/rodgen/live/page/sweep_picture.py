"""The stability map and the bifurcation diagram of a sweep, as SVG in the colours of the page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any, NamedTuple

WIDTH, HEIGHT = 300, 130  # of a diagram, in units of the SVG
LEFT, RIGHT, TOP, BOTTOM = 44, 8, 18, 20  # around what is drawn
KINDS = {"hopf": "flutter begins", "branch": "branch point", "fold": "fold"}


class Point(NamedTuple):
    """A point of a diagram; stable: None where that is not known; state: the equilibrium."""

    value: float
    height: float
    stable: bool | None
    state: Sequence[float] = ()


@dataclass
class Diagram:
    """Points along a curve over a number of the scene, between two values of that."""

    title: str
    low: float
    high: float
    points: list[Point] = field(default_factory=list)

    @property
    def heights(self) -> tuple[float, float]:
        """Between which heights it is drawn."""
        found = [point.height for point in self.points] + [0.0]
        least, most = min(found), max(found)
        return (least, most) if most > least else (least - 1.0, most + 1.0)

    def at(self, point: Point) -> tuple[float, float]:
        """Where a point is in the SVG."""
        least, most = self.heights
        up = (point.height - least) / (most - least)
        return self.across(point.value), HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)

    def across(self, value: float) -> float:
        """Where a value is, from left to right."""
        return LEFT + (value - self.low) / (self.high - self.low) * (WIDTH - LEFT - RIGHT)

    def nearest(self, x: float, y: float) -> Point | None:
        """The point that is nearest to a place in the SVG; of a curve over all values, without
        states, the one below or above it."""

        def far(point: Point) -> float:
            across, down = self.at(point)
            return (across - x) ** 2 + ((down - y) ** 2 if point.state else 0.0)

        return min(self.points, key=far, default=None)


def picture(
    diagrams: Sequence[Diagram],
    label: str,
    present: float | None,
    critical: float | None,
    special: Sequence[Sequence[Any]],
) -> str:
    """Diagrams below each other, with the present value, the critical one and special points."""
    parts = [
        f'<g transform="translate(0 {HEIGHT * number})">{"".join(_diagram(one))}'
        f"{''.join(_lines(one, present, critical, special))}</g>"
        for number, one in enumerate(diagrams)
    ]
    height = HEIGHT * len(diagrams)
    return (
        f'<svg class="rg-sweep" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{label}">'
        f"{''.join(parts)}</svg>"
    )


def _diagram(one: Diagram) -> Iterator[str]:
    least, most = one.heights
    bottom = HEIGHT - BOTTOM
    yield f'<text x="{LEFT}" y="12">{one.title}</text>'
    yield f'<text class="end" x="{LEFT - 4}" y="{TOP + 4}">{most:.3g}</text>'
    yield f'<text class="end" x="{LEFT - 4}" y="{bottom}">{least:.3g}</text>'
    yield f'<text x="{LEFT}" y="{HEIGHT - 6}">{one.low:.4g}</text>'
    yield f'<text class="end" x="{WIDTH - RIGHT}" y="{HEIGHT - 6}">{one.high:.4g}</text>'
    zero = one.at(Point(one.low, 0.0, None))[1]
    yield f'<path class="axis" d="M{LEFT} {zero:.1f}H{WIDTH - RIGHT}M{LEFT} {TOP}V{bottom}"/>'
    before: list[Point] = []
    for stable, group in groupby(one.points, lambda point: point.stable):
        run = before + list(group)
        places = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(one.at, run))
        kind = "unknown" if stable is None else "stable" if stable else "unstable"
        yield f'<polyline class="{kind}" points="{places}"/>'
        before = run[-1:]


def _lines(
    one: Diagram, present: float | None, critical: float | None, special: Sequence[Sequence[Any]]
) -> Iterator[str]:
    for value, kind in ((present, "present"), (critical, "critical")):
        if value is not None and one.low <= value <= one.high:
            x = one.across(value)
            yield f'<path class="{kind}" d="M{x:.1f} {TOP}V{HEIGHT - BOTTOM}"/>'
            if kind == "critical":
                side, x = ("end", x - 3) if x > WIDTH / 2 else ("", x + 3)
                yield f'<text class="{side}" x="{x:.1f}" y="{TOP + 8}">{value:.4g}</text>'
    for value, kind in special if one.points and one.points[0].state else ():
        near = min(one.points, key=lambda point: abs(point.value - value))
        x, y = one.at(near)
        words = f"{KINDS.get(kind, kind)} at {value:.5g}"
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4"><title>{words}</title></circle>'
