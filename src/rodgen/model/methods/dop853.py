"""Dormand and Prince's method of order 8, its error estimated by order 5 and 3."""

from rodgen.model.method import Method

METHOD = Method(
    place=5,
    order=8,
    steps="adaptive",
    about="explicit, error control, dense output of order 7",
    citation="E. Hairer, S. P. Norsett, G. Wanner: Solving Ordinary Differential Equations I, II.5",
    scipy="DOP853",
    compiled=True,
)
