"""The scene and the module that quantities come from."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from rodgen.integrate.stepper import Array
from rodgen.scene import Scene
from rodgen.scene.structure import TIMED


class Source:
    """What the groups of a scene come from; all of it is fixed by its structure."""

    def __init__(self, scene: Scene, model: ModuleType):
        self.model, self.hold, self.links = model, scene.hold, scene.rod.links
        self.timed = scene.timed
        self.loads = tuple(name for name in scene.loads.parameters if name in TIMED)
        y, p = scene.initial_state(), model.parameters(**scene.parameters)
        with np.errstate(all="ignore"):  # of a state that cannot be integrated
            powers = model.power(0.0, y, p) if hasattr(model, "power") else {}
        self.works: tuple[str, ...] = tuple(powers)

    def parameter(self, name: str, p: Array) -> float:
        """A scalar parameter out of p; 0 for one that the module does not have."""
        names = self.model.PARAMETERS
        return float(p[names.index(name)]) if name in names else 0.0
