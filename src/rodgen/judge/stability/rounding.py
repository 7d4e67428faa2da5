"""Error of the rates in units of the last place, against arithmetic of 60 digits.

Measured on the accelerations with lengths in links, (a_x/l, a_y/l, alpha): largest error over the
unit of the last place of the largest entry. Beside it what cannot be avoided, the change that
y and p make that are off by a unit of their last places each, and the condition numbers of
the linear systems that are solved: the joint forces (chain), the mass matrix with its diagonal
scaled to one (dense).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
from mpmath import mpf

import rodgen
from rodgen.judge.cases import Case
from rodgen.judge.stability.rounding_cases import ROD, Array, Extreme, extremes
from rodgen.judge.stability.rounding_condition import chain_condition, dense_condition
from rodgen.judge.stability.rounding_exact import DIGITS, Number, exact_rates
from rodgen.judge.unit import Row, Unit

KINDS = (("free", "uniform"), ("pinned", "uniform"), ("clamped", "lumped"), ("free", "lumped"))
LINKS = {"free-uniform": (1, 2, 3, 5, 20, 50, 200, 1000)}
OTHERS, QUICK = (5, 20), (20,)
MOST = 200  # links: of the dense form, and with which all cases are affordable
DRAWS = 4  # of inputs that are off
LOST = 10.0  # times what the dense form and the inputs explain: a defect of the chain form
FORMS: dict[str, tuple[str, str]] = {
    "c": ("c", "chain"),
    "numpy chain": ("numpy", "chain"),
    "numpy dense": ("numpy", "dense"),
}
Rates = Callable[[Array, Array], Array]  # y, p -> dy/dt


def units(_: list[Case], quick: bool) -> list[Unit]:
    """By kind of rod and number of links; the scenes of the report have no part in it."""
    made = []
    for boundary, inertia in KINDS[: 1 if quick else None]:
        kind = f"{boundary}-{inertia}"
        for links in QUICK if quick else LINKS.get(kind, OTHERS):
            call = {"links": links, "boundary": boundary, "inertia": inertia}
            name = f"rounding-{kind}-n{links}"
            made.append(Unit("rounding", name, f"{__name__}:errors", call, False, 180.0))
    return made


def errors(links: int, boundary: str = "free", inertia: str = "uniform") -> list[Row]:
    """All forms at all extremes."""
    structure = rodgen.Structure(links, boundary, inertia)
    forms = {
        name: rodgen.build(structure, target, form)
        for name, (target, form) in FORMS.items()
        if form == "chain" or links <= MOST
    }
    rows: list[Row] = []
    for extreme in extremes(links):
        if extreme.few or links <= MOST:
            rows += _judged(forms, extreme, DRAWS if links <= MOST else 1)
    return rows


def _judged(forms: Mapping[str, ModuleType], extreme: Extreme, draws: int) -> list[Row]:
    model = next(iter(forms.values()))
    y, values = state(model, extreme), parameters(model, extreme)
    p = model.parameters(**values)
    truth = exact_rates(model, values, y)
    unit = Units(model, values, truth)
    inputs = unit.off_inputs(y, draws)
    conditions = {"chain": chain_condition(model, y), "dense": dense_condition(model, y, p)}
    rows: list[Row] = []
    for form, module in forms.items():
        with np.errstate(all="ignore"):
            got = module.rhs(0.0, y, p)
        rows.append(
            {
                "group": extreme.group,
                "case": extreme.case,
                "kind": f"{model.BOUNDARY}, {model.INERTIA}",
                "form": form,
                "n": model.N,
                "ulps": unit.off(got),
                "ulps_input": inputs,
                "condition": conditions[FORMS[form][1]],
                "largest": float(unit.largest),
                "failed": "" if np.isfinite(got).all() else "not finite",
            }
        )
    return rows


def state(model: ModuleType, extreme: Extreme) -> Array:
    """The shape as a state of a module."""
    shape, free = extreme.shape, model.BOUNDARY == "free"
    base, velocity = (shape.base, shape.velocity) if free else ((), ())
    return np.concatenate((base, shape.phi, velocity, shape.omega))


def parameters(model: ModuleType, extreme: Extreme) -> dict[str, Any]:
    """Values by name; fins that differ."""
    fins = [1.0 + 0.5 * (at % 3) for at in range(model.N + 1)]
    values = {**ROD, **extreme.values, "fin_factor": fins}
    return values | ({"clamp_angle": 0.2} if "clamp_angle" in model.PARAMETERS else {})


class Units:
    """Units of the last place of the accelerations of one state."""

    def __init__(self, model: ModuleType, values: Mapping[str, Any], truth: list[Number]):
        self.model, self.values, self.truth = model, values, truth
        moves = 2 * (model.BOUNDARY == "free")
        with mpmath.workdps(DIGITS):
            link = mpf(values["length"]) / model.N
            self.scale = [1 / link] * moves + [mpf(1)] * (len(truth) - moves)
            self.largest = max(abs(a * s) for a, s in zip(truth, self.scale, strict=True))
            self.one = mpf(float(np.spacing(float(self.largest))))

    def off(self, got: Array) -> float:
        """Error of dy/dt, or infinity where it is not finite."""
        rates = got[len(got) // 2 :]
        if not np.isfinite(rates).all():
            return float("inf")
        return self._distance([mpf(float(rate)) for rate in rates])

    def off_inputs(self, y: Array, draws: int) -> float:
        """The largest change that draws of y and p make, each value off by a unit, up or down."""
        draw, worst = np.random.default_rng(7), 0.0
        for _ in range(draws):
            values = {name: _moved(value, draw) for name, value in self.values.items()}
            rates = exact_rates(self.model, values, _moved(y, draw))
            worst = max(worst, self._distance(rates))
        return worst

    def _distance(self, rates: Iterable[Number]) -> float:
        with mpmath.workdps(DIGITS):
            pairs = zip(rates, self.truth, self.scale, strict=True)
            return float(max(abs((a - b) * s) for a, b, s in pairs) / self.one)


def _moved(value: Any, draw: np.random.Generator) -> Array:
    """Values, each a unit of its last place up or down."""
    values = np.asarray(value, dtype=float)
    return np.asarray(np.nextafter(values, draw.choice((-np.inf, np.inf), values.shape)))


def lost(rows: Iterable[Row]) -> list[Row]:
    """Rows of the chain form that lose digits which the dense form keeps, beyond its inputs."""
    rows = list(rows)
    key = ("kind", "n", "group", "case")
    dense = {tuple(r[k] for k in key): r["ulps"] for r in rows if r["form"] == "numpy dense"}
    found = []
    for row in rows:
        other = dense.get(tuple(row[k] for k in key))
        explained = max(float(other or 0), float(row["ulps_input"] or 0), 1.0)  # type: ignore[arg-type]
        if other is not None and float(row["ulps"] or 0) > LOST * explained:  # type: ignore[arg-type]
            found.append(row)
    return found
