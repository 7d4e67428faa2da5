"""The printed deviations, worked out again from the printed values."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

from rodgen_evidence.thesis import data, scenes
from rodgen_evidence.thesis.data import unit

ANALYTICAL, SIMULATED, NEITHER = "analytical value", "simulated value", "neither"


class Percentage(NamedTuple):
    """A printed deviation [%] beside (simulated - analytical) / base for both bases; base: the one
    it fits within the rounding of the printed values, or neither."""

    table: str
    row: str
    printed: float
    of_analytical: float
    of_simulated: float
    base: str

    @property
    def right(self) -> bool:
        """Whether it is relative to the analytical value, as the tables' captions have it."""
        return self.base == ANALYTICAL


def percentages() -> tuple[Percentage, ...]:
    """Every printed deviation of tables 3.1, 3.3, 3.4, 3.5 and 3.6."""
    tables = {
        "3.1": data.TABLE_3_1,
        "3.3": data.TABLE_3_3,
        "3.4": data.TABLE_3_4.assign(analytical=data.THRUST),
        "3.5": data.TABLE_3_5.assign(analytical=data.THRUST),
        # With more digits than are printed: the deviations were found to come from these.
        "3.6": data.TABLE_3_6.assign(
            analytical=lambda rows: [f"{beck(n):.6f}" for n in rows.links]
        ),
    }
    return tuple(
        _percentage(
            *(table, getattr(row, "name", None) or f"n = {row.links}"),
            *(row.analytical, row.simulated, row.percent),
        )
        for table, rows in tables.items()
        for row in rows.itertuples()
    )


def beck(links: float) -> float:
    """(3.4), for the length L - L/n [N]."""
    length = scenes.LENGTH - scenes.LENGTH / links
    return float(data.BECK_COEFFICIENT) * scenes.STIFFNESS / length**2


def base_of(table: str) -> str:
    """Describe from which base a table's deviations follow, in a sentence."""
    rows = [row for row in percentages() if row.table == table]
    wrong = [row for row in rows if not row.right]
    if not wrong:
        return "All printed deviations follow from the printed values."
    groups = []
    if of_simulated := [row.row for row in wrong if row.base == SIMULATED]:
        others = [row.row for row in rows if row.row not in of_simulated]
        few = len(of_simulated) <= len(others)
        which = ", ".join(of_simulated) if few else f"all but {', '.join(others) or 'none'}"
        groups.append(f"{which}: relative to the simulated instead of the analytical value")
    neither = [_neither(row) for row in wrong if row.base == NEITHER]
    if neither:
        groups.append(f"following from neither base: {', '.join(neither)}")
    return f"Printed deviations with slips: {'; '.join(groups)}."


def _neither(row: Percentage) -> str:
    """A row that fits no base, with what it should be and what may have happened."""
    values = {ANALYTICAL: row.of_analytical, SIMULATED: row.of_simulated}
    for base, value in values.items():
        text = f"{value:+.3f}"
        if sorted(text) == sorted(f"{row.printed:+.3f}"):
            return f"{row.row} ({row.printed:+.3f} %: {text} % of the {base}, two digits exchanged)"
    return f"{row.row} ({row.printed:+.3f} %, from the printed values {row.of_analytical:+.3f} %)"


def _percentage(table: str, row: str, analytical: str, simulated: str, percent: str) -> Percentage:
    a, s, printed = float(analytical), float(simulated), float(percent)

    def fits(by_simulated: bool) -> bool:
        """Whether values that round to the printed ones give the printed deviation."""
        ends = [
            100 * (s1 - a1) / (s1 if by_simulated else a1)
            for a1, s1 in product(_ends(analytical), _ends(simulated))
        ]
        slack = unit(percent) / 2 * (1 + 1e-9)
        return min(ends) - slack <= printed <= max(ends) + slack

    of_analytical, of_simulated = 100 * (s - a) / a, 100 * (s - a) / s
    # Both can fit where the deviation is small against the rounding: then the closer one counts.
    bases = [(ANALYTICAL, of_analytical, False), (SIMULATED, of_simulated, True)]
    fitting = [(abs(value - printed), name) for name, value, flag in bases if fits(flag)]
    base = min(fitting)[1] if fitting else NEITHER
    return Percentage(table, row, printed, of_analytical, of_simulated, base)


def _ends(printed: str) -> tuple[float, float]:
    return float(printed) - unit(printed) / 2, float(printed) + unit(printed) / 2
