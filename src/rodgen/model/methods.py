"""Methods of integration as data: order, who takes the steps, and coefficients, a row each.

Whatever has a row here is known everywhere.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Literal


@dataclass(frozen=True)
class Tableau:
    """An explicit Runge-Kutta method of s stages, in exact numbers (J. C. Butcher 1964).

    A: of each stage the weights of the rates of those before it, row by row; b: weights of the
    step, (s,); c: times of the stages as shares of the step, if not given the sums of the rows.
    follow: positions do not move by rates of their own, but over the whole step by the velocities
    that a stage or the step arrives at, as those of symplectic Euler do.
    """

    A: tuple[tuple[Fraction | int, ...], ...]
    b: tuple[Fraction | int, ...]
    c: tuple[Fraction | int, ...] = ()
    follow: bool = False

    def __post_init__(self) -> None:
        s = len(self.b)
        if [len(row) for row in self.A] != list(range(s)):
            raise ValueError(f"A has rows of 0 to {s - 1} weights for {s} stages")
        object.__setattr__(self, "c", self.c or tuple(sum(row) for row in self.A))
        if len(self.c) != s:
            raise ValueError(f"c has {len(self.c)} times for {s} stages")

    @property
    def rows(self) -> tuple[tuple[Fraction | int, ...], ...]:
        """The weights of all sums: of the stages after the first, then of the step."""
        return (*self.A[1:], self.b)


@dataclass(frozen=True)
class CollocationRule:
    """Collocation at three points, the zeros of the derivative of order a of x^a (x - 1)^b on
    [0, 1] (E. Hairer, G. Wanner: Solving Ordinary Differential Equations II, IV.5).

    powers: a and b; power, weight: the error that two steps in a row tell of grows with this power
    of the step, and is weighed by that, so that the error of a run is a tenth of its tolerance.
    """

    powers: tuple[int, int]
    power: int
    weight: float


@dataclass(frozen=True, kw_only=True)
class Method:
    """A method of integration, as scenes, both targets, documentation and tests know it.

    order: that of the error, or the highest where it varies; steps: all equal, chosen by error
    control, or whichever the scene asks for; about: what it is, in a few words; citation: where it
    is from. Its steps follow from the tableau or the collocation, or are those of a class of
    scipy.integrate; other libraries have a file of their own in integrate/. compiled: whether the
    C target has a loop of its own for it, beside the one for every tableau. per_step: share of the
    tolerance that the estimated error of one step may be, so that what steps add up to, and what
    the estimate does not see, is some tolerances.
    """

    name: str
    order: int
    varies: bool = False
    steps: Literal["fixed", "adaptive", "either"]
    implicit: bool = False
    about: str
    citation: str
    tableau: Tableau | None = None
    collocation: CollocationRule | None = None
    scipy: str = ""
    compiled: bool = False
    per_step: float = 1.0

    @property
    def in_c(self) -> bool:
        """Whether its steps are taken in C."""
        return self.compiled or self.tableau is not None


HALF, THIRD, SIXTH = Fraction(1, 2), Fraction(1, 3), Fraction(1, 6)
RK4 = Tableau(A=((), (HALF,), (0, HALF), (0, 0, 1)), b=(SIXTH, THIRD, THIRD, SIXTH))

# Of DOP853, the last part of the dense output over what is tolerated of a step, times its length:
# the root mean square up to which states inside the step are by dense output. Their error is about
# a seventh of what that part adds at most, (4/7)^4 (3/7)^3 of it: of y' = lambda y + t^q, by h
# |lambda| = 0.5 to 6 and q = 0 to 8, less than 0.17 of it at 95 of 100 places, and more only where
# the part is next to zero. Close to the limit of stability it is a hundred times that of the step,
# of a motion that dies out.
BETWEEN = 30.0  # times what is tolerated of a step
LARGEST_LAST = BETWEEN / (0.15 * (4 / 7) ** 4 * (3 / 7) ** 3)
HALVED = 2.0**7  # That part falls with the seventh power of a length at least.
MOST_PARTS = 64  # of a step, by each of which there is dense output

# The methods, in the order of lists.
ROWS = (
    # y(t + h) = y + h f(t, y)
    Method(
        name="euler",
        order=1,
        steps="fixed",
        about="explicit, fixed step",
        citation="L. Euler 1768; thesis 1.75",
        tableau=Tableau(A=((),), b=(1,)),
    ),
    # v(t + h) = v + h a(t, q, v),    q(t + h) = q + h v(t + h)
    # Symplectic for a force that depends on the position alone and a constant mass matrix.
    Method(
        name="semi_implicit_euler",
        order=1,
        steps="fixed",
        about="velocities first, positions with the new ones; "
        "[its energy grows](#what-keeps-energy)",
        citation="thesis 1.83",
        tableau=Tableau(A=((),), b=(1,), follow=True),
    ),
    Method(
        name="rk4",
        order=4,
        steps="fixed",
        about="the classical Runge-Kutta method",
        citation="W. Kutta 1901; thesis 1.84",
        tableau=RK4,
    ),
    # The Runge-Kutta method as the thesis's Java has it. With q positions, v velocities, a(q, v)
    # accelerations at the time t at which the step starts:
    #
    #     a1 = a(q, v)
    #     a2 = a(q + h v2, v2),  v2 = v + h/2 a1
    #     a3 = a(q + h v3, v3),  v3 = v + h/2 a2
    #     a4 = a(q + h v4, v4),  v4 = v + h a3
    #     v(t + h) = v + h/6 (a1 + 2 a2 + 2 a3 + a4),    q(t + h) = q + h v(t + h)
    #
    # Halved accelerations are carried over the whole step, positions by velocities that are updated
    # already: no stage is at a midpoint, and (1.84), of order 4, is another method, rk4. A free
    # oscillation of frequency omega is damped as by the ratio 5/12 h omega.
    Method(
        name="thesis_runge_kutta",
        order=1,
        steps="fixed",
        about="as the listing of the thesis advances the state",
        citation="thesis 4.1.3, appendix A",
        tableau=replace(RK4, c=(0, 0, 0, 0), follow=True),
    ),
    # Dormand and Prince's method, its error estimated by order 5 and 3.
    Method(
        name="dop853",
        order=8,
        steps="adaptive",
        about="explicit, error control, dense output of order 7",
        citation="E. Hairer, S. P. Norsett, G. Wanner: Solving Ordinary Differential Equations I, "
        "II.5",
        scipy="DOP853",
        compiled=True,
        per_step=1 / 60,
    ),
    # Three points: it neither damps nor drives an oscillation.
    Method(
        name="gauss",
        order=6,
        steps="either",
        implicit=True,
        about="implicit, error control, dense output of order 5: for oscillating stiffness",
        citation="E. Hairer, C. Lubich, G. Wanner: Geometric Numerical Integration, II.1",
        collocation=CollocationRule(powers=(3, 3), power=6, weight=7.0),
        compiled=True,
    ),
    # Three points with the end among them (Radau IIA): L-stable.
    Method(
        name="radau",
        order=5,
        steps="adaptive",
        implicit=True,
        about="implicit, L-stable, error control, dense output of order 4: for strong damping",
        citation="E. Hairer, G. Wanner: Solving Ordinary Differential Equations II, IV.8",
        collocation=CollocationRule(powers=(2, 3), power=5, weight=4.5),
        scipy="Radau",
        compiled=True,
    ),
    # Bogacki and Shampine's pair of orders 3 and 2.
    Method(
        name="rk23",
        order=3,
        steps="adaptive",
        about="explicit, error control",
        citation="P. Bogacki, L. F. Shampine 1989",
        scipy="RK23",
        per_step=1 / 10,
    ),
    # Dormand and Prince's pair of orders 5 and 4.
    Method(
        name="rk45",
        order=5,
        steps="adaptive",
        about="explicit, error control",
        citation="J. R. Dormand, P. J. Prince 1980",
        scipy="RK45",
        per_step=1 / 10,
    ),
    # Orders 1 to 5.
    Method(
        name="bdf",
        order=5,
        steps="adaptive",
        varies=True,
        implicit=True,
        about="implicit, backward differentiation",
        citation="L. F. Shampine, M. W. Reichelt 1997",
        scipy="BDF",
    ),
    Method(
        name="lsoda",
        order=12,
        steps="adaptive",
        varies=True,
        implicit=True,
        about="Adams or, where it is stiff, backward differentiation",
        citation="L. Petzold 1983",
        scipy="LSODA",
    ),
    Method(
        name="cvode",
        order=12,
        steps="adaptive",
        varies=True,
        implicit=True,
        about="Adams methods, by scikit-sundae, with `rodgen[cvode]`",
        citation="A. C. Hindmarsh et al. 2005",
    ),
)
METHODS = {method.name: method for method in ROWS}
FIXED_STEP = tuple(name for name, method in METHODS.items() if method.steps == "fixed")
ADAPTIVE = tuple(name for name, method in METHODS.items() if method.steps != "fixed")
# Adaptive methods that take equal steps where a step is given.
EITHER = tuple(name for name, method in METHODS.items() if method.steps == "either")
TABLEAUX = {name: method.tableau for name, method in METHODS.items() if method.tableau}
COLLOCATION = {name: method.collocation for name, method in METHODS.items() if method.collocation}
# What steps in C, by its number there.
COMPILED = (
    *(name for name, method in METHODS.items() if method.in_c),
    *(f"{name}_equal_steps" for name in EITHER if METHODS[name].in_c),
)


def stability_polynomial(A: Collection[Collection[Any]], b: Collection[Any]) -> list[float]:
    """Coefficients of 1, z, z^2, ... of the stability polynomial 1 + sum z^(k+1) b A^k 1 of an
    explicit Runge-Kutta method, z = h lambda: its step multiplies the solution of y' = lambda y by
    that (E. Hairer, G. Wanner: Solving Ordinary Differential Equations II, IV.2)."""

    def dot(row: Collection[Any], column: Collection[Any]) -> Any:
        return sum(x * y for x, y in zip(row, column, strict=False))  # rows may lack their zeros

    found, power = [1.0], [1] * len(b)
    for _ in b:
        found.append(float(dot(b, power)))
        power = [dot(row, power) for row in A]
    return found
