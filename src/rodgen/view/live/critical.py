"""The critical follower force of a live run, computed beside it."""

from __future__ import annotations

import threading
from collections.abc import Callable

from rodgen.scene import Scene

MOST_LINKS = 200  # beyond, it takes seconds
PATIENCE = 0.4  # seconds without another change, before it is computed
COMPUTING = "computing"


class Critical:
    """value: critical force [N] of the scene looked at last, or in words why there is none, or
    None where no force follows the rod. done: called when it is there, from another thread."""

    def __init__(self, done: Callable[[], object]):
        self._done = done
        self._timer: threading.Timer | None = None
        self.value: float | str | None = None

    def look(self, scene: Scene) -> None:
        """Another scene counts."""
        self.cancel()
        if "follower" not in scene.structure.terms:
            self.value = None
        elif scene.rod.links > MOST_LINKS:
            self.value = f"not computed: more than {MOST_LINKS} links"
        else:
            self.value = COMPUTING
            self._timer = threading.Timer(PATIENCE, self._compute, (scene,))
            self._timer.daemon = True
            self._timer.start()

    def cancel(self) -> None:
        """What is not begun is not wanted any more, nor is the result of what is."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _compute(self, scene: Scene) -> None:
        from rodgen.analyse.critical import critical_force
        from rodgen.analyse.errors import AnalysisError
        from rodgen.scene import SceneError

        mine = threading.current_thread()
        found: float | str
        try:
            found = critical_force(scene).force
        except (AnalysisError, SceneError) as error:
            found = str(error)
        if mine is self._timer:  # else another scene is looked at meanwhile
            self.value = found
            self._done()
