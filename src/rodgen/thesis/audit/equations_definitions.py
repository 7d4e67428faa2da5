"""Equations 2.1 to 2.9, 2.11, 2.12 and 2.14 as printed: definitions, velocities, elements."""

from __future__ import annotations

from sympy import Expr, Rational, cos, sin, sqrt

from rodgen.derive import symbols
from rodgen.derive.symbols import k, l, m, vx0, vy0

from .claim import Claim
from .truth import EI, LETTERS, L, M, omega, phi, product, r, total, truth

READ = "as printed"
HALF = Rational(1, 2)
rho = m / l  # called density of the element: mass per length


def derived_sizes(n: int) -> list[Expr]:
    """m, l, k of one of n links (2.1)."""
    values = {size: value.xreplace(LETTERS) for size, value in symbols.discretisation().items()}
    return [values[size].subs(symbols.n, n) for size in (m, l, k)]


def velocity(link: int) -> tuple[Expr, Expr]:
    """2.5, 2.11, 2.14: whole links before the point at r of a link."""
    x = vx0 - total(lambda i: omega[i] * l * sin(phi[i]), 0, link - 1)
    y = vy0 + total(lambda i: omega[i] * l * cos(phi[i]), 0, link - 1)
    return x - omega[link] * r * sin(phi[link]), y + omega[link] * r * cos(phi[link])


def element(link: int) -> Expr:
    """2.4, 2.9, 2.12: (1/2) rho v^2, for dr = 1."""
    x, y = velocity(link)
    return HALF * rho * (x**2 + y**2)


def derived_rates(n: int) -> list[Expr]:
    """Time derivatives of the coordinates of the derivation."""
    derived = truth(n).derived
    generators = [derived.calculus.generator[q] for q in derived.coordinates]
    return [truth(n).letters(derived.rate(q)) for q in generators]


def printed_euler_lagrange(n: int) -> list[Expr]:
    """2.3 with L of 2.2: d/dt dL/du - dL/dq, E_p not depending on the rates."""
    t = truth(n)
    parts = zip(t.momentum_rates, t.kinetic_slopes, t.spring_slopes, strict=True)
    return [rate - (kinetic - spring) for rate, kinetic, spring in parts]


def matrix_rows(n: int) -> list[Expr]:
    """M v' - Q omega^2 + K phi, from LagrangesMethod."""
    t = truth(n)
    squares = [w**2 for w in omega[:n]]
    parts = zip(
        product(t.M, t.accelerations),
        product(t.Q, squares),
        product(t.K, list(phi[:n])),
        strict=True,
    )
    return [inertia - quadratic + spring for inertia, quadratic, spring in parts]


def velocity_claim(number: str, link: int, text: str) -> Claim:
    return Claim(
        number,
        f"velocity of a point of link {link}",
        {READ: lambda n: velocity(link)},
        lambda n: truth(n).velocity(link),
        links=range(link + 1, 7),
        printed=text,
        label=lambda n, at: f"v_{'xy'[at]}{link + 1}",
    )


def element_claim(number: str, link: int, text: str) -> Claim:
    return Claim(
        number,
        f"kinetic energy of an element of link {link}",
        {READ: lambda n: [element(link)]},
        lambda n: [truth(n).energy_density(link)],
        links=range(link + 1, 7),
        printed=text,
        note="Density means mass per length, m/l.",
        label=lambda n, at: f"dE_k{link}/dr",
    )


CLAIMS: tuple[Claim, ...] = (
    Claim(
        "2.1",
        "mass, length and spring stiffness of a link",
        {READ: lambda n: [M / n, L / n, EI / (L / n)]},
        derived_sizes,
        printed=r"m = \frac{M}{n}, \quad l = \frac{L}{n}, \quad k = \frac{EI}{l}",
        label=lambda n, at: "mlk"[at],
    ),
    Claim(
        "2.2",
        "Lagrangian",
        {READ: lambda n: [truth(n).kinetic_energy - truth(n).spring_energy]},
        lambda n: [truth(n).lagrangian],
        printed="L = E_k - E_p",
        label=lambda n, at: "L",
    ),
    Claim(
        "2.3",
        "Euler-Lagrange equations",
        {READ: printed_euler_lagrange},
        matrix_rows,
        printed=r"\frac{d}{dt} \left(\frac{\partial L}{\partial \dot{q}_i} \right) "
        r"= \frac{\partial L}{\partial q_i}",
        note="Compared with the rows that LagrangesMethod gives.",
    ),
    element_claim("2.4", 0, r"dE_{k0} = \frac{1}{2} dm v_1^2 = \frac{1}{2} \rho dr v_1^2"),
    velocity_claim(
        "2.5",
        0,
        r"v_{x1} = v_{x0} - \omega_0 r \sin(\varphi_0), \quad "
        r"v_{y1} = v_{y0} + \omega_0 r \cos(\varphi_0)",
    ),
    Claim(
        "2.6",
        "velocity of joint 0",
        {READ: lambda n: [vx0, vy0]},
        lambda n: derived_rates(n)[:2],
        printed=r"v_{x0} = \frac{d}{dt} x_0, \quad v_{y0} = \frac{d}{dt} y_0",
    ),
    Claim(
        "2.7",
        "angular velocities",
        {READ: lambda n: omega[:n]},
        lambda n: derived_rates(n)[2:],
        printed=r"\omega_i = \frac{d}{dt} \varphi_i, \quad i = 0, 1 \dots n - 1",
    ),
    Claim(
        "2.8",
        "speed from its components",
        {READ: lambda n: [sqrt(sum(c**2 for c in velocity(0))) ** 2]},
        lambda n: [truth(n).energy_density(0) / (m / (2 * l))],
        printed=r"v_1 = \sqrt{v_{x1}^2 + v_{y1}^2}",
        note="Compared squared: no speed is negative.",
        label=lambda n, at: "v_1^2",
    ),
    element_claim(
        "2.9",
        0,
        r"dE_{k0} = \frac{1}{2} \rho dr v_1^2 = \frac{1}{2} \rho dr "
        r"[(v_{x0} - \omega_0 r \sin(\varphi_0))^2 + (v_{y0} + \omega_0 r \cos(\varphi_0))^2]",
    ),
    velocity_claim(
        "2.11",
        1,
        r"v_{x2} = v_{x0} - \omega_0 l \sin(\varphi_0) - \omega_1 r \sin(\varphi_1), \quad "
        r"v_{y2} = v_{y0} + \omega_0 l \cos(\varphi_0) + \omega_1 r \cos(\varphi_1)",
    ),
    element_claim(
        "2.12",
        1,
        r"dE_{k1} = \frac{1}{2} \rho dr v_2^2 = \frac{1}{2} \rho dr \left["
        r"(v_{x0} - \omega_0 l \sin(\varphi_0) - \omega_1 r \sin(\varphi_1))^2 + "
        r"(v_{y0} + \omega_0 l \cos(\varphi_0) + \omega_1 r \cos(\varphi_1))^2 \right]",
    ),
    velocity_claim(
        "2.14",
        2,
        r"v_{x3} = v_{x0} - \omega_0 l \sin(\varphi_0) - \omega_1 l \sin(\varphi_1) "
        r"- \omega_2 r \sin(\varphi_2), \quad v_{y3} = v_{y0} + \omega_0 l \cos(\varphi_0) "
        r"+ \omega_1 l \cos(\varphi_1) + \omega_2 r \cos(\varphi_2)",
    ),
)
