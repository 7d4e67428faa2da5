"""Section "rounding": errors of rhs in units of the last place, beside the unavoidable."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
from mpmath import mp, mpf
from pandas import DataFrame, Series
from scipy import sparse
from scipy.linalg import eig_banded

import rodgen
from rodgen.analyse.precision.contestant import Measurement
from rodgen.model.rod import BOUNDARIES
from rodgen_evidence.report.peers import chain_accelerations
from rodgen_evidence.report.stability.rounding_states import ROD, Array, ExtremeState, extremes
from rodgen_evidence.report.unit import Unit

LOSES = 10.0  # times what another form and rounded input come to, from which on digits are lost
Number = Any  # of mpmath, which has no types
DIGITS = 60  # ten for what the worst of the conditions takes
DENSE = 400  # unknowns up to which the mass matrix is looked at
BAND = 3  # of the joint forces: a joint and the next, x and y of each
EXACT = chain_accelerations.Algebra(mp.cos, mp.sin, mp.sqrt, real=mpf)


def exact_rates(model: ModuleType, values: Mapping[str, Any], y: Array) -> list[Number]:
    """Second half of dy/dt (states/2,) in DIGITS digits; values: parameters by name."""
    rod = rodgen.Structure(model.N, model.BOUNDARY, model.INERTIA, tuple(model.TERMS))
    with mpmath.workdps(DIGITS):
        given = {
            name: [mpf(float(v)) for v in value] if np.ndim(value) else mpf(float(value))
            for name, value in values.items()
        }
        q, u = ([mpf(float(v)) for v in half] for half in np.split(y, 2))
        return chain_accelerations.accelerations(rod, given, q, u, EXACT)


def dense_condition(model: ModuleType, y: Array, p: Array) -> float | None:
    """Condition of the mass matrix; None where it is too large to be looked at."""
    if len(y) // 2 > DENSE:
        return None
    M = model.mass_matrix(y, p)
    diagonal = np.sqrt(np.diag(M))
    return _condition(np.linalg.eigvalsh(M / np.outer(diagonal, diagonal)))


def chain_condition(model: ModuleType, y: Array) -> float | None:
    """Condition of the system of the joint forces (uniform mass) or tensions (lumped mass).

    None where there is no such system, as for one free link.
    """
    boundary_condition = BOUNDARIES[model.BOUNDARY]
    phi = y[2 * boundary_condition.translates : len(y) // 2]
    system = sparse.triu(
        constraints(phi, not boundary_condition.translates, model.INERTIA == "lumped")
    ).todia()
    if not system.shape[1]:
        return None
    band = np.zeros((BAND + 1, system.shape[1]))
    for offset, diagonal in zip(system.offsets, system.data, strict=True):
        band[BAND - offset, : len(diagonal)] = diagonal
    return _condition(eig_banded(band, eigvals_only=True))


def constraints(phi: Array, held: bool, lumped: bool) -> Any:
    """G W G^T, sparse, with the constraints' Jacobian G and the inverse W of the masses of free
    links, or of free joints, here over the mass of a link."""
    n = len(phi)
    # What the ends of the links do to the joints: each its start, and its end the other way.
    ends = sparse.diags_array([-np.ones(n), np.ones(n)], offsets=[0, -1], shape=(n + 1, n))
    x, y = np.array([[1.0], [0.0]]), np.array([[0.0], [1.0]])
    if lumped:  # of links, with masses of one at the joints, of half of that at the ends
        inverse = np.repeat([0.0 if held else 2.0, *[1.0] * (n - 1), 2.0], 2)
        G = sparse.diags_array(np.cos(phi)) @ sparse.kron(ends.T, x.T)
        G += sparse.diags_array(np.sin(phi)) @ sparse.kron(ends.T, y.T)
        return G @ sparse.diags_array(inverse) @ G.T
    turning = sparse.kron(abs(ends), x) @ sparse.diags_array(-np.sin(phi))
    turning += sparse.kron(abs(ends), y) @ sparse.diags_array(np.cos(phi))
    whole = sparse.kron(ends @ ends.T, np.eye(2)) + 3 * turning @ turning.T
    return whole.tocsr()[2 * (not held) : 2 * n, 2 * (not held) : 2 * n]


def _condition(values: Array) -> float:
    """Condition of a symmetric matrix with these eigenvalues, in rising order."""
    return float(values[-1] / values[0]) if values[0] > 0 else float("inf")


KINDS = (("free", "uniform"), ("pinned", "uniform"), ("clamped", "lumped"), ("free", "lumped"))
LINKS = {"free-uniform": (1, 2, 3, 5, 20, 50, 200, 1000)}
OTHERS, QUICK = (5, 20), (20,)
MOST = 200  # links: of the dense form, and with which all cases are affordable
DRAWS = 4  # of inputs that are off
FORMS: dict[str, tuple[str, str]] = {
    "c": ("c", "chain"),
    "numpy chain": ("numpy", "chain"),
    "numpy dense": ("numpy", "dense"),
}


def units(_: object, quick: bool, *__: object) -> list[Unit]:
    """Plan units by kind of rod and number of links; scenes of the report have no part in it."""
    made = []
    for boundary, inertia in KINDS[: 1 if quick else None]:
        kind = f"{boundary}-{inertia}"
        for links in QUICK if quick else LINKS.get(kind, OTHERS):
            call = {"links": links, "boundary": boundary, "inertia": inertia}
            name = f"rounding-{kind}-n{links}"
            made.append(Unit("rounding", name, f"{__name__}:errors", call, False, 180.0))
    return made


def errors(links: int, boundary: str = "free", inertia: str = "uniform") -> list[Measurement]:
    """All forms at all extremes."""
    structure = rodgen.Structure(links, boundary, inertia)
    forms = {
        name: rodgen.build(structure, target, form)
        for name, (target, form) in FORMS.items()
        if form == "chain" or links <= MOST
    }
    rows: list[Measurement] = []
    for extreme in extremes(links):
        if extreme.few or links <= MOST:
            rows += _rounding_rows(forms, extreme, DRAWS if links <= MOST else 1)
    return rows


def _rounding_rows(
    forms: Mapping[str, ModuleType], extreme: ExtremeState, draws: int
) -> list[Measurement]:
    model = next(iter(forms.values()))
    y, values = state(model, extreme), parameters(model, extreme)
    p = model.parameters(**values)
    truth = exact_rates(model, values, y)
    unit = Units(model, values, truth)
    inputs = unit.off_inputs(y, draws)
    conditions = {"chain": chain_condition(model, y), "dense": dense_condition(model, y, p)}
    rows: list[Measurement] = []
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


def state(model: ModuleType, extreme: ExtremeState) -> Array:
    """The shape as a state of a module."""
    shape, free = extreme.shape, model.BOUNDARY == "free"
    base, velocity = (shape.base, shape.velocity) if free else ((), ())
    return np.concatenate((base, shape.phi, velocity, shape.omega))


def parameters(model: ModuleType, extreme: ExtremeState) -> dict[str, Any]:
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
            values = {name: _neighbours(value, draw) for name, value in self.values.items()}
            rates = exact_rates(self.model, values, _neighbours(y, draw))
            worst = max(worst, self._distance(rates))
        return worst

    def _distance(self, rates: Iterable[Number]) -> float:
        with mpmath.workdps(DIGITS):
            pairs = zip(rates, self.truth, self.scale, strict=True)
            return float(max(abs((a - b) * s) for a, b, s in pairs) / self.one)


def _neighbours(value: Any, draw: np.random.Generator) -> Array:
    """Move each value by a unit of its last place, up or down."""
    values = np.asarray(value, dtype=float)
    return np.asarray(np.nextafter(values, draw.choice((-np.inf, np.inf), values.shape)))


def excess(rows: DataFrame) -> Series[float]:
    """Errors of rhs over what rounded input makes unavoidable, at least a unit."""
    return rows["ulps"] / np.fmax(rows["ulps_input"], 1.0)


def losing(rows: DataFrame) -> DataFrame:
    """Rows of forms of rhs that lose digits which another form keeps, and rounded input leaves."""
    good = rows[rows["failed"] == ""]
    place = good.groupby(["kind", "n", "group", "case"], sort=False, dropna=False)
    least = place["ulps"].transform("min")
    explained = np.fmax(np.fmax(least, good["ulps_input"]), 1.0)
    return good[good["ulps"] > LOSES * explained]
