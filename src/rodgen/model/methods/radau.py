"""Collocation at Radau's three points with the end among them (Radau IIA): L-stable."""

from rodgen.model.method import CollocationRule, Method

METHOD = Method(
    place=7,
    order=5,
    steps="adaptive",
    implicit=True,
    about="implicit, L-stable, error control, dense output of order 4: for strong damping",
    citation="E. Hairer, G. Wanner: Solving Ordinary Differential Equations II, IV.8",
    collocation=CollocationRule(powers=(2, 3), power=5, weight=4.5),
    scipy="Radau",
    compiled=True,
)
