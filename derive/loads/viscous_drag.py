"""Viscous drag: a medium resists in proportion to the speed, as one does where motion is slow."""

from ..closed_form import Num
from .medium_drag import MediumDrag


class ViscousDrag(MediumDrag):
    """Drag in proportion to v, across the rod and along it; smooth at rest."""

    letter = "D_v"

    def law(self, speed: Num) -> Num:
        return speed


LOAD = ViscousDrag()
