"""Tables of what the rule of auto costs at equal error, and what the best rule could reach."""

from __future__ import annotations

from collections import defaultdict
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from rodgen_evidence.tolerance.equal_error import ALL, PLACES, Cost, costs
from rodgen_evidence.tolerance.measure.scene_record import AUTO, RTOLS

Record = dict[str, Any]

CANDIDATES = "dop853", "gauss", "radau"
DEAR = 1.5  # times the best, from which a choice is listed
FEW = 1e3, 2e3, 5e3, 1e4, 2e4, 5e4, 1e5, 2e5, 5e5, np.inf
TRANSIENT = 0.003, 0.01, 0.03, 0.1, 0.3, 0.6
STIFF = 0.0, 1e5, 3e5, 1e6, 3e6, np.inf


class Rule(NamedTuple):
    """dop853 where the fastest motion makes few radians; else gauss from a share of the critical
    damping on, radau where it makes very many; below that share a method of its own."""

    few: float
    decays: float
    stiff: float
    swinging: str

    def __call__(self, features: Record) -> str:
        if features["cycles"] is None or features["cycles"] < self.few:
            return "dop853"
        if features["damping"] <= self.decays:
            return self.swinging
        return "radau" if features["cycles"] > self.stiff else "gauss"

    def __str__(self) -> str:
        few, stiff = (f"{x:.0e}" if np.isfinite(x) else "any" for x in (self.few, self.stiff))
        return f"{few}; {self.swinging}; {self.decays:g}; gauss to {stiff}"


def show_costs(lines: list[Record], console: Console) -> None:
    """Print what auto costs, by all quantities and by places alone; choices that are dear; rules
    that would be better. A run whose errors no other method reaches has no part in what auto and
    single methods cost, and counts as the best for rules."""
    for kinds, name in ((ALL, "with rates"), (PLACES, "angles and positions alone")):
        found = [cost for line in lines if line["reference"] for cost in costs(line, kinds)]
        console.print(_summary(found, lines, f"time over the best at equal error, {name}"))
        if kinds == ALL:
            _dear(found, lines, console)


def _summary(found: list[Cost], lines: list[Record], title: str) -> Table:
    table = Table(title=f"{title}: median / 95 % / worst")
    rules = "auto", "best method of each run", "best thresholds"
    for column in ("rtol", "runs", *rules, "these thresholds", *CANDIDATES):
        table.add_column(column, justify="right")
    for rtol in (*RTOLS, None):
        at = [cost for cost in found if rtol in (None, cost.rtol)]
        options = by_method(at)
        auto = [cost.times for cost in at if cost.method == AUTO and not cost.alone]
        if not auto:
            continue
        oracle = [min(option.values()) for option in options.values() if option]
        cells = [_cell(auto), _cell(oracle), "", ""]
        if rtol:
            rule, reached = best_rule(options, lines)
            cells[2:] = _cell(reached), str(rule)
        alone = [[c.times for c in at if c.method == m and not c.alone] for m in CANDIDATES]
        table.add_row(f"{rtol:g}" if rtol else "all", str(len(auto)), *cells, *map(_cell, alone))
    return table


def by_method(found: list[Cost]) -> dict[tuple[int, float], dict[str, float]]:
    """Costs of the candidates in every scene and tolerance in which all that ended are known."""
    options: dict[tuple[int, float], dict[str, float]] = defaultdict(dict)
    for cost in found:
        if cost.method in CANDIDATES:
            options[cost.seed, cost.rtol][cost.method] = cost.times
    known = options.items()
    return {key: each for key, each in known if not np.isnan([*each.values()]).any()}


def best_rule(
    options: dict[tuple[int, float], dict[str, float]], lines: list[Record]
) -> tuple[Rule, list[float]]:
    """The rule of that form whose 95 % is least, then its mean; a run without an answer costs a
    hundred times the best."""
    features = {line["seed"]: line["features"] for line in lines}
    best: tuple[tuple[float, float], Rule, list[float]] | None = None
    for row in product(FEW, TRANSIENT, STIFF, ("dop853", "gauss")):
        rule = Rule(*row)
        reached = [option.get(rule(features[seed]), 100.0) for (seed, _), option in options.items()]
        judged = float(np.percentile(reached, 95)), float(np.mean(np.log(reached)))
        if best is None or judged < best[0]:
            best = judged, rule, reached
    assert best is not None
    return best[1], best[2]


def _cell(values: list[float]) -> str:
    if not values:
        return ""
    parts = *np.percentile(values, [50, 95]), max(values)
    return " / ".join(f"{part:.3g}" for part in parts)


def _dear(found: list[Cost], lines: list[Record], console: Console) -> None:
    """Print the choices of auto that cost too much, with what the rule looks at."""
    known = {line["seed"]: line for line in lines}
    mine = sorted((c for c in found if c.method == AUTO and c.times > DEAR), key=lambda c: -c.times)
    for cost in mine:
        line = known[cost.seed]
        f = line["features"]
        rows = (r for r in line["runs"] if (r["method"], r["rtol"]) == (AUTO, cost.rtol))
        row = next(rows)
        text = f"{cost.seed}: rtol {cost.rtol:g}: {row['chosen']} takes {cost.times:.3g} times the "
        text += f"time of {cost.best} ({row['seconds']:.3g} s): n = {f['n']}, {f['cycles']:.3g} "
        text += f"radians, damping {f['damping']:.3g}, growth {f['growth']:.2g}"
        console.print(text, highlight=False, markup=False, soft_wrap=True)
