"""Euler's method: y(t + h) = y + h f(t, y)."""

from rodgen.model.method import Method, Tableau

METHOD = Method(
    place=1,
    order=1,
    steps="fixed",
    about="explicit, fixed step",
    citation="L. Euler 1768; thesis 1.75",
    tableau=Tableau(A=((),), b=(1,)),
)
