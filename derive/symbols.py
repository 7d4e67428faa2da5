"""Symbols of the model, in the letters of the thesis (SI units)."""

from dataclasses import dataclass
from typing import Any

from sympy import Expr, IndexedBase, Rational, Symbol, symbols

from rodgen.model import terms
from rodgen.model.term import POSITIVE, Parameter


def _symbol(row: Parameter) -> Symbol | IndexedBase:
    """The symbol of a parameter; an array where it differs by joint or link."""
    if not row.is_array:
        return Symbol(row.name, real=True)
    rule = "real" if row.is_signed else "positive" if row.rule == POSITIVE else "nonnegative"
    return IndexedBase(row.name, **{rule: True})


class _Symbols(dict[str, Any]):
    """Symbols by name; those of numbered loads, such as follower_2, are made on access."""

    def __missing__(self, name: str) -> Symbol | IndexedBase:
        return _symbol(terms.PARAMETERS[name])


# Parameters of a whole rod, by the names that a user gives them.
PARAMETERS = _Symbols({name: _symbol(row) for name, row in terms.PARAMETERS.items()})
ALPHA = PARAMETERS["clamp_angle"]

# Of one link: mass [kg], length [m]; stiffness of one rotary spring [N m/rad].
m, l, k = symbols("m l k", positive=True)
# Angle by which a spring is bent [rad].
bend = Symbol("d", real=True)
# Number of links, as a symbol: derivation 2 keeps it open.
n = Symbol("n", integer=True, positive=True)
# Position along a link, from 0 at its start to 1 at its end.
xi = Symbol("xi", nonnegative=True)
# Position across it, over its length.
eta = Symbol("eta", real=True)

# Indices: links i and j, the later of the two, joint s.
i, j, later, s = symbols("i j later s", integer=True, nonnegative=True)
# A link that carries mass.
other = Symbol("other", integer=True, nonnegative=True)

x0, y0, vx0, vy0 = symbols("x0 y0 vx0 vy0", real=True)
phi = IndexedBase("phi", real=True)
omega = IndexedBase("omega", real=True)
# Angular acceleration of link i.
alpha = IndexedBase("alpha", real=True)

# Index of a joint; sums run over i (links), joint, s (springs).
joint = Symbol("joint", integer=True, nonnegative=True)

# Quantities along the chain: positions and velocities of the joints, also from joint 0 and from the
# centre of gravity; the moment across a joint.
joint_x, joint_y = IndexedBase("joint_x", real=True), IndexedBase("joint_y", real=True)
joint_vx, joint_vy = IndexedBase("joint_vx", real=True), IndexedBase("joint_vy", real=True)
# Acceleration of a joint, from those of the links before it.
moved_ax, moved_ay = IndexedBase("moved_ax", real=True), IndexedBase("moved_ay", real=True)
reach_x, reach_y = IndexedBase("reach_x", real=True), IndexedBase("reach_y", real=True)
arm_x, arm_y = IndexedBase("arm_x", real=True), IndexedBase("arm_y", real=True)
centre_x, centre_y = symbols("centre_x centre_y", real=True)
joint_moment = IndexedBase("joint_moment", real=True)


def parameters(term: str) -> tuple[Any, ...]:
    """The parameters of a load."""
    return tuple(PARAMETERS[row.name] for row in terms.TERMS[term].parameters)


@dataclass(frozen=True)
class Array:
    """A quantity with a value for every low <= index <= high."""

    base: IndexedBase
    index: Symbol
    low: Expr
    high: Expr
    value: Expr


def discretisation() -> dict[Symbol, Expr]:
    """Mass, length and spring stiffness of one link from those of the rod (thesis 2.1)."""
    length = PARAMETERS["length"] / n
    return {m: PARAMETERS["mass"] / n, l: length, k: PARAMETERS["bending_stiffness"] / length}


HALF = Rational(1, 2)
