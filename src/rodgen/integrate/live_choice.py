"""The method of a live run: `auto` is not asked anew for every value that a slider passes."""

from __future__ import annotations

import math
import time
from types import ModuleType

import numpy as np

from rodgen.integrate.methods.choose import Choice, choose
from rodgen.scene import Scene
from rodgen.scene.tables import AUTO

PAUSE = 0.5  # seconds between two choices while values are changed


class Chooser:
    """Methods of scenes of one module."""

    def __init__(self, model: ModuleType):
        self._model, self._at, self._late = model, -math.inf, False

    def choose(self, scene: Scene) -> Choice:
        """What `auto` takes a scene to need, or the method that it asks for."""
        self._at, self._late = time.perf_counter(), False
        with np.errstate(all="ignore"):
            return choose(scene, self._model)

    def choose_sparingly(self, scene: Scene, before: Scene, present: Choice) -> Choice:
        """The same, or the present choice for a while, if both scenes leave it to `auto`."""
        auto = scene.integrate.method == before.integrate.method == AUTO
        if auto and time.perf_counter() - self._at < PAUSE:
            self._late = True
            return present
        return self.choose(scene)

    @property
    def due(self) -> bool:
        """Whether a choice was put off that is to be made now."""
        return self._late and time.perf_counter() - self._at >= PAUSE
