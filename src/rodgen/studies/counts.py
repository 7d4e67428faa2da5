"""Counts of the points of a store: those computed, failed, too long or doubtful, and why."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rodgen.dataset_result import DOUBTS, doubt_remark
from rodgen.integrate.stepper import NO_RESULT, TOO_LONG
from rodgen.result import Note, Result, Row
from rodgen.studies.sampling import MARK, Layout
from rodgen.studies.store import open_array, open_group

NUMBER = re.compile(r"(?<![A-Za-z_])[-+]?\d[\d.]*(e[-+]?\d+)?")
MOST_REASONS = 1000  # that are told apart


@dataclass(repr=False)
class PointCounts(Result):
    """Counts of the points of a study. too_long: took longer than they may; doubtful: with doubts
    about their numbers, None where the store has none; reasons: why points failed, with how many
    each; seconds: of processors; name: of the study."""

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
        """The remark that some points have doubts, if any have."""
        return doubt_remark(self.doubtful or 0, self.computed)

    @property
    def _reasons(self) -> dict[str, str]:
        return {f"  {count} of them": why for why, count in self.reasons.most_common(10)}

    def __repr__(self) -> str:
        done = f"{self.computed} of {self.points} points"
        return f"<PointCounts of {self.name}: {done}, {self.failed} failed>"


def count_points(path: str | Path) -> PointCounts:
    """Count the points of a store, block by block. Raises InputError for what is no store."""
    group = open_group(Path(path))
    status, message, seconds = (open_array(group, name) for name in (MARK, "message", "seconds"))
    doubts = open_array(group, DOUBTS) if DOUBTS in group else None
    layout = Layout(status.shape, status.chunks)
    found = PointCounts(name=str(group.attrs.get("name", "")), points=status.size)
    for block in range(layout.count):
        box = layout.slices(block)
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
                text, known = without_numbers(why), found.reasons
                known[text if text in known or len(known) < MOST_REASONS else "other"] += 1
    return found


def without_numbers(message: str) -> str:
    """Replace the numbers in a message, which differ from point to point, by #."""
    return NUMBER.sub("#", message)
