"""Symbols of the model, in the letters of the thesis (SI units)."""

from sympy import Expr, IndexedBase, Rational, Symbol, symbols

# Parameters of a whole rod, by the names that a user gives them.
PARAMETERS: dict[str, Symbol] = {
    name: Symbol(name, real=True)
    for name in (
        "mass",
        "length",
        "bending_stiffness",
        "follower_force",
        "follower_angle",
        "gravity",
        "internal_damping",
        "external_damping",
        "clamp_angle",
        "tip_force_x",
        "tip_force_y",
    )
}
P = PARAMETERS["follower_force"]
NU = PARAMETERS["follower_angle"]
G = PARAMETERS["gravity"]
C_INT = PARAMETERS["internal_damping"]
C_EXT = PARAMETERS["external_damping"]
ALPHA = PARAMETERS["clamp_angle"]
F_TIP = PARAMETERS["tip_force_x"], PARAMETERS["tip_force_y"]

# Of one link: mass [kg], length [m]; stiffness of one rotary spring [N m/rad].
m, l, k = symbols("m l k", positive=True)
# Number of links, as a symbol: derivation 2 keeps it open.
n = Symbol("n", integer=True, positive=True)
# Position along a link, from 0 at its start to 1 at its end.
xi = Symbol("xi", nonnegative=True)

# Indices: links i and j, the later of the two, joint s.
i, j, later, s = symbols("i j later s", integer=True, nonnegative=True)

x0, y0, vx0, vy0 = symbols("x0 y0 vx0 vy0", real=True)
phi = IndexedBase("phi", real=True)
omega = IndexedBase("omega", real=True)
fin_factor = IndexedBase("fin_factor", nonnegative=True)


def discretisation() -> dict[Symbol, Expr]:
    """Mass, length and spring stiffness of one link from those of the rod (thesis 2.1)."""
    length = PARAMETERS["length"] / n
    return {m: PARAMETERS["mass"] / n, l: length, k: PARAMETERS["bending_stiffness"] / length}


HALF = Rational(1, 2)
