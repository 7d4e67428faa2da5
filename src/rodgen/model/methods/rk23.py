"""Bogacki and Shampine's pair of orders 3 and 2."""

from rodgen.model.method import Method

METHOD = Method(
    place=8,
    order=3,
    steps="adaptive",
    about="explicit, error control",
    citation="P. Bogacki, L. F. Shampine 1989",
    scipy="RK23",
    per_step=1 / 10,
)
