"""The cheapest of rodgen's settings against the cheapest of all peers', at equal error."""

from __future__ import annotations

import statistics
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rodgen.analyse.precision import method_families
from rodgen.analyse.precision.contestant import Contestant, Deadline, Measurement
from rodgen.analyse.precision.job import Job, Measures
from rodgen.analyse.precision.rows import find_cheapest
from rodgen_evidence.report.cases import Case
from rodgen_evidence.report.precision.contests import load_job
from rodgen_evidence.report.precision.references import NO_REFERENCE
from rodgen_evidence.report.unit import Unit

ASKED = (1e-4, 1e-6, 1e-9)  # errors of an angle at the end [rad]
ROUNDS = 5  # of each in turns; fewer where they would take more seconds than that
SECONDS, QUICKLY = 10.0, 2.0
PATIENCE = 20.0  # seconds of a single run


def duel(
    name: str,
    table: dict[str, Any],
    folder: str,
    quick: bool,
    asked: float,
    mine: dict[str, Any] | None,
    theirs: dict[str, Any] | None,
    why: str = "",
) -> list[Measurement]:
    """Two settings in turns in one process.

    mine, theirs: which, as their rows have them; None of a side that has none, and there is no
    duel then; why: that is so, if not for want of time.
    """
    row = _row(name, table["rod"]["links"], asked, mine, theirs)
    if not mine or not theirs:
        sides = {"rodgen": mine, "every peer": theirs}
        who = " and ".join(who for who, side in sides.items() if not side)
        return [row | {"failed": why or f"{who} missed this error in the time of a run"}]
    job, held = load_job(name, table, folder)
    pair = (_ours(job, mine), _theirs(job, theirs, quick))
    # The first run of each is not timed: it is held against the reference.
    errors = [_error(who, held.measures(job, who.method)) for who in pair]
    expected = float(mine["seconds"]) + float(theirs["seconds"])
    rounds = int(np.clip((QUICKLY if quick else SECONDS) / max(expected, 1e-9), 1, ROUNDS))
    times = [[_seconds(who) for who in pair] for _ in range(rounds)]
    row |= {"ours_error": errors[0], "theirs_error": errors[1]}
    row |= {"ours_seconds": statistics.median(first for first, _ in times)}
    row |= {"theirs_seconds": statistics.median(second for _, second in times)}
    row |= {"ratio": statistics.median(second / first for first, second in times)}
    return [row | {"rounds": rounds}]


def units(
    cases: Sequence[Case], quick: bool, folder: str | Path, rows: Sequence[Measurement]
) -> list[Unit]:
    """One for every scene and error asked for, from the rows of the section precision."""
    planned = []
    for case in cases:
        of_scene = [row for row in rows if row.get("scene") == case.name]
        reasons = (str(row.get("failed")) for row in of_scene)
        why = next((why for why in reasons if why.startswith(NO_REFERENCE)), "")
        for asked in ASKED:
            mine = find_cheapest((row for row in of_scene if row.get("who") == "rodgen"), asked)
            theirs = find_cheapest((row for row in of_scene if row.get("who") != "rodgen"), asked)
            name = f"equal_error-{case.name}-1e{int(np.log10(asked)):d}"
            given = {"asked": asked, "mine": mine, "theirs": theirs, "why": why}
            known, timed = case.given(folder, quick=quick, **given), bool(mine and theirs)
            planned.append(Unit("equal_error", name, f"{__name__}:duel", known, timed))
    return planned


def _ours(job: Job, row: dict[str, Any]) -> Contestant:
    return method_families.contestant(
        job, row["method"], row["target"], **{row["kind"]: row["setting"]}
    )


def _theirs(job: Job, row: dict[str, Any], quick: bool) -> Contestant:
    """The contestant of a row that was measured. Raises LookupError where the peer does not offer
    its setting any more."""
    from rodgen_evidence.report.peers import family

    names = ("who", "method", "target", "kind", "setting")
    for who in family(row["family"], job, quick):
        if all(getattr(who, name) == row[name] for name in names):
            return who
    raise LookupError(f"{row['family']} has no setting {row['setting']:g}")


def _error(who: Contestant, measures: Measures) -> float | None:
    Deadline.at = time.perf_counter() + PATIENCE
    try:
        return measures.errors(who.integrate().y)["error_phi"]
    finally:
        Deadline.at = np.inf


def _seconds(who: Contestant) -> float:
    start = time.perf_counter()
    who.integrate()
    return time.perf_counter() - start


def _row(
    name: str, links: int, asked: float, mine: dict[str, Any] | None, theirs: dict[str, Any] | None
) -> Measurement:
    nothing = ("ours_error", "ours_seconds", "theirs_error", "theirs_seconds", "ratio")
    row: Measurement = {"scene": name, "n": links, "asked": asked, **dict.fromkeys(nothing)}
    row |= {"ours": side(mine), "theirs": side(theirs, with_who=True)}
    return row | {"rounds": 0, "failed": ""}


def side(row: dict[str, Any] | None, with_who: bool = False) -> str:
    """Who took which setting, as rows of duels have it."""
    if row is None:
        return ""
    who = f"{row['who']} " if with_who else ""
    return f"{who}{row['method']} ({row['target']}), {row['kind']} {row['setting']:.3g}"
