"""Answers of rodgen on a scene, apart from their judgement, so that a test can falsify
them."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import rodgen
from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen_evidence.verdicts.random_scenes import Sketch

KEYS = {
    "follower": "loads.follower.force",
    "distributed_follower": "loads.distributed_follower.force_per_length",
    "gravity": "loads.gravity.g",
    "tip": "loads.tip.x",
}


@dataclass(frozen=True)
class Refusal:
    """An error instead of an answer; input: whether it is the scene that is refused."""

    text: str
    input: bool = False


def ask(call: Callable[[], Any]) -> Any:
    """Call a function; return its answer, or its refusal."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return call()
        except rodgen.AnalysisError as error:
            return Refusal(str(error))
        except InputError as error:
            return Refusal(str(error), True)
        except Exception as error:  # of which a campaign tells, and goes on
            return Refusal(f"{type(error).__name__}: {error}")


@dataclass(frozen=True)
class Answers:
    """The functions whose verdicts are compared, of one scene."""

    sketch: Sketch

    def scene(self, size: float) -> Scene:
        return Scene.from_dict(self.sketch.at(size))

    @property
    def key(self) -> tuple[str, float]:
        """The number that a branch varies, and its value for a load of size one."""
        load = self.sketch.load
        one: Any = self.sketch.at(1.0)["loads"][load]
        if isinstance(one, list):
            return "loads.follower.0.force", 1.0
        return KEYS[load], float(one[KEYS[load].rpartition(".")[2]])

    def critical(self) -> Any:
        """The critical load."""
        scene, load = self.scene(self.sketch.unit), self.sketch.load
        bounds = None, self.sketch.highest
        return ask(lambda: rodgen.critical_load(scene, bounds=bounds, load=load))

    def static(self, size: float) -> Any:
        """The equilibrium under a size of the load."""
        return ask(lambda: rodgen.static_equilibrium(self.scene(size)))

    def modes(self, size: float) -> Any:
        """Small motions under a size of the load."""
        return ask(lambda: rodgen.natural_modes(self.scene(size), count=20))

    def branch(self) -> Any:
        """Equilibria along the load; of a dead force with two components nothing, since one number
        of a scene is varied."""
        if self.sketch.load == "tip" and self.sketch.table["loads"]["tip"].get("y"):
            return None
        key, one = self.key
        ends = 0.0, one * self.sketch.highest
        scene = self.scene(0.0)
        return ask(lambda: rodgen.continue_equilibria(scene, key, ends))
