"""Results of a report in sentences that follow from its rows."""

from __future__ import annotations

import math
from statistics import median

from rodgen.analyse.precision.contestant import Measurement
from rodgen.analyse.precision.rows import (
    find_cheapest,
    format_label,
    format_setting,
    format_short,
    has_result,
    read_number,
)
from rodgen.progress import format_duration
from rodgen_evidence.report.contents import (
    FAILED,
    Contents,
    failures,
    frame,
    may_have_reference,
    of,
    reference_error,
)
from rodgen_evidence.report.precision.growth import grows
from rodgen_evidence.report.stability.rounding import losing
from rodgen_evidence.report.stability.steps import OFF, off_theory

CLEAR = 3.0  # times the reference's own estimate that an error must be to be told
ASKED = (1e-3, 1e-6, 1e-9)  # errors of the angles [rad] for which the fastest is named


def scenes(contents: Contents) -> list[str]:
    """Names of the scenes that were integrated, or were to be, in their order."""
    rows = [*of(contents, "references"), *of(contents, "precision")]
    return list(frame(rows)["scene"].unique())


def best_row(contents: Contents, scene: str) -> Measurement:
    """A line of the summary: the fastest for every error that is asked."""
    rows, limit = of(contents, "precision", scene=scene), reference_error(contents, scene)
    if not may_have_reference(contents, scene):
        return {
            "scene": scene,
            **dict.fromkeys((format_short(e, ".0e") for e in ASKED), "no reference"),
        }
    best = {format_short(error, ".0e"): _best(rows, error, limit) for error in ASKED}
    return {"scene": scene, **best}


def _best(rows: list[Measurement], error: float, limit: float) -> str:
    if error < CLEAR * limit:
        return f"cannot be told: the reference is good to {format_short(limit, '.1e')}"
    there = [
        row for row in rows if has_result(row) and math.isfinite(read_number(row, "error_phi"))
    ]
    if not there:
        return "none got there"
    best = find_cheapest(there, error, "error_phi")
    if best:
        seconds = format_duration(read_number(best, "seconds"))
        return f"{format_label(best)}, {format_setting(best)}: {seconds}"
    closest = min(there, key=lambda row: read_number(row, "error_phi"))
    error_text = format_short(read_number(closest, "error_phi"), ".1e")
    return f"none; {format_label(closest)} has {error_text}"


def sentences(contents: Contents) -> list[str]:
    """Summary in sentences, of the sections that there are."""
    said = [_failure_counts(contents)]
    said += [_wrong(contents)] if of(contents, "extremes") else []
    said += [_steps(contents)] if of(contents, "steps") else []
    said += [_rounding(contents)] if of(contents, "rounding") else []
    said += [_duels(contents)] if any(map(has_result, of(contents, "equal_error"))) else []
    return said + growths(contents)


def growths(contents: Contents) -> list[str]:
    """A sentence for every scene of which errors were followed in time."""
    names = frame(of(contents, "growth"))["scene"].unique()
    return [growth(scene, of(contents, "growth", scene=scene)) for scene in names]


def growth(scene: str, rows: list[Measurement]) -> str:
    """Describe how fast errors grow on a scene, and what that leaves."""
    rates = frame(rows)["rate"].dropna()
    if rates.empty:
        return f"{scene}: no rate at which errors grow could be fitted."
    rising = [read_number(row, "rate") for row in rows if grows(row)]
    if not rising:
        return (
            f"{scene}: errors do not grow exponentially to speak of "
            f"(rates of {rates.min():.2g} to {rates.max():.2g} 1/s)."
        )
    rate = median(rising)
    digit = math.log(10) / rate
    return (
        f"{scene}: errors grow as exp({rate:.3g} t), a digit is lost every {digit:.2g} s; a "
        f"rounding error of 1e-16 has become 1 after some {16 * digit:.2g} s, whatever the method."
    )


def _failure_counts(contents: Contents) -> str:
    lines, rows = failures(contents), sum(len(of(contents, section)) for section in contents)
    kinds = lines.value_counts("kind", sort=False).reindex(lines["kind"].unique())
    by = lines[lines["kind"] == FAILED].groupby("section", sort=False).size()
    where = ", ".join(f"{count} in {section}" for section, count in by.items())
    said = f"{by.sum()} failed ({where})" if len(by) else "none failed"
    rest = "".join(f"; {count} {kind}" for kind, count in kinds.items() if kind != FAILED)
    return f"Of {rows} rows in {sum(map(len, contents.values()))} units, {said}{rest}."


def _wrong(contents: Contents) -> str:
    outcomes = frame(of(contents, "extremes")).groupby("outcome", sort=False).size()
    rest = ", ".join(f"{count} {name}" for name, count in outcomes.items() if name != "wrong")
    return (
        f"Extreme cases: {outcomes.get('wrong', 0)} of {outcomes.sum()} wrong without warning"
        f"{f'; the others: {rest}' if rest else ''}."
    )


def _steps(contents: Contents) -> str:
    found = frame(of(contents, "steps")).dropna(subset="off")
    if found.empty:
        return "Largest stable steps: none could be set beside theory."
    worst = found.loc[found["off"].abs().idxmax()]
    return (
        f"Largest stable steps: {len(found) - len(off_theory(found))} of {len(found)} are within "
        f"{OFF:.0%} of theory; farthest off is {worst['method']}, n = {worst['n']:g}, "
        f"damping {worst['damping']}: {worst['off']:+.2%}."
    )


def _rounding(contents: Contents) -> str:
    rows = frame(filter(has_result, of(contents, "rounding")))
    by = losing(rows).groupby("form", sort=False).size()
    forms = ", ".join(f"{name} in {count}" for name, count in by.items())
    return (
        f"Rounding of rhs: of {len(rows)} trials a form loses more than a digit that another "
        f"keeps: {forms or 'in none'}."
    )


def _duels(contents: Contents) -> str:
    rows = frame(of(contents, "equal_error"))
    rows = rows[rows["ratio"] > 0]
    if rows.empty:
        return "Equal error: no ratio could be measured."
    ratios, lost = rows["ratio"], rows[rows["ratio"] < 1]
    faster = ", ".join(lost["theirs"].astype(str) + " on " + lost["scene"])
    return (
        f"Equal error: in {len(rows)} duels theirs takes {ratios.min():.3g} to {ratios.max():.3g} "
        f"times as long as ours, in the median {ratios.median():.3g} times"
        f"{f'; faster than ours: {faster}' if faster else ''}."
    )
