"""The classical Runge-Kutta method."""

from fractions import Fraction

from rodgen.model.method import Method, Tableau

SIXTH, THIRD, HALF = Fraction(1, 6), Fraction(1, 3), Fraction(1, 2)
TABLEAU = Tableau(
    A=((), (HALF,), (0, HALF), (0, 0, 1)),
    b=(SIXTH, THIRD, THIRD, SIXTH),
)
METHOD = Method(
    place=3,
    order=4,
    steps="fixed",
    about="the classical Runge-Kutta method",
    citation="W. Kutta 1901; thesis 1.84",
    tableau=TABLEAU,
)
