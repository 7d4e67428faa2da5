"""The stability map and the bifurcation diagram of a sweep, as SVG in the colours of the page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any, NamedTuple

WIDTH, HEIGHT = 300, 130  # of a diagram, in units of the SVG
LEFT, RIGHT, TOP, BOTTOM = 44, 8, 18, 20  # around what is drawn
KINDS = {"hopf": "flutter begins", "branch": "branch point", "fold": "fold"}


class SweepPoint(NamedTuple):
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
    points: list[SweepPoint] = field(default_factory=list)

    @property
    def heights(self) -> tuple[float, float]:
        """Range of heights that is drawn."""
        found = [point.height for point in self.points] + [0.0]
        least, most = min(found), max(found)
        return (least, most) if most > least else (least - 1.0, most + 1.0)

    def position(self, point: SweepPoint) -> tuple[float, float]:
        """Position of a point in the SVG."""
        least, most = self.heights
        up = (point.height - least) / (most - least)
        return self.x_of(point.value), HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)

    def x_of(self, value: float) -> float:
        """Horizontal position of a value in the SVG."""
        return LEFT + (value - self.low) / (self.high - self.low) * (WIDTH - LEFT - RIGHT)

    def nearest(self, x: float, y: float) -> SweepPoint | None:
        """Point nearest to a place in the SVG; of a curve over all values, without states, the one
        below or above it."""

        def squared_distance(point: SweepPoint) -> float:
            across, down = self.position(point)
            return (across - x) ** 2 + ((down - y) ** 2 if point.state else 0.0)

        return min(self.points, key=squared_distance, default=None)


def diagrams_svg(
    diagrams: Sequence[Diagram],
    label: str,
    present: float | None,
    critical: float | None,
    special: Sequence[Sequence[Any]],
) -> str:
    """Draw diagrams below each other, with the present value, the critical one, special points."""
    parts = [
        f'<g transform="translate(0 {HEIGHT * number})">{"".join(_diagram_svg(one))}'
        f"{''.join(_marks_svg(one, present, critical, special))}</g>"
        for number, one in enumerate(diagrams)
    ]
    height = HEIGHT * len(diagrams)
    return (
        f'<svg class="rg-sweep" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{label}">'
        f"{''.join(parts)}</svg>"
    )


def _diagram_svg(one: Diagram) -> Iterator[str]:
    least, most = one.heights
    bottom = HEIGHT - BOTTOM
    yield f'<text x="{LEFT}" y="12">{one.title}</text>'
    yield f'<text class="end" x="{LEFT - 4}" y="{TOP + 4}">{most:.3g}</text>'
    yield f'<text class="end" x="{LEFT - 4}" y="{bottom}">{least:.3g}</text>'
    yield f'<text x="{LEFT}" y="{HEIGHT - 6}">{one.low:.4g}</text>'
    yield f'<text class="end" x="{WIDTH - RIGHT}" y="{HEIGHT - 6}">{one.high:.4g}</text>'
    zero = one.position(SweepPoint(one.low, 0.0, None))[1]
    yield f'<path class="axis" d="M{LEFT} {zero:.1f}H{WIDTH - RIGHT}M{LEFT} {TOP}V{bottom}"/>'
    before: list[SweepPoint] = []
    for stable, group in groupby(one.points, lambda point: point.stable):
        run = before + list(group)
        places = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(one.position, run))
        kind = "unknown" if stable is None else "stable" if stable else "unstable"
        yield f'<polyline class="{kind}" points="{places}"/>'
        before = run[-1:]


def _marks_svg(
    one: Diagram, present: float | None, critical: float | None, special: Sequence[Sequence[Any]]
) -> Iterator[str]:
    for value, kind in ((present, "present"), (critical, "critical")):
        if value is not None and one.low <= value <= one.high:
            x = one.x_of(value)
            yield f'<path class="{kind}" d="M{x:.1f} {TOP}V{HEIGHT - BOTTOM}"/>'
            if kind == "critical":
                side, x = ("end", x - 3) if x > WIDTH / 2 else ("", x + 3)
                yield f'<text class="{side}" x="{x:.1f}" y="{TOP + 8}">{value:.4g}</text>'
    for value, kind in special if one.points and one.points[0].state else ():
        near = min(one.points, key=lambda point: abs(point.value - value))
        x, y = one.position(near)
        words = f"{KINDS.get(kind, kind)} at {value:.5g}"
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4"><title>{words}</title></circle>'
