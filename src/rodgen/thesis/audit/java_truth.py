"""What the listing's methods must give beyond what truth has: joints, centre of gravity, energy of
the weight, right side. In the letters of truth, which the listing's members are filled with too.
"""

from __future__ import annotations

from sympy import Expr, S, Symbol

from rodgen.derive.loads import weight
from rodgen.derive.symbols import m

from .truth import LETTERS, Column, omega, phi, product, truth

H = Symbol("h", positive=True)  # time step


def indexed(name: str, count: int) -> Column:
    """name_0, name_1, ..."""
    return [Symbol(f"{name}_{at}", real=True) for at in range(count)]


def state_letters(n: int) -> Column:
    """x0, y0, phi_i and their rates, in the order of rodgen's state."""
    return [*truth(n).positions, *truth(n).rates]


def joints(n: int) -> Column:
    """x_0, y_0, x_1, y_1, ... of the joints."""
    t = truth(n)
    return [t.letters(c) for s in range(n + 1) for c in t.derived.joint(s)]


def joint_velocities(n: int) -> Column:
    """Their rates."""
    t = truth(n)
    return [t.letters(t.derived.rate(c)) for s in range(n + 1) for c in t.derived.joint(s)]


def centre(n: int) -> Column:
    """Centre of gravity: the mean over the links of the mean over each."""
    t = truth(n)
    axes = zip(*t.derived.link_points, strict=True)
    return [sum((t.letters(t.derived.mean(c)) for c in axis), S.Zero) / n for axis in axes]


def gravity_energy(n: int) -> Expr:
    """Minus the work of the weights from the origin."""
    force = (f.xreplace(LETTERS) for f in weight(n * m))
    return -sum((f * c for f, c in zip(force, centre(n), strict=True)), S.Zero)


def right_side(n: int) -> Column:
    """Q omega^2 - K phi - D_i omega + F + A - D_e."""
    t = truth(n)
    squares = product(t.Q, [w**2 for w in omega[:n]])
    springs, dampers = product(t.K, list(phi[:n])), product(t.D_i, list(omega[:n]))
    terms = zip(squares, springs, dampers, t.F, t.A, t.D_e, strict=True)
    return [q - k - d + f + a - e for q, k, d, f, a, e in terms]
