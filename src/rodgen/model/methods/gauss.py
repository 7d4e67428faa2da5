"""Gauss collocation at three points: it neither damps nor drives an oscillation."""

from rodgen.model.method import CollocationRule, Method

METHOD = Method(
    place=6,
    order=6,
    steps="either",
    implicit=True,
    about="implicit, error control, dense output of order 5: for oscillating stiffness",
    citation="E. Hairer, C. Lubich, G. Wanner: Geometric Numerical Integration, II.1",
    collocation=CollocationRule(powers=(3, 3), power=6, weight=7.0),
    compiled=True,
)
