"""What became of the points of a store, counted by reason."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rodgen.dataset_result import DOUBTS, doubtful_points
from rodgen.integrate.endings import NO_RESULT, TOO_LONG
from rodgen.result import Note, Result, Row
from rodgen.studies.layout import MARK, Layout
from rodgen.studies.store import arrays_of, attributes_of

NUMBER = re.compile(r"(?<![A-Za-z_])[-+]?\d[\d.]*(e[-+]?\d+)?")
MOST_REASONS = 1000  # that are told apart


@dataclass(repr=False)
class Tally(Result):
    """Points of a study: how many there are, how many of them were computed, how many failed and
    how many took longer than they may; doubtful: about whose numbers there are doubts; reasons: why
    points failed, with how many each; seconds: of processors; name: of the study."""

    name: str = ""

    points: int = 0
    computed: int = 0
    failed: int = 0
    too_long: int = 0
    doubtful: int | None = None
    seconds: float = 0.0
    reasons: Counter[str] = field(default_factory=Counter)

    ROWS = (
        Row("name", "study"),
        Row("points", "points"),
        Row("computed", "computed"),
        Row("seconds", "time of processors", "s", ".4g"),
        Row("failed", "failed"),
        Row("too_long", "took too long"),
        Row("doubtful", "doubtful"),
        Row("reasons", "reasons", text=lambda found: found._reasons),
    )

    @property
    def notes(self) -> tuple[Note, ...]:  # type: ignore[override]  # a field of other results
        """That some points have doubts."""
        return doubtful_points(self.doubtful or 0, self.computed)

    @property
    def _reasons(self) -> dict[str, str]:
        return {f"  {count} of them": why for why, count in self.reasons.most_common(10)}

    def __repr__(self) -> str:
        return (
            f"<Tally of {self.name}: {self.computed} of {self.points} points, {self.failed} failed>"
        )


def tally(path: str | Path) -> Tally:
    """Count the points of a store, block by block. Raises InputError for what is no store."""
    arrays = arrays_of(path)
    status, message, seconds = (arrays[name] for name in (MARK, "message", "seconds"))
    doubts = arrays.get(DOUBTS)
    layout = Layout(status.shape, status.chunks)
    found = Tally(name=str(attributes_of(path).get("name", "")), points=status.size)
    for block in range(layout.count):
        box = layout.box(block)
        there = np.asarray(status[box])
        bad = np.isin(there, NO_RESULT)
        found.computed += int((there != "").sum())
        if doubts is not None:  # of a store that has them
            found.doubtful = (found.doubtful or 0) + int((np.asarray(doubts[box]) > 0).sum())
        found.seconds += float(np.nansum(np.asarray(seconds[box])))
        if bad.any():
            late = int((there == TOO_LONG).sum())
            found.too_long += late
            found.failed += int(bad.sum()) - late
            for why in np.asarray(message[box])[bad].tolist():
                _count(found.reasons, reason(why))
    return found


def reason(message: str) -> str:
    """A message without its numbers, which differ from point to point."""
    return NUMBER.sub("#", message)


def _count(reasons: Counter[str], why: str) -> None:
    reasons[why if why in reasons or len(reasons) < MOST_REASONS else "other"] += 1
