"""The moment of a spring that has a law of its own, against the derivative of its energy."""

from __future__ import annotations

import random
from itertools import pairwise

import pytest
from scipy.integrate import quad
from sympy import Add, Expr, Rational, lambdify, symbols

from rodgen.derive.chain import spring_energy, spring_potential
from rodgen.derive.general import GeneralEquations
from rodgen.derive.symbols import ALPHA, bend, k, n, phi, s
from rodgen.emit.spring_expression import law_of
from rodgen.errors import InputError
from rodgen.model.rod import BOUNDARIES
from rodgen.scene.structure import Structure
from tests.palette import cases

LAWS = (
    "k * (d + a * d ** 3)",
    "k * tanh(a * d) + b * d",
    "min(deg(a) * d, k) + sin(deg(b * d))",
    "min(max(k * d, -a), b)",
    "k * d + (a * (d - b) if d > b else a * max(d, b) - a * b)",
    "k * d * (a + abs(d)) + pi * sin(b * d)",
)
DIGITS = 40


def _law(text: str) -> Expr:
    return law_of(Structure(2, spring=text))


@cases("text, boundary", LAWS, BOUNDARIES)
def test_moments_are_the_derivatives_of_the_energy(text: str, boundary: str) -> None:
    """Of four links: V, summed over all springs, is differentiated by every angle; the moments of
    derivation 2 are put together by their joints."""
    links, boundary_condition, law = 4, BOUNDARIES[boundary], _law(text)
    angles = symbols(f"q:{links}", real=True)
    derived = GeneralEquations(boundary, "uniform", (), (), law)
    bent = [
        *[ALPHA] * bool(boundary_condition.root),
        *angles,
        *[ALPHA] * bool(boundary_condition.tail),
    ]
    sizes = (
        [boundary_condition.root] * bool(boundary_condition.root)
        + [1] * (links - 1)
        + [boundary_condition.tail] * bool(boundary_condition.tail)
    )
    springs = zip(sizes, pairwise(bent), strict=True)
    energy = Add(*(spring_potential(b - a, size * k, law) for size, (a, b) in springs))
    on_after = [derived.springs.root.xreplace({phi[0]: angles[0]})]
    for a, b in pairwise(angles):
        on_after.append(derived.springs.inner.xreplace({phi[s - 1]: a, phi[s]: b}))
    on_after.append(derived.springs.tail.xreplace({phi[n - 1]: angles[-1]}))
    draw = random.Random(1)
    known = sorted((energy.free_symbols | law.free_symbols) - {bend}, key=str)
    for _ in range(2):
        here = {x: Rational(draw.randint(-99, 99), 50) for x in known}
        here |= {x: abs(here[x]) + 1 for x in known if x.is_positive}
        for at in range(boundary_condition.first, links):
            by_joints = (on_after[at] - on_after[at + 1]).evalf(DIGITS, subs=here)
            by_energy = -energy.diff(angles[at]).evalf(DIGITS, subs=here)
            assert abs(by_joints - by_energy) < 10 ** (5 - DIGITS)


def test_energy_is_the_integral_of_the_moment() -> None:
    """Against quadrature, which knows no antiderivative."""
    for law in map(_law, LAWS):
        known = sorted(law.free_symbols - {bend}, key=str)
        values = {x: (3 + at) / 4 for at, x in enumerate(known)}
        moment, energy = (lambdify(bend, e.subs(values)) for e in (law, spring_energy(law)))
        for angle in (-1.4, 0.1, 1.7):
            found, error = quad(moment, 0.0, angle, limit=500, epsabs=1e-12)
            assert energy(angle) == pytest.approx(found, abs=max(10 * error, 1e-12))


@pytest.mark.parametrize("text", ["k * exp(sin(d))", "k * d * exp(a * d) / (b + d ** 4)"])
def test_a_law_without_an_elementary_integral_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"rod\.spring") as caught:
        _law(text)
    assert caught.value.value == text
