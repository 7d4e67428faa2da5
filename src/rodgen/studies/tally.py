"""What became of the points of a store, counted by reason."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rodgen.integrate.endings import NO_RESULT, TOO_LONG
from rodgen.studies.layout import MARK, Layout
from rodgen.studies.store import arrays_of

NUMBER = re.compile(r"(?<![A-Za-z_])[-+]?\d[\d.]*(e[-+]?\d+)?")
MOST_REASONS = 1000  # that are told apart


@dataclass
class Tally:
    """Points of a study: how many there are, how many of them were computed, how many failed and
    how many took longer than they may; reasons: of those, with how many points each; seconds: of
    processors."""

    points: int = 0
    computed: int = 0
    failed: int = 0
    too_long: int = 0
    seconds: float = 0.0
    reasons: Counter[str] = field(default_factory=Counter)

    @property
    def rows(self) -> dict[str, str]:
        """As a table shows it, the most frequent reasons first."""
        rows = {
            "points": f"{self.points}",
            "computed": f"{self.computed}, in {self.seconds:.4g} s of processors",
            "failed": f"{self.failed}",
        }
        rows |= {"took too long": f"{self.too_long}"} if self.too_long else {}
        return rows | {f"  {count} of them": why for why, count in self.reasons.most_common(10)}


def tally(path: str | Path) -> Tally:
    """Count the points of a store, block by block. Raises InputError for what is no store."""
    arrays = arrays_of(path)
    status, message, seconds = (arrays[name] for name in (MARK, "message", "seconds"))
    layout = Layout(status.shape, status.chunks)
    found = Tally(points=status.size)
    for block in range(layout.count):
        box = layout.box(block)
        there = np.asarray(status[box])
        bad = np.isin(there, NO_RESULT)
        found.computed += int((there != "").sum())
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
