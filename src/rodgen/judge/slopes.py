"""Slopes of straight lines in logarithmic diagrams: observed orders, exponents of costs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from statistics import median

import numpy as np

from rodgen.judge.rows import fine, grouped, label, number, text
from rodgen.judge.unit import Row

COARSE = 0.1  # [rad], above which an error is no longer that of small steps
FLOOR = 1e-11  # [rad], below which rounding and the reference's own error are seen


def observed_orders(rows: Sequence[Row], floor: float = FLOOR) -> list[Row]:
    """Of methods with fixed steps: the median slope of their errors between successive steps."""
    fixed = [row for row in rows if fine(row) and row.get("kind") == "step"]
    lines: list[Row] = []
    for some in grouped(fixed, label).values():
        used = sorted(
            (number(row, "setting"), number(row, "error_phi"))
            for row in some
            if floor <= number(row, "error_phi") <= COARSE
        )
        slopes = [
            math.log(b / a) / math.log(larger / step)
            for (step, a), (larger, b) in pairwise(used)
            if larger > step
        ]
        shown = median(slopes) if slopes else None
        lines.append({**some[0], "observed": shown, "points": len(used)})
    return lines


def fits(rows: Sequence[Row]) -> list[Row]:
    """Exponents of seconds against links, by least squares of the logarithms."""
    lines: list[Row] = []
    timed = [row for row in rows if fine(row) and number(row, "seconds") > 0]
    for some in grouped(timed, lambda row: f"{text(row, 'what')}\0{text(row, 'who')}").values():
        n = np.array([number(row, "n") for row in some])
        seconds = np.log([number(row, "seconds") for row in some])
        if len(set(n)) < 2:
            continue
        exponent, start = np.polyfit(np.log(n), seconds, 1)
        off = np.expm1(np.abs(seconds - exponent * np.log(n) - start)).max()
        kept = {key: some[0].get(key) for key in ("what", "who")}
        span = {"first": float(n.min()), "last": float(n.max())}
        lines.append({**kept, "exponent": float(exponent), **span, "off": float(off)})
    return lines
