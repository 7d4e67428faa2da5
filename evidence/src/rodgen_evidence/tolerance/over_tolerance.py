"""Errors of a record in units of its tolerance, where the reference is good enough to tell."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from rodgen_evidence.tolerance.measure.error_kinds import tolerated_error

Record = dict[str, Any]

FINER = 100.0  # times, that the reference is closer than what it judges
LEAST, GROWTHS = 10.0, 3.0  # tolerances, and times the growth of a shift, that are allowed


class Over(NamedTuple):
    """samples, end: largest error over the tolerance at all samples, and at the last one; allowed:
    what it may be; steps: of the run, each of which may add a tolerance."""

    seed: int
    method: str
    rtol: float
    kind: str
    samples: float
    end: float
    allowed: float
    warned: str
    chosen: str
    steps: int

    @property
    def exceeds(self) -> bool:
        """Whether it is too large, and nothing was said."""
        return self.samples > self.allowed and not self.warned


def over_tolerance(record: Record) -> Iterator[Over]:
    """Yield the errors of all runs and kinds that the reference can judge."""
    reference = record["reference"]
    if reference is None:
        return
    allowed = max(LEAST, GROWTHS * reference["growth"])
    for row in record["runs"]:
        for kind, (samples, end) in (row["errors"] or {}).items():
            asked = tolerated_error(reference["size"][kind], row["rtol"])
            if FINER * reference["errors"][kind][0] > asked:
                continue
            own = row["method"], row["rtol"], kind, samples / asked, end / asked
            said = row["warned"], row.get("chosen", ""), row["steps"]
            yield Over(record["seed"], *own, allowed, *said)
