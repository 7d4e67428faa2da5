"""What was done to a run: the systems that it had before its present one, to go back to, and forth
again, and kicks and pulls, before which it can go back alone."""

from __future__ import annotations

from typing import NamedTuple

from rodgen.live.run.marks import Mark
from rodgen.scene import Scene
from rodgen.system import System

MOST = 100


class Kept(NamedTuple):
    """A system; the scene of the file that it was made of; whether a run of it begins at its start;
    what was done to it, in words; the kick or pull before which the run goes back, if it was
    one."""

    system: System
    file: Scene
    anew: bool
    what: str
    mark: Mark | None = None


class Undo:
    """Changes of the scene of a run. file: the scene as it was taken up, before any change. To be
    used from one thread at a time."""

    def __init__(self, scene: Scene):
        self.file = scene
        self._back: list[Kept] = []
        self._forth: list[Kept] = []
        self._last = ""

    def note(self, before: System, what: str, anew: bool = False) -> None:
        """Note a change of a system ("name = value", or other words); those of one value that
        follow each other, as a slider makes them, count as one. anew: its run begins at the
        start."""
        name, is_change, _ = what.partition(" = ")
        self._forth.clear()
        if is_change and self._last == name and self._back:
            self._back[-1] = self._back[-1]._replace(what=what)
        else:
            self._back = [*self._back[1 - MOST :], Kept(before, self.file, anew, what)]
        self._last = name if is_change else ""

    def note_mark(self, system: System, mark: Mark) -> None:
        """Note a kick or a pull of a run."""
        self.note(system, str(mark))
        self._back[-1] = self._back[-1]._replace(mark=mark)

    def begin(self) -> None:
        """Let go of kicks and pulls: the run that had them is over."""
        self._back = [kept for kept in self._back if kept.mark is None]

    def take(self, before: System, scene: Scene) -> None:
        """Note that the scene of a file was taken up."""
        self.note(before, f"scene {scene.name}", anew=True)
        self.file = scene

    def next(self, forth: bool) -> Kept | None:
        """What is gone back to next, or forth; None where there is nothing."""
        some = self._forth if forth else self._back
        return some[-1] if some else None

    def go(self, before: System, forth: bool) -> None:
        """Note that it was gone there, from a system."""
        here, there = (self._forth, self._back) if forth else (self._back, self._forth)
        gone = here.pop()
        if gone.mark is None:
            there.append(gone._replace(system=before, file=self.file))
        self.file, self._last = gone.file, ""
