"""Table 4.2: what the three methods cost at their largest stable steps."""

from __future__ import annotations

from pandas import DataFrame, Series

from rodgen_evidence.thesis import data, scenes
from rodgen_evidence.thesis.largest_steps import DAMPING, NAMES, theory
from rodgen_evidence.thesis.special_times import STEPS, special_seconds, times
from rodgen_evidence.thesis.table import INCOMPARABLE, LINKS, VERDICT, Remark, ThesisTable, column

COLUMNS = (
    LINKS,
    column("method", "method"),
    column("step", "thesis: step", "s", ".3g"),
    column("thesis", "thesis: run time", "s", ".6g"),
    column("cost", "thesis: a step, if 200 s were run", "us", ".4g"),
    column("c", "ours: 200 s, C target", "s", ".3g"),
    column("numpy", "ours: 200 s, NumPy target", "s", ".3g"),
    column("gain", "thesis over ours in C", "", ".0f"),
    VERDICT,
)


def table_4_2() -> ThesisTable:
    """Run times at the largest steps."""
    rows = data.by_method(data.TABLE_4_2)
    rows["thesis"] = rows["printed"].astype(float)
    rows["step"] = data.by_method(data.TABLE_4_1)["printed"].astype(float)
    rows["cost"] = rows["thesis"] * rows["step"] / scenes.WATCHED * 1e6
    for target in STEPS:
        rows[target] = [
            _seconds(row.links, row.method, row.step, target) for row in rows.itertuples()
        ]
    rows["gain"] = rows["thesis"] / rows["c"]
    rows["verdict"] = f"{INCOMPARABLE}: span and machine not given"
    table = ThesisTable("4.2", "Run time at the largest stable step", COLUMNS, rows)
    table.conditions = ["none: the simulated span is not given; Java, on a machine not given"]
    table.assumed = [
        "200 s, the span of 3.3, by the thesis's steps of table 4.1.",
        "Ours: the rod of table 4.1 with a hundredth of the bend of its start; the time of a step "
        "is measured and multiplied by the number of the thesis's steps: "
        + " and ".join(_describe_factors(rows, target) for target in STEPS)
        + ".",
    ]
    table.notes = notes(rows)
    table.rows = rows.assign(method=rows["method"].map(NAMES))
    return table


def _seconds(links: int, method: str, step: float, target: str) -> float:
    """Run time [s] of 200 s by these steps [s]: the time of a step, which does not depend on it, is
    measured at half of the stable one."""
    stable = 0.5 * theory(links, method, DAMPING)
    taken = special_seconds(links, method, target, stable, DAMPING)
    return taken * stable / step * scenes.WATCHED


def notes(rows: DataFrame) -> list[Remark]:
    """Remarks on the time of a step, and on which method takes least."""
    counts = ", ".join(map(str, rows["links"].unique()))
    cost = _over(rows, "cost")
    fours, ones = (
        ", ".join(f"{ratio:.2f}" for ratio in cost[method])
        for method in ("thesis_runge_kutta", "euler")
    )
    least = {}
    for key in ("thesis", "c"):
        others = _over(rows, key).drop(columns="semi_implicit_euler")
        here = others.index[(others > 1).all(axis=1)]
        every = len(here) == len(others)
        least[key] = "every n" if every else f"n = {', '.join(map(str, here)) or 'none'}"
    return [
        Remark(
            "shown",
            "The table does not go with table 4.1 and one span. A step of the Runge-Kutta method "
            "solves the system four times, one of the Euler methods once; with the printed steps "
            f"and one span it would cost {fours} times a semi-implicit step (n = {counts}) instead "
            f"of 4, and a step of Euler's method {ones} times instead of 1. Other spans or other "
            "steps than the printed ones must have been used.",
        ),
        Remark(
            "estimated",
            "At the thesis's largest steps the semi-implicit Euler method costs least at "
            f"{least['thesis']} in the thesis and at {least['c']} in ours. Euler's method costs "
            f"{_words(_over(rows, 'c')['euler'])} times as much in ours (C), "
            f"{_words(_over(rows, 'thesis')['euler'])} times in the thesis (n = {counts}); its "
            f"steps alone are {_words(1 / _over(rows, 'step')['euler'])} times as many.",
        ),
    ]


def _over(rows: DataFrame, key: str) -> DataFrame:
    """A number of every method over that of the semi-implicit one, by links."""
    by = rows.pivot(index="links", columns="method", values=key)
    return by.div(by["semi_implicit_euler"], axis=0)


def _words(ratios: Series[float]) -> str:
    return ", ".join(f"{ratio:.2g}" if ratio < 10 else f"{ratio:.0f}" for ratio in ratios)


def _describe_factors(rows: DataFrame, target: str) -> str:
    """Describe over how many steps a target was timed, and how many times more the runs have."""
    name = {"c": "C", "numpy": "NumPy"}[target]
    factors = scenes.WATCHED / rows["step"] / STEPS[target]
    return f"{STEPS[target]} steps in {name}, multiplied {times(factors)}"
