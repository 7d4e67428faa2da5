"""How the mass of a link is spread along it: a mean over the fraction xi in [0, 1].

Only this mean enters the equations, so a mass distribution is its moments <1>, <xi>, <xi^2>.
"""

from collections.abc import Callable
from functools import cache

from sympy import Expr, Poly, S, integrate

from .symbols import xi

INERTIAS: dict[str, Callable[[Expr], Expr]] = {
    # spread evenly: <f> is the integral of f, which gives m l^2/12 about the centre
    "uniform": lambda f: integrate(f, (xi, 0, 1)),
    # half of it at each end of a massless link, so that m gathers at every inner joint
    "lumped": lambda f: (f.subs(xi, 0) + f.subs(xi, 1)) / 2,
}


def mass_mean(inertia: str, expression: Expr) -> Expr:
    """Mean of a polynomial in xi over the mass of one link."""
    powers = Poly(expression, xi).all_coeffs()[::-1]
    weigh = INERTIAS[inertia]
    return sum((c * _moment(weigh, power) for power, c in enumerate(powers)), start=S.Zero)


@cache
def _moment(weigh: Callable[[Expr], Expr], power: int) -> Expr:
    """<xi**power>: SymPy takes as long for it as for the rest of an entry."""
    return weigh(xi**power)
