"""What is asked of whole integrations, and one measurement of each."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass

import our_runs
from integrate_jobs import BEAM, DAMPED, R50, R200, Job
from peers.runs import GRACE, SCIPY, families
from report import duration
from rich.table import Table
from work_precision import Family, Tried, best, in_turns, ratio

OWN = "own "  # before a method of rodgen's that another is held against


@dataclass(frozen=True)
class Line:
    """A job at an error: our methods (all, where none is named), and what they are to beat.

    against: names as in peers.runs.PEERS, several joined by +, with how many times faster than
    the best of them ours is asked to be.
    """

    job: Job
    asked: float
    against: tuple[tuple[str, float], ...]
    ours: tuple[str, ...] = ()


LINES = (
    Line(R50, 4e-5, (("MuJoCo Euler", 20.0),)),
    Line(R50, 4e-6, (("heyoka", 5.0), ("SciPy DOP853", 9.0))),
    Line(R50, 6e-9, (("heyoka", 5.0),)),
    Line(R50, 1e-12, (("heyoka, compact", 8.0),)),
    Line(R200, 1e-4, ((f"{OWN}dop853", 10.0),), ("gauss",)),
    Line(DAMPED, 1e-6, (("SciPy Radau", 20.0), (f"{OWN}dop853", 40.0)), ("radau",)),
    Line(BEAM, 1e-6, (("+".join(SCIPY), 10.0),)),
    Line(BEAM, 1e-9, (("+".join(SCIPY), 10.0),)),
)


def lines(quick: bool, say: Callable[[str], None]) -> Table:
    """All lines; say: told what is being looked at."""
    table = Table(title="whole integrations at equal error, each line in one run, in turns")
    for column in ("job", "error", "rodgen", "off by", "time", "inside"):
        table.add_column(column, justify="left" if column in ("job", "rodgen") else "right")
    for column in ("beside it", "off by", "time", "times faster", "asked", "verdict"):
        table.add_column(column, justify="right" if column in ("off by", "time") else "left")
    for line in LINES:
        for row in measure(line, quick, say):
            say(f"    {', '.join(row)}")
            table.add_row(*row)
        table.add_section()
    table.caption = (
        "the cheapest setting of each whose error, as that of the next tighter one, is within the "
        "one asked for; time: median around the whole call; inside: Solution.stats.wall_seconds; "
        "times faster: median over the rounds"
    )
    return table


def measure(line: Line, quick: bool, say: Callable[[str], None]) -> list[list[str]]:
    """The rows of a line."""
    job, asked = line.job, line.asked
    head = [job.name, f"{asked:.0e}"]
    say(f"{job.name} at {asked:.0e}: rodgen")
    ours, why = best(our_runs.families(job, asked, line.ours), job, asked)
    if ours is None:
        why = why or f"{', '.join(line.ours)}: not offered"
    rows = []
    for name, factor in line.against:
        wish = f"{factor:g} times"
        if quick and name == "heyoka":
            rows.append([*head, "", "", "", "", name, "", "", "", wish, "left out: --quick"])
            continue
        if ours is None:  # nothing to set beside it
            rows.append([*head, "-", "", "", "", name, "", "", "", wish, f"NOT: {why}"])
            continue
        say(f"{job.name} at {asked:.0e}: {name}")
        theirs, failed = best(_opponents(name, job, asked), job, asked * GRACE.get(name, 1.0))
        rows.append([*head, *_beside(ours, theirs, name, failed, factor)])
    return rows


def _opponents(name: str, job: Job, asked: float) -> dict[str, Family]:
    if name.startswith(OWN):
        return our_runs.families(job, asked, (name.removeprefix(OWN),))
    return families(name.split("+"), job, asked)


def _beside(ours: Tried, theirs: Tried | None, name: str, failed: str, factor: float) -> list[str]:
    wish = f"{factor:g} times"
    if theirs is None:
        return [*_one(ours), name, "", "", "", wish, f"cannot be had: {failed}"]
    contestants = {"ours": ours.who, "theirs": theirs.who}
    times, insides = in_turns(contestants, ours.seconds + theirs.seconds)
    faster = ratio(times, "theirs", "ours")
    left, right = _one(ours), _one(theirs)
    left[2], right[2] = (duration(statistics.median(times[who])) for who in ("ours", "theirs"))
    left[3] = duration(statistics.median(insides["ours"]))
    verdict = "met" if faster >= factor else f"NOT: {faster / factor:.2g} of it"
    return [*left, *right[:3], f"{faster:.3g}", wish, verdict]


def _one(tried: Tried) -> list[str]:
    finish = tried.finish
    counts = f" ({finish.counts})" if finish else ""
    inside = duration(finish.inside) if finish and finish.inside else ""
    return [tried.who.label + counts, f"{tried.error:.1e}", duration(tried.seconds), inside]
