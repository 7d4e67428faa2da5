"""Equations 2.1 to 2.20 as printed: definitions, velocities, energies."""

from __future__ import annotations

from sympy import Expr, Rational, sqrt

from rodgen.derive import symbols
from rodgen.derive.chain import spring_potential
from rodgen.derive.symbols import k, l, m, vx0, vy0
from rodgen_evidence.thesis.audit.claim import READ, Claim
from rodgen_evidence.thesis.audit.latex import equation, read
from rodgen_evidence.thesis.audit.truth import (
    EI,
    LETTERS,
    L,
    M,
    omega,
    phi,
    product,
    truth,
)

HALF = Rational(1, 2)
VELOCITIES = (
    r"v_{x1} = v_{x0} - \omega_0 r \sin(\varphi_0), \quad "
    r"v_{y1} = v_{y0} + \omega_0 r \cos(\varphi_0)",
    r"v_{x2} = v_{x0} - \omega_0 l \sin(\varphi_0) - \omega_1 r \sin(\varphi_1), \quad "
    r"v_{y2} = v_{y0} + \omega_0 l \cos(\varphi_0) + \omega_1 r \cos(\varphi_1)",
    r"v_{x3} = v_{x0} - \omega_0 l \sin(\varphi_0) - \omega_1 l \sin(\varphi_1) "
    r"- \omega_2 r \sin(\varphi_2), \quad v_{y3} = v_{y0} + \omega_0 l \cos(\varphi_0) "
    r"+ \omega_1 l \cos(\varphi_1) + \omega_2 r \cos(\varphi_2)",
)
# v_1, v_2, v_3 of points of the links 0, 1, 2, as in 2.8.
SPEEDS = {
    f"v_{link + 1}": sqrt(sum(c**2 for c in read(VELOCITIES[link])(link + 1))) for link in range(3)
}


def derived_sizes(n: int) -> list[Expr]:
    """m, l, k of one of n links (2.1)."""
    values = {size: value.xreplace(LETTERS) for size, value in symbols.discretisation().items()}
    return [values[size].subs(symbols.n, n) for size in (m, l, k)]


def derived_rates(n: int) -> list[Expr]:
    """Time derivatives of the coordinates of the derivation."""
    derived = truth(n).derived
    generators = [derived.calculus.generator[q] for q in derived.coordinates]
    return [truth(n).letters(derived.time_derivative(q)) for q in generators]


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


def velocity_claim(number: str, link: int) -> Claim:
    title, links = f"velocity of a point of link {link}", range(link + 1, 7)
    return equation(number, title, VELOCITIES[link], lambda n: truth(n).velocity(link), links=links)


def element_claim(number: str, link: int, text: str) -> Claim:
    return equation(
        number,
        f"kinetic energy of an element of link {link}",
        text,
        lambda n: [truth(n).energy_density(link)],
        letters=SPEEDS,
        last=True,
        links=range(link + 1, 7),
        note="Density means mass per length, m/l.",
    )


# The double sum of 2.16 and 2.17, and what it must be: every pair of links once.
PAIRS = (
    r"\left[\sum_{i=1}^{k-1} \omega_k \omega_i \cos(\varphi_i - \varphi_k) "
    r"+ \sum_{i=k+1}^{s-1} \omega_k \omega_i \cos(\varphi_i - \varphi_k) \right] "
)
PAIRS_ONCE = r"\sum_{i=k+1}^{s-1} \omega_k \omega_i \cos(\varphi_i - \varphi_k) "
ENERGY = (
    r"E_{k,s} = \frac{1}{2}m \left\{ v_{x0}^2 + v_{y0}^2 "
    r"+ l^2 \sum_{i=0}^{s-1} \omega_i^2 + \frac{1}{3}\omega_s^2 l^2 "
    r"- 2v_{x0} l \sum_{i=0}^{s-1} \omega_i \sin(\varphi_i) "
    r"+ 2v_{y0} l \sum_{i=0}^{s-1} \omega_i \cos(\varphi_i) "
    r"+ \omega_s l [-v_{x0} \sin(\varphi_s) + v_{y0} \cos(\varphi_s)] "
    r"+ 2l^2 \sum_{k=0}^{s-2} " + PAIRS + r"+ l^2 \sum_{k=0}^{s-1} \omega_k \omega_s "
    r"\cos(\varphi_s - \varphi_k) \right\}"
)
OF_LINKS = (
    r"\left(\sum_{i=1}^{k-1} \omega_k \omega_i \cos(\varphi_i - \varphi_k) "
    r"+ \sum_{i=k+1}^{j-1} \omega_k \omega_i \cos(\varphi_i - \varphi_k) \right) "
)
OF_TAIL = r"+ l^2 \sum_{k=0}^{n-2} \omega_k \omega_{n-1} \cos(\varphi_{n-1} - \varphi_k) "
TOTAL = (
    r"E_k = \frac{1}{2}m \left\{ n (v_{x0}^2 + v_{y0}^2) "
    r"+ l^2 \sum_{i=0}^{n-1} \left[\omega_i^2 \left(\frac{1}{3} + (n-i-1) \right) \right] "
    r"- l v_{x0} \sum_{i=0}^{n-1} [\omega_i \sin(\varphi_i) (1 + 2(n-i-1))] "
    r"+ l v_{y0} \sum_{i=0}^{n-1} [\omega_i \cos(\varphi_i) (1 + 2(n-i-1))] "
    r"+ \sum_{j=0}^{n-1} \left[2l^2 \sum_{k=0}^{j-2} " + OF_LINKS + OF_TAIL + r"\right] \right\}"
)
OUTSIDE = TOTAL.replace(OF_TAIL + r"\right] ", r"\right] " + OF_TAIL)
LINKS_RIGHT = (
    r"\sum_{j=0}^{n-1} \left[2l^2 \sum_{k=0}^{j-2} \sum_{i=k+1}^{j-1} "
    r"\omega_k \omega_i \cos(\varphi_i - \varphi_k) "
    r"+ l^2 \sum_{k=0}^{j-1} \omega_k \omega_j \cos(\varphi_j - \varphi_k) \right]"
)
TOTAL_RIGHT = TOTAL[: TOTAL.index(r"\sum_{j=0}")] + LINKS_RIGHT + r" \right\}"


def spring_energies(n: int) -> list[Expr]:
    """2.19, both forms, for every spring."""
    turns = [phi[s + 1] - phi[s] for s in range(n - 1)]
    return [e for turn in turns for e in (HALF * (k * turn) * turn, HALF * k * turn**2)]


def derived_springs(n: int) -> list[Expr]:
    return [spring_potential(phi[s + 1] - phi[s]) for s in range(n - 1)]


def one_link_claim(number: str, link: int, text: str) -> Claim:
    return equation(
        number,
        f"kinetic energy of link {link}",
        text,
        lambda n: 2 * [truth(n).link_energy(link)],
        letters=SPEEDS,
        links=range(link + 1, 7),
        note="Both sides are compared: the integral and its printed result.",
    )


CLAIMS: tuple[Claim, ...] = (
    Claim(
        "2.1",
        "mass, length and spring stiffness of a link",
        {READ: lambda n: [M / n, L / n, EI / (L / n)]},
        derived_sizes,
        printed=r"m = \frac{M}{n}, \quad l = \frac{L}{n}, \quad k = \frac{EI}{l}",
    ),
    Claim(
        "2.2",
        "Lagrangian",
        {READ: lambda n: [truth(n).kinetic_energy - truth(n).spring_energy]},
        lambda n: [truth(n).lagrangian],
        printed="L = E_k - E_p",
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
    velocity_claim("2.5", 0),
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
        {READ: lambda n: [SPEEDS["v_1"] ** 2]},
        lambda n: [truth(n).energy_density(0) / (m / (2 * l))],
        printed=r"v_1 = \sqrt{v_{x1}^2 + v_{y1}^2}",
        note="Compared as squares, because a speed is never negative.",
    ),
    element_claim(
        "2.9",
        0,
        r"dE_{k0} = \frac{1}{2} \rho dr v_1^2 = \frac{1}{2} \rho dr "
        r"[(v_{x0} - \omega_0 r \sin(\varphi_0))^2 + (v_{y0} + \omega_0 r \cos(\varphi_0))^2]",
    ),
    velocity_claim("2.11", 1),
    element_claim(
        "2.12",
        1,
        r"dE_{k1} = \frac{1}{2} \rho dr v_2^2 = \frac{1}{2} \rho dr \left["
        r"(v_{x0} - \omega_0 l \sin(\varphi_0) - \omega_1 r \sin(\varphi_1))^2 + "
        r"(v_{y0} + \omega_0 l \cos(\varphi_0) + \omega_1 r \cos(\varphi_1))^2 \right]",
    ),
    velocity_claim("2.14", 2),
    one_link_claim(
        "2.10",
        0,
        r"E_{k0} = \frac{1}{2} \rho \int_0^l [(v_{x0} - \omega_0 r \sin(\varphi_0))^2 "
        r"+ (v_{y0} + \omega_0 r \cos(\varphi_0))^2] dr = \frac{1}{2} m \left[ v_{x0}^2 + v_{y0}^2 "
        r"+ \frac{1}{3} \omega_0^2 l^2 - v_{x0} \omega_0 l \sin(\varphi_0) "
        r"+ v_{y0} \omega_0 l \cos(\varphi_0) \right]",
    ),
    one_link_claim(
        "2.13",
        1,
        r"E_{k1} = \frac{1}{2} \rho \int_0^l v_2^2 dr = \frac{1}{2} m \left[ v_{x0}^2 + v_{y0}^2 "
        r"+ \omega_0^2 l^2 + \frac{1}{3} \omega_1^2 l^2 - 2 v_{x0} \omega_0 l \sin(\varphi_0) "
        r"+ 2 v_{y0} \omega_0 l \cos(\varphi_0) - v_{x0} \omega_1 l \sin(\varphi_1) "
        r"+ v_{y0} \omega_1 l \cos(\varphi_1) + \omega_0 \omega_1 l^2 \cos(\varphi_1 - \varphi_0) "
        r"\right]",
    ),
    one_link_claim(
        "2.15",
        2,
        r"E_{k2} = \frac{1}{2} \rho \int_0^l v_3^2 dr = \frac{1}{2} m \left[ v_{x0}^2 + v_{y0}^2 "
        r"+ \omega_0^2 l^2 + \omega_1^2 l^2 + \frac{1}{3} \omega_2^2 l^2 "
        r"- 2 v_{x0} \omega_0 l \sin(\varphi_0) + 2 v_{y0} \omega_0 l \cos(\varphi_0) "
        r"- 2 v_{x0} \omega_1 l \sin(\varphi_1) + 2 v_{y0} \omega_1 l \cos(\varphi_1) "
        r"- v_{x0} \omega_2 l \sin(\varphi_2) + v_{y0} \omega_2 l \cos(\varphi_2) "
        r"+ 2 \omega_0 \omega_1 l^2 \cos(\varphi_1 - \varphi_0) "
        r"+ \omega_0 \omega_2 l^2 \cos(\varphi_2 - \varphi_0) "
        r"+ \omega_1 \omega_2 l^2 \cos(\varphi_2 - \varphi_1) \right]",
    ),
    equation(
        "2.16",
        "kinetic energy of link s",
        ENERGY,
        lambda n: [truth(n).link_energy(s) for s in range(n)],
        over=range,
        corrected=read(ENERGY.replace(PAIRS, PAIRS_ONCE), over=range),
        note=(
            "From the fifth link on, the sum over i from 1 to k-1 counts pairs of links a second"
            " time. It was generalised from 2.10, 2.13 and 2.15, which have no such pair. Its "
            "index k is also the symbol of the spring stiffness."
        ),
        correction=r"2l^2 \sum_{k=0}^{s-2} " + PAIRS_ONCE + r"\text{ in place of the double sum}",
        label=lambda n, at: f"E_k,{at}",
    ),
    Claim(
        "2.17",
        "kinetic energy of the model",
        {"brackets as printed": read(TOTAL), "last sum outside the sum over j": read(OUTSIDE)},
        lambda n: [truth(n).kinetic_energy],
        corrected=read(TOTAL_RIGHT),
        note=(
            "The last sum stands inside the sum over j, so it counts n times. It has n-1 where "
            "the sum of 2.16 over the links has j. Pairs are counted twice as in 2.16."
        ),
        printed=TOTAL,
        correction=LINKS_RIGHT,
        label=lambda n, at: "E_k",
    ),
    equation(
        "2.18",
        "moment of a spring",
        r"M_{s,s+1} = k \Delta\varphi = k (\varphi_{s+1} - \varphi_s)",
        lambda n: [e.diff(phi[s + 1]) for s, e in enumerate(derived_springs(n))],
        over=lambda n: range(n - 1),
        last=True,
        links=range(2, 7),
        note=(
            "This is the moment that bends the spring. The spring acts on link s+1 with the "
            "opposite moment. The damping moment of 2.50 has the opposite sign convention."
        ),
    ),
    Claim(
        "2.19",
        "energy of a spring",
        {READ: spring_energies},
        lambda n: [e for e in derived_springs(n) for _ in range(2)],
        links=range(2, 7),
        printed=r"E_{p,s} = \frac{1}{2} M_{s,s+1} \Delta\varphi "
        r"= \frac{1}{2} k (\varphi_{s+1} - \varphi_s)^2",
    ),
    equation(
        "2.20",
        "energy of all springs",
        r"E_p = \sum E_{p,i} = \frac{1}{2} k \sum_{s=0}^{n-2} (\varphi_{s+1} - \varphi_s)^2",
        lambda n: [truth(n).spring_energy],
        last=True,
    ),
)
