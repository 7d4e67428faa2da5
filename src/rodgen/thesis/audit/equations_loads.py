"""Equations 2.46 to 2.50, 2.52 and 2.62 to 2.64 as printed: follower force, damping, gravity."""

from __future__ import annotations

from sympy import Expr, S, Symbol, cos, sin

from rodgen.derive.loads import damper_moment, follower_force, weight
from rodgen.derive.symbols import l, m

from .claim import Claim, Entries
from .equations_definitions import HALF, READ
from .equations_matrices import ROWS, TWO_LINKS, entry_of, row_name, tridiagonal
from .truth import LETTERS, Column, P, c_int, flat, g, nu, omega, phi, truth

omega_r = Symbol("omega_r", real=True)  # rate at which a joint opens
a_g = Symbol("a_g", real=True)  # acceleration that acts on a link


def follower(n: int) -> Column:
    """2.46."""
    tail = phi[n - 1] + nu
    return [P * cos(tail), P * sin(tail)]


def derived_follower(n: int) -> Column:
    return [e.xreplace(LETTERS) for e in follower_force(phi[n - 1])]


def against_thrust(n: int) -> Column:
    """The force at the tail, counted against the thrust: what 2.46 calls F_follower."""
    return [-e for e in derived_follower(n)]


def follower_vector(base: int, sign: int) -> Entries:
    """2.47; base: F_x, F_y in units of F_follower; sign: of F_follower against 2.46."""

    def rows(n: int) -> Column:
        x, y = (sign * component for component in follower(n))
        turns = [x * l * sin(phi[i]) - y * l * cos(phi[i]) for i in range(n)]
        return [base * x, base * y, *turns]

    return rows


def damper(before: Expr, after: Expr) -> Expr:
    return damper_moment(before, after).xreplace(LETTERS)


def derived_dampers(n: int) -> Column:
    return [damper(omega[s], omega[s + 1]) for s in range(n - 1)]


def gravity_vector(a_g: Expr, base: int = 1) -> Entries:
    """2.64; base: sign of M a_g in the first vector."""

    def rows(n: int) -> Column:
        arms = [(n - HALF - i) * cos(phi[i]) for i in range(n - 1)]
        arms.append(HALF * cos(phi[n - 1]))
        return [S.Zero, base * n * m * a_g, *(-a_g * m * l * arm for arm in arms)]

    return rows


def derived_weight(n: int) -> Expr:
    """Weight of a link, upwards."""
    return weight(m)[1].xreplace(LETTERS)


CLAIMS: tuple[Claim, ...] = (
    Claim(
        "2.46",
        "components of the follower force, counted against the thrust",
        {READ: follower},
        against_thrust,
        repairs=("The angle nu was read as v.",),
        printed=r"F_{follower,x} = F_{follower} \cos(\varphi_{n-1} + \nu), \quad "
        r"F_{follower,y} = F_{follower} \sin(\varphi_{n-1} + \nu)",
        note="Compared with the opposite of the thrust, which acts from the tail towards the nose: "
        "the direction in which a component counts is a convention, and the moments of 2.47 are "
        "right with this one. That the force of 2.47 need not be is told there, and once.",
        label=lambda n, at: f"F_follower,{'xy'[at]}",
    ),
    Claim(
        "2.47",
        "vector of the follower force",
        {
            "F_x = F_follower,x of 2.46": follower_vector(1, 1),
            "F_x = F_follower,x, that of 2.46 with the other sign": follower_vector(1, -1),
            "F_x = -F_follower,x, as in the listing, lines 434 and 444": follower_vector(-1, 1),
        },
        lambda n: truth(n).F,
        corrected=follower_vector(-1, 1),
        printed=r"\mathbf{F} = \begin{bmatrix} F_x \\ F_y \\ 0 \\ \vdots \\ 0 \end{bmatrix} "
        r"+ F_{follower,x} l \begin{bmatrix} 0 \\ 0 \\ \sin(\varphi_0) \\ \vdots \\ "
        r"\sin(\varphi_{n-1}) \end{bmatrix} - F_{follower,y} l \begin{bmatrix} 0 \\ 0 \\ "
        r"\cos(\varphi_0) \\ \vdots \\ \cos(\varphi_{n-1}) \end{bmatrix}",
        correction=r"F_x = -F_{follower,x}, \quad F_y = -F_{follower,y}",
        note="F_x and F_y are not defined. As the components of 2.46 they pull at the tail, while "
        "the moments are those of a push; with the other sign in 2.46 it is the other way round. "
        "With the minus of the listing 2.46 stands as it is printed.",
        label=row_name,
    ),
    Claim(
        "2.48",
        "moment of linear damping",
        {READ: lambda n: [-c_int * m * omega_r]},
        lambda n: [damper(S.Zero, omega_r)],
        printed=r"M = -c m \omega",
        note="c is c_int and omega the rate at which a joint opens.",
        label=lambda n, at: "M",
    ),
    Claim(
        "2.49",
        "moment of internal damping",
        {READ: lambda n: [-c_int * m * (omega[s + 1] - omega[s]) for s in range(n - 1)]},
        derived_dampers,
        links=TWO_LINKS,
        printed=r"M = -c_{int} m \frac{d}{dt} \Delta\varphi = -c_{int} m \omega_r",
        note="With the difference of angles of 2.18.",
    ),
    Claim(
        "2.50",
        "moment of internal damping across joint s+1",
        {READ: lambda n: [-c_int * m * (omega[s + 1] - omega[s]) for s in range(n - 1)]},
        derived_dampers,
        links=TWO_LINKS,
        printed=r"M = -c_{int} m (\omega_{s+1} - \omega_s)",
        note="The moment on link s+1; link s gets the opposite.",
    ),
    Claim(
        "2.52",
        "matrix of internal damping",
        {READ: lambda n: flat(tridiagonal(n, c_int * m))},
        lambda n: flat(truth(n).D_i),
        links=TWO_LINKS,
        printed=r"\mathbf{D}_i = c_{int} m " + ROWS,
        note="A single link has no damper.",
        label=entry_of(lambda n: n),
    ),
    Claim(
        "2.62",
        "weight of a link",
        {READ: lambda n: [m * g]},
        lambda n: [-derived_weight(n)],
        printed=r"F_g = m g",
        note="Its magnitude, which acts downwards.",
        label=lambda n, at: "F_g",
    ),
    Claim(
        "2.63",
        "force of the acceleration a_g on a link",
        {READ: lambda n: [m * a_g]},
        lambda n: [derived_weight(n).xreplace({g: -a_g})],
        printed=r"F_a = m a_g",
        note="A definition: force and acceleration both upwards, or both downwards. Which of them "
        "is not said; 2.64 has both, and the conflict is counted there.",
        label=lambda n, at: "F_a",
    ),
    Claim(
        "2.64",
        "vector of gravity",
        {"a_g = g": gravity_vector(g), "a_g = -g": gravity_vector(-g)},
        lambda n: truth(n).A,
        corrected=gravity_vector(g, base=-1),
        printed=r"\mathbf{A} = \begin{bmatrix} 0 \\ M a_g \\ 0 \\ \vdots \\ 0 \end{bmatrix} "
        r"- a_g m l \begin{bmatrix} 0 \\ 0 \\ (n - \frac{1}{2}) \cos(\varphi_0) \\ "
        r"(n - \frac{1}{2} - 1) \cos(\varphi_1) \\ \vdots \\ "
        r"(n - \frac{1}{2} - i) \cos(\varphi_i) \\ \frac{1}{2} \cos(\varphi_{n-1}) "
        r"\end{bmatrix}",
        correction=r"-M a_g \text{ in place of } M a_g, \quad a_g = g",
        note="No sign of a_g makes both vectors right: the force is that of a_g upwards, its "
        "moments those of a_g downwards. The listing (lines 468, 482) has both downwards.",
        label=row_name,
    ),
)
