"""Diagrams of a sweep as plots of the page: a curve over the number that is swept, solid where the
rod is stable and dashed where it is not."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

SERIES = "stable", "not stable"


class SweepPoint(NamedTuple):
    """A point of a diagram; stable: None where that is not known; state: the equilibrium."""

    value: float
    height: float
    stable: bool | None
    state: Sequence[float] = ()


@dataclass
class Diagram:
    """Points along a curve. id: of the plot; up, over: label and unit of the axes; take: called
    with a point that was clicked; marks: values that are marked, and words for each."""

    id: str
    up: tuple[str, str]
    over: tuple[str, str]
    take: Callable[[SweepPoint], Coroutine[Any, Any, None]]
    points: list[SweepPoint] = field(default_factory=list)
    marks: list[tuple[float, str]] = field(default_factory=list)

    @property
    def spec(self) -> dict[str, Any]:
        """Specification of the plot (see elements.Plots)."""
        (up, unit), (over, unit_over) = self.up, self.over
        series = [
            {"name": name, "label": f"{up}, {name}", "unit": unit, "dashed": name != SERIES[0]}
            for name in SERIES
        ]
        return {
            "id": self.id,
            "kind": "sweep",
            "title": f"{up} over {over}",
            "x": {"label": over, "unit": unit_over},
            "y": {"label": up, "unit": unit},
            "series": series,
        }

    @property
    def rows(self) -> list[float | None]:
        """Rows for the page, one after the other: the value, and the height in one of two columns,
        dashed as far as the next point that is stable."""
        stable = [point.stable is True for point in self.points]
        found: list[float | None] = []
        for at, (value, height, *_) in enumerate(self.points):
            dashed = not all(stable[max(at - 1, 0) : at + 2])
            found += [value, height if stable[at] else None, height if dashed else None]
        return found
