"""What came out, in sentences that follow from the rows."""

from __future__ import annotations

import math
from collections import Counter
from statistics import median

from rodgen.judge.found import (
    FAILED,
    OFF,
    failures,
    far_from_theory,
    grows,
    judged,
    losing,
    trusted,
)
from rodgen.judge.precision.pareto import cheapest
from rodgen.judge.rows import Contents, fine, grouped, label, number, of, setting, short, text
from rodgen.judge.unit import Row

CLEAR = 3.0  # times the reference's own estimate that an error must be to be told
ASKED = (1e-3, 1e-6, 1e-9)  # errors of the angles [rad] for which the fastest is named


def scenes(contents: Contents) -> list[str]:
    """Names of the scenes that were integrated, or were to be, in their order."""
    sections = ("references", "precision")
    return list(dict.fromkeys(text(r, "scene") for s in sections for r in of(contents, s)))


def best_row(contents: Contents, scene: str) -> Row:
    """A line of the summary: the fastest for every error that is asked."""
    rows, limit = of(contents, "precision", scene=scene), trusted(contents, scene)
    if not judged(contents, scene):
        return {"scene": scene, **dict.fromkeys((short(e, ".0e") for e in ASKED), "no reference")}
    best = {short(error, ".0e"): _best(rows, error, limit) for error in ASKED}
    return {"scene": scene, **best}


def _best(rows: list[Row], error: float, limit: float) -> str:
    if error < CLEAR * limit:
        return f"cannot be told: the reference is good to {short(limit, '.1e')}"
    there = [row for row in rows if fine(row) and math.isfinite(number(row, "error_phi"))]
    if not there:
        return "none got there"
    best = cheapest(there, error, "error_phi")
    if best:
        return f"{label(best)}, {setting(best)}: {duration(number(best, 'seconds'))}"
    closest = min(there, key=lambda row: number(row, "error_phi"))
    return f"none; {label(closest)} has {short(number(closest, 'error_phi'), '.1e')}"


def duration(seconds: float) -> str:
    """Seconds, in the unit that suits them."""
    if not math.isfinite(seconds):
        return "-"
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if abs(seconds) >= size or size == 1e-9:
            return f"{seconds / size:.3g} {unit}"
    raise AssertionError


def sentences(contents: Contents) -> list[str]:
    """Summary in sentences, of the sections that there are."""
    said = [_failed(contents)]
    said += [_wrong(contents)] if of(contents, "extremes") else []
    said += [_steps(contents)] if of(contents, "steps") else []
    said += [_rounding(contents)] if of(contents, "rounding") else []
    said += [_duels(contents)] if any(map(fine, of(contents, "equal_error"))) else []
    return said + growths(contents)


def growths(contents: Contents) -> list[str]:
    """A sentence for every scene of which errors were followed in time."""
    by_scene = grouped(of(contents, "growth"), lambda row: text(row, "scene"))
    return [growth(scene, some) for scene, some in by_scene.items()]


def growth(scene: str, rows: list[Row]) -> str:
    """How fast errors grow on a scene, and what that leaves."""
    rates = [number(row, "rate") for row in rows if math.isfinite(number(row, "rate"))]
    if not rates:
        return f"{scene}: no rate at which errors grow could be fitted."
    rising = [number(row, "rate") for row in rows if grows(row)]
    if not rising:
        return (
            f"{scene}: errors do not grow exponentially to speak of "
            f"(rates of {min(rates):.2g} to {max(rates):.2g} 1/s)."
        )
    rate = median(rising)
    digit = math.log(10) / rate
    return (
        f"{scene}: errors grow as exp({rate:.3g} t), a digit is lost every {digit:.2g} s; a "
        f"rounding error of 1e-16 has become 1 after some {16 * digit:.2g} s, whatever the method."
    )


def _failed(contents: Contents) -> str:
    lines, rows = failures(contents), sum(len(of(contents, section)) for section in contents)
    kinds = Counter(text(line, "kind") for line in lines)
    by = Counter(text(line, "section") for line in lines if line["kind"] == FAILED)
    where = ", ".join(f"{count} in {section}" for section, count in by.items())
    said = f"{kinds.pop(FAILED)} failed ({where})" if FAILED in kinds else "none failed"
    rest = "".join(f"; {count} {kind}" for kind, count in kinds.items())
    return f"Of {rows} rows in {sum(map(len, contents.values()))} units, {said}{rest}."


def _wrong(contents: Contents) -> str:
    counts = Counter(text(row, "outcome") for row in of(contents, "extremes"))
    rest = ", ".join(f"{count} {name}" for name, count in counts.items() if name != "wrong")
    return (
        f"Extreme cases: {counts['wrong']} of {counts.total()} wrong without warning"
        f"{f'; the others: {rest}' if rest else ''}."
    )


def _steps(contents: Contents) -> str:
    found = [row for row in of(contents, "steps") if math.isfinite(number(row, "off"))]
    far = far_from_theory(contents)
    if not found:
        return "Largest stable steps: none could be set beside theory."
    worst = max(found, key=lambda row: abs(number(row, "off")))
    return (
        f"Largest stable steps: {len(found) - len(far)} of {len(found)} are within "
        f"{OFF:.0%} of theory; farthest off is {text(worst, 'method')}, n = {text(worst, 'n')}, "
        f"damping {text(worst, 'damping')}: {number(worst, 'off'):+.2%}."
    )


def _rounding(contents: Contents) -> str:
    rows = [row for row in of(contents, "rounding") if fine(row)]
    by = Counter(text(row, "form") for row in losing(rows))
    forms = ", ".join(f"{name} in {count}" for name, count in by.items())
    return (
        f"Rounding of rhs: of {len(rows)} trials a form loses more than a digit that another "
        f"keeps: {forms or 'in none'}."
    )


def _duels(contents: Contents) -> str:
    rows = [row for row in of(contents, "equal_error") if number(row, "ratio") > 0]
    ratios = [number(row, "ratio") for row in rows]
    if not ratios:
        return "Equal error: no ratio could be measured."
    faster = [f"{text(r, 'theirs')} on {text(r, 'scene')}" for r in rows if number(r, "ratio") < 1]
    rest = f"; faster than ours: {', '.join(faster)}" if faster else ""
    return (
        f"Equal error: in {len(ratios)} duels theirs takes {min(ratios):.3g} to {max(ratios):.3g} "
        f"times as long as ours, in the median {median(ratios):.3g} times{rest}."
    )
