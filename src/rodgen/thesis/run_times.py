"""Table 4.2: what the three methods cost at their largest stable steps."""

from __future__ import annotations

from collections.abc import Sequence

from rodgen.thesis import data, scenes
from rodgen.thesis.methods import DAMPING, NAMES, theory
from rodgen.thesis.table import INCOMPARABLE, Cell, Column, Note, Table
from rodgen.thesis.timing import STEPS, special_seconds, times

COLUMNS = (
    Column("links", "links"),
    Column("method", "method"),
    Column("step", "thesis: step", "s", ".3g"),
    Column("thesis", "thesis: run time", "s", ".6g"),
    Column("cost", "thesis: a step, if 200 s were run", "us", ".4g"),
    Column("c", "ours: 200 s, C target", "s", ".3g"),
    Column("numpy", "ours: 200 s, NumPy target", "s", ".3g"),
    Column("gain", "thesis over ours in C", "", ".0f"),
    Column("verdict", "verdict"),
)


def table_4_2(links: Sequence[int] | None = None, methods: Sequence[str] = data.METHODS) -> Table:
    """Run times at the largest steps; links, methods: those of the rows."""
    steps = {row.links: row for row in data.TABLE_4_1}
    printed = [row for row in data.TABLE_4_2 if links is None or row.links in links]
    rows = [
        _row_4_2(row, method, float(getattr(steps[row.links], method)))
        for method in methods
        for row in printed
    ]
    table = Table("4.2", "Run time at the largest stable step", COLUMNS, rows)
    table.conditions = ["none: the simulated span is not given; Java, on a machine not given"]
    table.assumed = [
        "200 s, the span of 3.3, by the thesis's steps of table 4.1.",
        "Ours: the rod of table 4.1 with a hundredth of the bend of its start; the time of a step "
        "is measured and multiplied by the number of the thesis's steps: "
        + " and ".join(_multiplied(rows, target) for target in STEPS)
        + ".",
    ]
    table.notes = _notes_4_2(rows) if len(methods) == len(data.METHODS) else []
    return table


def _row_4_2(printed: data.OfMethods, method: str, step: float) -> dict[str, Cell]:
    seconds = float(getattr(printed, method))
    ours = {
        target: special_seconds(printed.links, method, target, theory_step(printed.links, method),
                                DAMPING)
        * theory_step(printed.links, method) / step * scenes.WATCHED
        for target in ("c", "numpy")
    }  # fmt: skip
    return {
        "links": printed.links,
        "method": NAMES[method],
        "step": step,
        "thesis": seconds,
        "cost": seconds * step / scenes.WATCHED * 1e6,
        **ours,
        "gain": seconds / ours["c"],
        "verdict": f"{INCOMPARABLE}: span and machine not given",
    }


def theory_step(links: int, method: str) -> float:
    """A stable step [s] at which the cost of a step is measured: it does not depend on it."""
    return 0.5 * theory(links, method, DAMPING)


def _notes_4_2(rows: list[dict[str, Cell]]) -> list[Note]:
    cost = {(row["links"], row["method"]): float(row["cost"] or 0) for row in rows}
    counts = sorted({int(row["links"] or 0) for row in rows})
    middle, kutta, euler = (
        [cost[n, NAMES[method]] for n in counts]
        for method in ("semi_implicit_euler", "thesis_runge_kutta", "euler")
    )
    fours = ", ".join(f"{b / a:.2f}" for a, b in zip(middle, kutta, strict=True))
    ones = ", ".join(f"{b / a:.2f}" for a, b in zip(middle, euler, strict=True))
    return [
        Note(
            "shown",
            "The table does not go with table 4.1 and one span. A step of the Runge-Kutta method "
            "solves the system four times, one of the Euler methods once; with the printed steps "
            f"and one span it would cost {fours} times a semi-implicit step (n = "
            f"{', '.join(map(str, counts))}) instead of 4, and a step of Euler's method {ones} "
            "times instead of 1. Other spans or other steps than the printed ones must have been "
            "used.",
        ),
        _note_on_order(rows, counts),
    ]


def _multiplied(rows: list[dict[str, Cell]], target: str) -> str:
    """Over how many steps a target was timed, and how many times more the runs have."""
    factors = [scenes.WATCHED / float(row["step"] or 1) / STEPS[target] for row in rows]
    name = {"c": "C", "numpy": "NumPy"}[target]
    return f"{STEPS[target]} steps in {name}, multiplied {times(factors)}"


def _note_on_order(rows: list[dict[str, Cell]], counts: list[int]) -> Note:
    """Which method costs least, and Euler's how many times as much as the semi-implicit one."""

    def over(key: str, method: str) -> list[float]:
        found = {(row["links"], row["method"]): float(row[key] or 0) for row in rows}
        base = NAMES["semi_implicit_euler"]
        return [found[n, NAMES[method]] / found[n, base] for n in counts]

    def words(ratios: list[float]) -> str:
        return ", ".join(f"{ratio:.2g}" if ratio < 10 else f"{ratio:.0f}" for ratio in ratios)

    def least(key: str) -> str:
        others = [over(key, m) for m in data.METHODS if m != "semi_implicit_euler"]
        here = [str(n) for n, *ratios in zip(counts, *others, strict=True) if min(ratios) > 1]
        return "every n" if len(here) == len(counts) else f"n = {', '.join(here) or 'none'}"

    steps = [1 / ratio for ratio in over("step", "euler")]
    return Note(
        "estimated",
        "At the thesis's largest steps the semi-implicit Euler method costs least at "
        f"{least('thesis')} in the thesis and at {least('c')} in ours. Euler's method costs "
        f"{words(over('c', 'euler'))} times as much in ours (C), "
        f"{words(over('thesis', 'euler'))} times in the thesis (n = "
        f"{', '.join(map(str, counts))}); its steps alone are {words(steps)} times as many.",
    )
