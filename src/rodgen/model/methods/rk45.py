"""Dormand and Prince's pair of orders 5 and 4."""

from rodgen.model.method import Method

METHOD = Method(
    place=9,
    order=5,
    steps="adaptive",
    about="explicit, error control",
    citation="J. R. Dormand, P. J. Prince 1980",
    scipy="RK45",
    per_step=1 / 10,
)
