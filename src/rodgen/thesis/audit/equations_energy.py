"""Equations 2.10, 2.13 and 2.15 to 2.20 as printed: kinetic and potential energy."""

from __future__ import annotations

from collections.abc import Callable

from sympy import Expr, Rational, cos, integrate, sin

from rodgen.derive.loads import spring_potential
from rodgen.derive.symbols import k, l, m, vx0, vy0

from .claim import Claim
from .equations_definitions import HALF, READ, element
from .truth import omega, phi, r, total, truth

THIRD = Rational(1, 3)


def integral(link: int) -> Expr:
    """Left of 2.10, 2.13, 2.15: the integral over the length of a link."""
    return integrate(element(link).expand(), (r, 0, l))


def first_link(n: int) -> list[Expr]:
    """2.10, both lines."""
    inner = vx0**2 + vy0**2 + THIRD * omega[0] ** 2 * l**2
    inner += -vx0 * omega[0] * l * sin(phi[0]) + vy0 * omega[0] * l * cos(phi[0])
    return [integral(0), HALF * m * inner]


def second_link(n: int) -> list[Expr]:
    """2.13, both sides."""
    w0, w1 = omega[:2]
    inner = vx0**2 + vy0**2 + w0**2 * l**2 + THIRD * w1**2 * l**2
    inner += -2 * vx0 * w0 * l * sin(phi[0]) + 2 * vy0 * w0 * l * cos(phi[0])
    inner += -vx0 * w1 * l * sin(phi[1]) + vy0 * w1 * l * cos(phi[1])
    inner += w0 * w1 * l**2 * cos(phi[1] - phi[0])
    return [integral(1), HALF * m * inner]


def third_link(n: int) -> list[Expr]:
    """2.15, both sides."""
    w0, w1, w2 = omega[:3]
    inner = vx0**2 + vy0**2 + w0**2 * l**2 + w1**2 * l**2 + THIRD * w2**2 * l**2
    inner += -2 * vx0 * w0 * l * sin(phi[0]) + 2 * vy0 * w0 * l * cos(phi[0])
    inner += -2 * vx0 * w1 * l * sin(phi[1]) + 2 * vy0 * w1 * l * cos(phi[1])
    inner += -vx0 * w2 * l * sin(phi[2]) + vy0 * w2 * l * cos(phi[2])
    inner += 2 * w0 * w1 * l**2 * cos(phi[1] - phi[0])
    inner += w0 * w2 * l**2 * cos(phi[2] - phi[0]) + w1 * w2 * l**2 * cos(phi[2] - phi[1])
    return [integral(2), HALF * m * inner]


def pair(a: int, b: int) -> Expr:
    """omega_a omega_b cos(phi_b - phi_a)."""
    return omega[a] * omega[b] * cos(phi[b] - phi[a])


def printed_pairs(s: int) -> Expr:
    """Double sum of 2.16 and 2.17: k from 0 to s-2, i from 1 to k-1 and from k+1 to s-1."""
    return total(
        lambda q: total(lambda i: pair(q, i), 1, q - 1) + total(lambda i: pair(q, i), q + 1, s - 1),
        0,
        s - 2,
    )


def every_pair_once(s: int) -> Expr:
    """The double sum put right: k from 0 to s-2, i from k+1 to s-1 only."""
    return total(lambda q: total(lambda i: pair(q, i), q + 1, s - 1), 0, s - 2)


def link_energy(s: int, pairs: Callable[[int], Expr]) -> Expr:
    """2.16 with the given double sum."""
    inner = vx0**2 + vy0**2 + l**2 * total(lambda i: omega[i] ** 2, 0, s - 1)
    inner += THIRD * omega[s] ** 2 * l**2
    inner += -2 * vx0 * l * total(lambda i: omega[i] * sin(phi[i]), 0, s - 1)
    inner += 2 * vy0 * l * total(lambda i: omega[i] * cos(phi[i]), 0, s - 1)
    inner += omega[s] * l * (-vx0 * sin(phi[s]) + vy0 * cos(phi[s]))
    inner += 2 * l**2 * pairs(s) + l**2 * total(lambda q: pair(q, s), 0, s - 1)
    return HALF * m * inner


def weight(n: int, i: int) -> int:
    return 1 + 2 * (n - i - 1)


def total_energy(n: int, pairs: Expr) -> list[Expr]:
    """2.17 with the given terms in products of angular velocities."""
    inner = n * (vx0**2 + vy0**2) + pairs
    inner += l**2 * total(lambda i: omega[i] ** 2 * (THIRD + (n - i - 1)), 0, n - 1)
    inner -= l * vx0 * total(lambda i: omega[i] * sin(phi[i]) * weight(n, i), 0, n - 1)
    inner += l * vy0 * total(lambda i: omega[i] * cos(phi[i]) * weight(n, i), 0, n - 1)
    return [HALF * m * inner]


def last_pairs(n: int) -> Expr:
    """Last sum of 2.17: k from 0 to n-2, with omega_{n-1}."""
    return l**2 * total(lambda q: pair(q, n - 1), 0, n - 2)


def inside(n: int) -> list[Expr]:
    """2.17 with its brackets as printed: the last sum inside the sum over j."""
    sums = total(lambda j: 2 * l**2 * printed_pairs(j) + last_pairs(n), 0, n - 1)
    return total_energy(n, sums)


def outside(n: int) -> list[Expr]:
    """2.17 with the last sum behind the sum over j."""
    sums = total(lambda j: 2 * l**2 * printed_pairs(j), 0, n - 1) + last_pairs(n)
    return total_energy(n, sums)


def put_right(n: int) -> list[Expr]:
    """2.17 as the sum of 2.16 put right: the last sum with omega_j, k from 0 to j-1."""

    def of_link(j: int) -> Expr:
        return 2 * l**2 * every_pair_once(j) + l**2 * total(lambda q: pair(q, j), 0, j - 1)

    return total_energy(n, total(of_link, 0, n - 1))


def spring_moments(n: int) -> list[Expr]:
    """2.18: k dphi of every spring."""
    return [k * (phi[s + 1] - phi[s]) for s in range(n - 1)]


def spring_energies(n: int) -> list[Expr]:
    """2.19, both forms, for every spring."""
    turns = [phi[s + 1] - phi[s] for s in range(n - 1)]
    return [e for turn in turns for e in (HALF * (k * turn) * turn, HALF * k * turn**2)]


def derived_springs(n: int) -> list[Expr]:
    return [spring_potential(phi[s], phi[s + 1]) for s in range(n - 1)]


def one_link_claim(number: str, link: int, form: Callable[[int], list[Expr]], text: str) -> Claim:
    return Claim(
        number,
        f"kinetic energy of link {link}",
        {READ: form},
        lambda n: 2 * [truth(n).link_energy(link)],
        links=range(link + 1, 7),
        printed=text,
        note="Both sides are compared: the integral and what it is said to be.",
        label=lambda n, at: ("the integral", "its value")[at],
    )


CLAIMS: tuple[Claim, ...] = (
    one_link_claim(
        "2.10",
        0,
        first_link,
        r"E_{k0} = \frac{1}{2} \rho \int_0^l [(v_{x0} - \omega_0 r \sin(\varphi_0))^2 "
        r"+ (v_{y0} + \omega_0 r \cos(\varphi_0))^2] dr = \frac{1}{2} m \left[ v_{x0}^2 + v_{y0}^2 "
        r"+ \frac{1}{3} \omega_0^2 l^2 - v_{x0} \omega_0 l \sin(\varphi_0) "
        r"+ v_{y0} \omega_0 l \cos(\varphi_0) \right]",
    ),
    one_link_claim(
        "2.13",
        1,
        second_link,
        r"E_{k1} = \frac{1}{2} \rho \int_0^l v_2^2 dr = \frac{1}{2} m \left[ v_{x0}^2 + v_{y0}^2 "
        r"+ \omega_0^2 l^2 + \frac{1}{3} \omega_1^2 l^2 - 2 v_{x0} \omega_0 l \sin(\varphi_0) "
        r"+ 2 v_{y0} \omega_0 l \cos(\varphi_0) - v_{x0} \omega_1 l \sin(\varphi_1) "
        r"+ v_{y0} \omega_1 l \cos(\varphi_1) + \omega_0 \omega_1 l^2 \cos(\varphi_1 - \varphi_0) "
        r"\right]",
    ),
    one_link_claim(
        "2.15",
        2,
        third_link,
        r"E_{k2} = \frac{1}{2} \rho \int_0^l v_3^2 dr = \frac{1}{2} m \left[ v_{x0}^2 + v_{y0}^2 "
        r"+ \omega_0^2 l^2 + \omega_1^2 l^2 + \frac{1}{3} \omega_2^2 l^2 "
        r"- 2 v_{x0} \omega_0 l \sin(\varphi_0) + 2 v_{y0} \omega_0 l \cos(\varphi_0) "
        r"- 2 v_{x0} \omega_1 l \sin(\varphi_1) + 2 v_{y0} \omega_1 l \cos(\varphi_1) "
        r"- v_{x0} \omega_2 l \sin(\varphi_2) + v_{y0} \omega_2 l \cos(\varphi_2) "
        r"+ 2 \omega_0 \omega_1 l^2 \cos(\varphi_1 - \varphi_0) "
        r"+ \omega_0 \omega_2 l^2 \cos(\varphi_2 - \varphi_0) "
        r"+ \omega_1 \omega_2 l^2 \cos(\varphi_2 - \varphi_1) \right]",
    ),
    Claim(
        "2.16",
        "kinetic energy of link s",
        {READ: lambda n: [link_energy(s, printed_pairs) for s in range(n)]},
        lambda n: [truth(n).link_energy(s) for s in range(n)],
        corrected=lambda n: [link_energy(s, every_pair_once) for s in range(n)],
        note="The sum over i from 1 to k-1 counts pairs of links a second time, from the fifth "
        "link on; 2.10, 2.13 and 2.15, from which it was generalised, have no such pair. "
        "Its index k is also the letter of the spring stiffness.",
        printed=r"E_{k,s} = \frac{1}{2}m \left\{ v_{x0}^2 + v_{y0}^2 "
        r"+ l^2 \sum_{i=0}^{s-1} \omega_i^2 + \frac{1}{3}\omega_s^2 l^2 "
        r"- 2v_{x0} l \sum_{i=0}^{s-1} \omega_i \sin(\varphi_i) "
        r"+ 2v_{y0} l \sum_{i=0}^{s-1} \omega_i \cos(\varphi_i) "
        r"+ \omega_s l [-v_{x0} \sin(\varphi_s) + v_{y0} \cos(\varphi_s)] "
        r"+ 2l^2 \sum_{k=0}^{s-2} \left[\sum_{i=1}^{k-1} \omega_k \omega_i "
        r"\cos(\varphi_i - \varphi_k) + \sum_{i=k+1}^{s-1} \omega_k \omega_i "
        r"\cos(\varphi_i - \varphi_k) \right] "
        r"+ l^2 \sum_{k=0}^{s-1} \omega_k \omega_s \cos(\varphi_s - \varphi_k) \right\}",
        correction=r"2l^2 \sum_{k=0}^{s-2} \sum_{i=k+1}^{s-1} \omega_k \omega_i "
        r"\cos(\varphi_i - \varphi_k) \text{ in place of the double sum}",
        label=lambda n, at: f"E_k,{at}",
    ),
    Claim(
        "2.17",
        "kinetic energy of the model",
        {"brackets as printed": inside, "last sum outside the sum over j": outside},
        lambda n: [truth(n).kinetic_energy],
        corrected=put_right,
        note="The last sum stands inside the sum over j, so that it counts n times, and has "
        "n-1 where the sum of 2.16 over the links has j; pairs are counted twice as in 2.16.",
        printed=r"E_k = \frac{1}{2}m \left\{ n (v_{x0}^2 + v_{y0}^2) "
        r"+ l^2 \sum_{i=0}^{n-1} \left[\omega_i^2 \left(\frac{1}{3} + (n-i-1) \right) \right] "
        r"- l v_{x0} \sum_{i=0}^{n-1} [\omega_i \sin(\varphi_i) (1 + 2(n-i-1))] "
        r"+ l v_{y0} \sum_{i=0}^{n-1} [\omega_i \cos(\varphi_i) (1 + 2(n-i-1))] "
        r"+ \sum_{j=0}^{n-1} \left[2l^2 \sum_{k=0}^{j-2} \left(\sum_{i=1}^{k-1} \omega_k \omega_i "
        r"\cos(\varphi_i - \varphi_k) + \sum_{i=k+1}^{j-1} \omega_k \omega_i "
        r"\cos(\varphi_i - \varphi_k) \right) "
        r"+ l^2 \sum_{k=0}^{n-2} \omega_k \omega_{n-1} \cos(\varphi_{n-1} - \varphi_k) \right] "
        r"\right\}",
        correction=r"\sum_{j=0}^{n-1} \left[2l^2 \sum_{k=0}^{j-2} \sum_{i=k+1}^{j-1} "
        r"\omega_k \omega_i \cos(\varphi_i - \varphi_k) "
        r"+ l^2 \sum_{k=0}^{j-1} \omega_k \omega_j \cos(\varphi_j - \varphi_k) \right]",
        label=lambda n, at: "E_k",
    ),
    Claim(
        "2.18",
        "moment of a spring",
        {READ: spring_moments},
        lambda n: [e.diff(phi[s + 1]) for s, e in enumerate(derived_springs(n))],
        links=range(2, 7),
        printed=r"M_{s,s+1} = k \Delta\varphi = k (\varphi_{s+1} - \varphi_s)",
        note="The moment that bends the spring; the spring turns link s+1 by the opposite. "
        "The damping moment of 2.50 is counted the other way round.",
        label=lambda n, at: f"M_{at},{at + 1}",
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
    Claim(
        "2.20",
        "energy of all springs",
        {READ: lambda n: [HALF * k * total(lambda s: (phi[s + 1] - phi[s]) ** 2, 0, n - 2)]},
        lambda n: [truth(n).spring_energy],
        printed=r"E_p = \sum E_{p,i} "
        r"= \frac{1}{2} k \sum_{s=0}^{n-2} (\varphi_{s+1} - \varphi_s)^2",
        label=lambda n, at: "E_p",
    ),
)
