"""Nose, shoulder or boat tail: the air pushes across the rod where its girth changes."""

from .air_force import NormalForce


class Nose(NormalForce):
    """Normal force of a body whose cross section grows or shrinks."""

    letter = "A_n"


LOAD = Nose()
