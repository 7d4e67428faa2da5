"""Backward differentiation formulas of order 1 to 5."""

from rodgen.model.method import Method

METHOD = Method(
    place=10,
    order=5,
    steps="adaptive",
    varies=True,
    implicit=True,
    about="implicit, backward differentiation",
    citation="L. F. Shampine, M. W. Reichelt 1997",
    scipy="BDF",
)
