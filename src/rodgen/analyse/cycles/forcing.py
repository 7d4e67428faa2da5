"""Period with which the loads of a scene repeat, if they have not come to rest."""

from __future__ import annotations

import ast
import math
from collections.abc import Iterable, Iterator
from fractions import Fraction
from types import ModuleType

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.system import System

TAIL = 0.1  # share of the span at its end in which loads have to be what they stay
TIMES = 48  # in it, at which they are compared
SAME = 1e-10  # of the rates: roundings of t times a frequency
MOST_TURNS = 60  # of one load while another makes a whole number as well
PARTS = (6, 5, 4, 3, 2)  # of a common period that may be one already: sin(t)**2
SWINGS = ("sin", "cos", "tan")


def load_period(system: System, model: ModuleType) -> float:
    """Find the period [s] with which a system's loads repeat at the end of its span; 0 where they
    no longer change there.

    It follows from the arguments of sin, cos and tan, and is checked with the rates themselves.
    Raises InputError for masses that change, AnalysisError for loads that do neither.
    """
    scene, p = system.scene, system.p
    changing = scene.distribution.changing_masses
    if changing:
        field = changing[0][-1].field
        raise InputError(
            field, changing[0][-1].text, "a number: no motion repeats while it changes"
        )
    start, end = scene.integrate.span
    random = np.random.default_rng(2)
    times = end - TAIL * (end - start) * random.random(TIMES)
    y = system.y0
    y = y + 0.1 * random.standard_normal(len(y))

    def rates(at: Array) -> Array:
        return np.array([model.rhs(float(t), y, p) for t in at])

    here = rates(times)
    size = np.abs(here).max()

    def is_period(period: float) -> bool:
        return bool(np.abs(rates(times + period) - here).max() <= SAME * size)

    if np.abs(here - here[0]).max() <= SAME * size:
        return 0.0
    found = _common_multiple(_periods(scene, end))
    for part in PARTS if found else ():
        if is_period(found / part):
            return found / part
    if found and is_period(found):
        return found
    texts = [e.text for e in (*scene.expressions.values(), *scene.state_rates.values())]
    raise AnalysisError(
        f"no cycle: the loads ({'; '.join(texts)}) neither come to rest nor are seen to repeat "
        f"in the last tenth of the span, up to {end:g} s"
    )


def _periods(scene: Scene, end: float) -> Iterator[float]:
    """Periods [s] of sin, cos and tan in the expressions of a scene."""
    for e in (*scene.expressions.values(), *scene.state_rates.values()):
        for node in ast.walk(ast.parse(e.text, mode="eval")):
            if isinstance(node, ast.Call) and _is_periodic(node):
                slope = _argument_rate(ast.unparse(node.args[0]), e, end)
                if slope:
                    yield 2 * math.pi / slope


def _is_periodic(node: ast.Call) -> bool:
    """Whether a call is of a periodic function."""
    return isinstance(node.func, ast.Name) and node.func.id in SWINGS


def _argument_rate(text: str, of: Expression, end: float) -> float:
    """Rate of an argument [1/s], without its sign; 0 if it is not linear in t alone."""
    try:
        argument = Expression(text, of.variable, of.field, of.numbers)
        values = [float(argument(t)) for t in (end, end + 1.0, end + 2.0)]
    except (InputError, TypeError, NameError, KeyError):
        return 0.0
    slope = values[1] - values[0]
    even = abs(values[2] - values[1] - slope) <= 1e-9 * max(abs(slope), 1e-9)
    return abs(slope) if even and math.isfinite(slope) else 0.0


def _common_multiple(periods: Iterable[float]) -> float:
    """Least common multiple of periods; 0 where there is none."""
    common = 0.0
    for period in periods:
        if not common:
            common = period
            continue
        ratio = Fraction(common / period).limit_denominator(MOST_TURNS)
        if not ratio or abs(float(ratio) * period - common) > 1e-9 * common:
            return 0.0
        common *= ratio.denominator
    return common
