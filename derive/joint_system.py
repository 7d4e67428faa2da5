"""The block-tridiagonal system of a chain's constraints, for both forms of derivation 3.

Links (or, where all mass sits at their ends, joints) move freely and are held together by
constraints. LagrangesMethod with ``hol_coneqs`` on a generic cell gives the equations of motion
with multipliers and the constraints on the accelerations; putting the first into the second
leaves a symmetric positive definite block-tridiagonal system for the multipliers, so that
accelerations cost O(n).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from sympy import (
    Add,
    Eq,
    Expr,
    Indexed,
    IndexedBase,
    Integer,
    Matrix,
    Piecewise,
    S,
    Symbol,
    expand,
    factor_terms,
)
from sympy.physics.mechanics import LagrangesMethod

from .chain import Vector
from .general import GeneralEquations
from .symbols import Array, i, n, s

# Multipliers: the force in joint s over the mass of a link [m/s^2], with which it pulls the link
# before it; the tension in link i over the mass of a link.
lambda_x, lambda_y = IndexedBase("lambda_x", real=True), IndexedBase("lambda_y", real=True)
tension = IndexedBase("tension", real=True)
# Moment of springs and dampers on link i.
link_moment = IndexedBase("link_moment", real=True)
# Without joint forces: angular acceleration of link i, and the acceleration of its ends towards
# its centre of gravity; of the end after it alone, where they differ.
free_alpha = IndexedBase("free_alpha", real=True)
pull_x, pull_y = IndexedBase("pull_x", real=True), IndexedBase("pull_y", real=True)
push_x, push_y = IndexedBase("push_x", real=True), IndexedBase("push_y", real=True)
# What link i adds to the diagonal block of the joints at its ends; to that of the joint after it
# alone, where they differ.
blocks = tuple(IndexedBase(f"block_{axes}", real=True) for axes in ("xx", "xy", "yy"))
end_blocks = tuple(IndexedBase(f"end_block_{axes}", real=True) for axes in ("xx", "xy", "yy"))
# Acceleration of a joint, without tensions and with them.
free_ax, free_ay = IndexedBase("free_ax", real=True), IndexedBase("free_ay", real=True)
# Mass of a link of an even rod over that which is gathered in a joint.
lightness = IndexedBase("lightness", positive=True)
joint_ax, joint_ay = IndexedBase("joint_ax", real=True), IndexedBase("joint_ay", real=True)


@dataclass(frozen=True)
class BlockSystem:
    """A symmetric block-tridiagonal system and what follows from its solution.

    unknowns: arrays over ``index`` from low to high; diagonal, coupling: blocks of position index
    with itself and with the next; right: right-hand side; start, end: what the unknowns are one
    before low and one after high, where these are given; arrays: what the expressions refer to;
    angular: acceleration of link i; base: that of joint 0, where it moves.
    """

    unknowns: tuple[IndexedBase, ...]
    index: Symbol
    low: Expr
    high: Expr
    diagonal: Matrix
    coupling: Matrix
    right: Matrix
    start: tuple[Expr, ...]
    end: tuple[Expr, ...]
    arrays: dict[IndexedBase, Array]
    angular: Expr
    base: tuple[Expr, ...]

    def without(self, arrays: set[IndexedBase]) -> BlockSystem:
        """System without the given arrays, which are zero, and those that become zero in turn."""
        if not arrays:
            return self

        def drop(e: Expr) -> Expr:
            return e.xreplace({x: S.Zero for x in e.atoms(Indexed) if x.base in arrays})

        kept = {base: a for base, a in self.arrays.items() if base not in arrays}
        system = replace(
            self,
            arrays={base: replace(a, value=drop(a.value)) for base, a in kept.items()},
            right=self.right.applyfunc(drop),
            angular=drop(self.angular),
            base=tuple(map(drop, self.base)),
        )
        return system.without({base for base, a in system.arrays.items() if a.value == 0})


def constrained_equations(
    energy: Expr, coordinates: list[Expr], gap: list[Expr]
) -> tuple[Matrix, Matrix]:
    """Mass matrix with the Jacobian of the constraints below it, and right-hand side of the
    constraints on the accelerations, by LagrangesMethod."""
    method = LagrangesMethod(energy, coordinates, hol_coneqs=gap)
    method.form_lagranges_equations()
    size = len(coordinates)
    full, right = method.mass_matrix_full, method.forcing_full
    accelerations, multipliers = full[size:, size : 2 * size], full[size:, 2 * size :]
    if multipliers[:size, :] != -accelerations[size:, :].T:
        raise ArithmeticError(f"multipliers {multipliers} do not act along the constraints")
    return accelerations, right[2 * size :, :]


def _sum_forces(forces: Iterable[Vector], unit: Expr) -> Vector:
    x, y = (Add(*parts) / unit for parts in zip((S.Zero, S.Zero), *forces, strict=True))
    return x, y


def weight_on(equations: GeneralEquations, mass: Expr) -> Vector:
    """Forces of the loads on a mass."""
    boundary, loads = equations.boundary_condition, equations.loads.values()
    return _sum_forces((load.weight(mass, boundary) for load in loads), S.One)


def moment_on(equations: GeneralEquations, link: Expr) -> Expr:
    """Moments on a link, of its joints and of the loads."""
    loads, boundary = equations.loads.values(), equations.boundary_condition
    return link_moment[link] + sum((load.link_moment(link, boundary) for load in loads), S.Zero)


def load_on(equations: GeneralEquations, at: Expr, unit: Expr) -> Vector:
    """Forces of the loads on a joint, over a unit, without those that act on the tail alone."""
    boundary = equations.boundary_condition
    return _sum_forces((load.joint_force(at, boundary) for load in equations.loads.values()), unit)


def tail_load(equations: GeneralEquations, unit: Expr) -> Vector:
    """Forces of the loads that act on the tail alone, over a unit."""
    return _sum_forces((load.tail_force() for load in equations.loads.values()), unit)


def system_arrays(equations: GeneralEquations) -> dict[IndexedBase, Array]:
    low = Integer(equations.boundary_condition.first)
    return {
        **equations.arrays,
        link_moment: Array(link_moment, i, low, n - 1, equations.link_moment),
    }


def piecewise_at_first(position: Expr, there: Matrix, inside: Matrix) -> Matrix:
    """Matrix of Piecewise entries that differ at the first position."""
    pairs = zip(there, inside, strict=True)
    return Matrix(*inside.shape, [Piecewise((a, Eq(s, position)), (b, True)) for a, b in pairs])


def add_to_cases(cases: Piecewise, term: Expr) -> Expr:
    """Piecewise with a term added in every case."""
    return Piecewise(*((e + term, c) for e, c in cases.args))


def collect_terms(expression: Expr) -> Expr:
    """Simplify to sums of like terms, with common factors in front."""
    return factor_terms(expand(expression))
