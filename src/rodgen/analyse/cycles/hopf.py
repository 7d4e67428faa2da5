"""Hopf points where branches of cycles begin: the first along the equilibria, or one of a saved
branch; and their normal form: whether the cycles that begin there are stable and lie beyond
(supercritical), or unstable and before (subcritical).

With A = J at the equilibrium, A q = i w q, A^T p = -i w p, <p, q> = 1, and B, C the second and
third derivatives of the rates,

  2 c = <p, C(q, q, q~) - 2 B(q, A^-1 B(q, q~)) + B(q~, (2 i w - A)^-1 B(q, q))>,

z' = s z + c z |z|^2 on the centre manifold (Y. A. Kuznetsov, Elements of Applied Bifurcation
Theory, 3rd ed., 2004, section 5.4). B and C are differences of the generated Jacobian, of sixth
order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from rodgen.analyse.analysis_guard import check_whole_number
from rodgen.analyse.branches.equilibria import (
    HOPF,
    Equilibria,
    has_doubtful_counts,
    locate_crossing,
)
from rodgen.analyse.branches.equilibrium_data import FORMAT
from rodgen.analyse.branches.equilibrium_problems import equilibrium_problem
from rodgen.analyse.branches.steady_motions import SteadyMotions, motion_from_state
from rodgen.analyse.curves.continuation import StepControl, continue_curve
from rodgen.analyse.curves.curve import Curve, SpecialPoint
from rodgen.analyse.curves.curve_datasets import scene_of
from rodgen.analyse.cycles.cycle_search import CycleSearch
from rodgen.analyse.cycles.flow import Flow
from rodgen.analyse.scaled_load import RodRange
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.analyse.steady_state import find_steady_state
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.system import ParameterRange

if TYPE_CHECKING:
    import xarray

Complex = NDArray[np.complex128]
Places = NDArray[np.intp]
STEP = 0.02  # rad: of differences of sixth order, whose error is its sixth power
FIRST = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60
SECOND = np.array([2, -27, 270, -490, 270, -27, 2]) / 180
SMOOTH = 1e-3  # by which coefficients of two steps may differ
WEAKEST = 1e-12  # damping, with which an oscillation crosses
TOUCH = 1e-12  # of the frequency, a growth over the range that is none
STILL = 1e-9  # of the largest rates that a state could have: rounding
SIDE = 1e-4  # of the range, to either side of a Hopf point, of differences along the branch

STEPS = StepControl(first=0.005, longest=0.02)  # of the range


@dataclass(frozen=True)
class HopfPoint:
    """A Hopf point. value: of the number of the scene; frequency [rad/s]; slope: of the eigenvalue
    s by it; coefficient: c of the normal form; x: the equilibrium (size,); way: q (size,), whose
    largest angle is 1."""

    value: float
    frequency: float
    slope: complex
    coefficient: complex
    x: Array = field(repr=False)
    way: Complex = field(repr=False)

    @property
    def lyapunov(self) -> float:
        """The first Lyapunov coefficient, Re c over the frequency, for q of this length."""
        return self.coefficient.real / self.frequency

    @property
    def supercritical(self) -> bool:
        """Whether the cycles that begin here attract on the centre manifold."""
        return self.coefficient.real < 0

    def cycle_guess(self, amplitude: float) -> tuple[Array, float, float]:
        """State (size,), value and period [s], by the normal form, of the cycle whose angles differ
        from the equilibrium by at most an amplitude [rad]."""
        square = (amplitude / 2) ** 2
        aside = -self.coefficient.real / self.slope.real * square
        turned = self.frequency + self.coefficient.imag * square + self.slope.imag * aside
        x = self.x + amplitude * self.way.real
        return x, self.value + aside, 2 * np.pi / turned


Found = tuple[HopfPoint, Callable[[float], Flow]]  # and the flow at a value


def hopf_point(
    problem: Equilibria, special: SpecialPoint, at: Callable[[float], Flow]
) -> HopfPoint:
    """Compute the Hopf point at a special point of equilibria; at: gives the flow at a value.
    Raises AnalysisError where no oscillation crosses, and where there is no normal form."""
    value, frequency = problem.value(special.u), 2 * np.pi * special.frequency
    if problem.steady_state(special.u).has_kink:
        raise AnalysisError(
            f"no Hopf point at {value:.9g}: external damping is not smooth at rest, and no normal "
            "form has the cycles that begin there; start from a run"
        )
    if special.note:
        raise AnalysisError(f"no Hopf point at {value:.9g}: it is {special.note}")
    if problem.linearise(special.u, 1j * frequency).damping < WEAKEST:
        raise AnalysisError(
            f"no Hopf point: near {value:.9g} oscillations meet and do not cross, as they do "
            "without damping; give the scene some"
        )
    flow = at(value)
    of = flow.quotient
    x = problem.steady_state(special.u).y[of.kept]
    rates, A = flow.rates(0.0, x), flow.jacobian(0.0, x)
    if np.abs(rates).max() > STILL * (np.abs(A) @ np.maximum(np.abs(x), 1.0)).max():
        raise AnalysisError(
            f"no Hopf point at {value:.9g}: the rod is not at rest there, but accelerates in a way "
            "that its motion follows; start from a run"
        )
    step = SIDE * problem.along.numbers.unit

    def nearest_eigenvalue(there: float) -> complex:
        y = problem.steady_state(problem.solve_at(special.u, there)).y
        s = np.linalg.eigvals(at(there).jacobian(0.0, y[of.kept]))
        return complex(s[np.abs(s - 1j * frequency).argmin()])

    slope = (nearest_eigenvalue(value + step) - nearest_eigenvalue(value - step)) / (2 * step)
    if abs(slope.real) * problem.along.numbers.unit <= TOUCH * frequency:
        raise AnalysisError(f"the oscillation at {value:.9g} does not cross: it only touches")
    led = np.union1d(of.led, of.velocity)
    way, c = normal_form(lambda x: flow.jacobian(0.0, x), x, frequency, of.angles, led)
    return HopfPoint(value, frequency, slope, c, x, way)


def normal_form(
    J: Callable[[Array], Array], x: Array, frequency: float, angles: Places, rates: Places
) -> tuple[Complex, complex]:
    """Critical vector q (size,), its largest angle 1, and c of the normal form; angles, rates:
    indices of states that are angles, and rates of angles or places. Raises AnalysisError where the
    equations are not smooth."""
    A = J(x)
    s, left, right = scipy.linalg.eig(A, left=True)
    nearest = int(np.abs(s - 1j * frequency).argmin())
    q, p = right[:, nearest], left[:, nearest]
    q = q / q[angles[np.abs(q[angles]).argmax()]]
    p = p / (p.conj() @ q).conj()
    # Rates are as large as the frequency: the others tell how far a direction goes.
    units = np.ones(len(x))
    units[rates] = frequency
    steps = (STEP, STEP / 2)
    coefficients = [_coefficient(J, x, A, q, p, frequency, units, step) for step in steps]
    c, finer = coefficients
    if abs(c - finer) > SMOOTH * abs(finer):
        raise AnalysisError(
            "no normal form: the equations are not smooth there, as with external damping or drag"
        )
    return q, c


def _coefficient(
    J: Callable[[Array], Array],
    x: Array,
    A: Array,
    q: Complex,
    p: Complex,
    frequency: float,
    units: Array,
    step: float,
) -> complex:
    def derivatives_along(way: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """First and second derivatives of J along a direction."""
        size = float(np.abs(way / units).max())
        if not size:
            return np.zeros_like(A), np.zeros_like(A)
        h = step / size
        stack = np.array([J(x + k * h * way) for k in range(-3, 4)])
        first, second = (np.tensordot(w, stack, 1) for w in (FIRST, SECOND))
        return first / h, second / h**2

    (Ba, Caa), (Bb, Cbb) = derivatives_along(q.real), derivatives_along(q.imag)
    third = (Caa + Cbb) @ q
    qq, mixed = (Ba + 1j * Bb) @ q, (Ba + 1j * Bb) @ q.conj()
    still = np.linalg.lstsq(A, mixed.real, rcond=1e-10)[0]
    double = np.linalg.solve(2j * frequency * np.eye(len(A)) - A, qq)
    first = derivatives_along(still)[0] @ q
    conjugate = derivatives_along(double.real)[0] @ q.conj() + 1j * (
        derivatives_along(double.imag)[0] @ q.conj()
    )
    return complex(p.conj() @ (third - 2 * first + conjugate)) / 2


def first_hopf(search: CycleSearch, along: ParameterRange) -> Found:
    """Find the first Hopf point of a scene's equilibria from the first value of a range on. Raises
    AnalysisError where there is none."""
    if search.forced:
        raise AnalysisError(
            "no Hopf point: the loads repeat, and leave no equilibrium; start from a run"
        )
    return _hopf_and_flow(
        search, along, *_find_first(SteadyRod.of(along.at(along.bounds[0])), along)
    )


def read_hopf(
    search: CycleSearch, along: ParameterRange, data: xarray.Dataset, at: object
) -> Found:
    """Find the Hopf point of a saved branch of equilibria along the same key, by its number (1 is
    the first special point). Raises InputError for another point or branch, AnalysisError."""
    if data.attrs.get("format") != FORMAT.name or data.attrs["key"] != along.key:
        raise InputError("start", data.attrs.get("key"), f"a branch along {along.key}")
    other = scene_of(data)
    if other.structure != search.given.structure:
        raise InputError("start", other.name, "a branch of this scene")
    kinds = data["special_kind"].values.tolist()
    names = ", ".join(f"{k}: {kind}" for k, kind in enumerate(kinds, 1)) or "none"
    allowed = f"the number of a Hopf point (special points are {names})"
    number = check_whole_number(at, "point", 1, len(kinds), allowed)
    if kinds[number - 1] != HOPF:
        raise InputError("point", at, allowed)
    value, frequency = (float(data[f"special_{x}"][number - 1]) for x in ("value", "frequency"))
    before = int(data["special_after"][number - 1])
    y, force = data["y"].values[before], data["force"].values[before]
    rod = SteadyRod.of(along.at(value))
    numbers, p = RodRange(rod, along), rod.system.p
    problem: Equilibria
    if data.attrs["moving"]:
        problem = SteadyMotions(numbers, motion_from_state(rod, p, y))
    else:
        problem = equilibrium_problem(numbers, Equilibria.restore(rod, p, y, force))
    u = problem.solve_at(problem.pack(problem.start, float(data["value"][before])), value)
    special = locate_crossing(problem, problem.first_point(u, 1.0), 2j * np.pi * frequency)
    return _hopf_and_flow(search, along, problem, special)


def _find_first(rod: SteadyRod, along: ParameterRange) -> tuple[Equilibria, SpecialPoint]:
    """Find the first Hopf point of the branch that begins with the steady state of a rod. Raises
    AnalysisError where there is none, and KeyboardInterrupt."""
    state, (low, high) = find_steady_state(rod), along.bounds

    def stop_reason(curve: Curve) -> str:
        return "a Hopf point was found" if curve.special and curve.special[-1].kind == HOPF else ""

    for all_modes in (False, True):
        problem = equilibrium_problem(RodRange(rod, along), state, all_modes)
        first = problem.first_point(problem.pack(state, low), float(np.sign(high - low)))
        ends = problem.scale(min(low, high)), problem.scale(max(low, high))
        curve = continue_curve(problem, first, *ends, STEPS, until=stop_reason).raise_interrupt()
        if not has_doubtful_counts(problem, curve):
            break
    for special in curve.special:
        if special.kind == HOPF:
            return problem, special
    why = "no oscillation about the equilibrium begins to grow there"
    why = why if curve.complete else f"the branch of equilibria ends: {curve.end}"
    raise AnalysisError(f"no Hopf point from {low:.9g} to {high:.9g}: {problem.why_unknown or why}")


def _hopf_and_flow(
    search: CycleSearch, along: ParameterRange, problem: Equilibria, special: SpecialPoint
) -> tuple[HopfPoint, Callable[[float], Flow]]:
    y = problem.steady_state(special.u).y
    quotient = search.flow(0.0, y).quotient

    def flow_at(value: float) -> Flow:
        return Flow(search.model, along.parameters(value), quotient)

    return hopf_point(problem, special, flow_at), flow_at
