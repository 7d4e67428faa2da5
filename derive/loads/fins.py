"""Fins: the air pushes them across the rod."""

from .air_force import NormalForce


class Fins(NormalForce):
    """Normal force of a set of fins at the point where it acts."""

    letter = "A_f"


LOAD = Fins()
