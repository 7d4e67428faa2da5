"""Drag of a medium by the square of the speed."""

from ..closed_form import Num
from .medium_drag import MediumDrag


class Drag(MediumDrag):
    """Drag in proportion to |v| v, across the rod and along it."""

    letter = "D_w"

    def law(self, speed: Num) -> Num:
        return abs(speed) * speed


LOAD = Drag()
