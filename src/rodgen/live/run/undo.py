"""The scenes that a run had before its present one, to go back to, and forth again."""

from __future__ import annotations

from typing import NamedTuple

from rodgen.scene import Scene

MOST = 100


class Kept(NamedTuple):
    """A scene; the file's that it was made of; whether a run of it begins at its start."""

    scene: Scene
    file: Scene
    anew: bool


class Undo:
    """Changes of the scene of a run. file: the scene as it was taken up, before any change. To be
    used from one thread at a time."""

    def __init__(self, scene: Scene):
        self.file = scene
        self._back: list[Kept] = []
        self._forth: list[Kept] = []
        self._last = ""

    def note(self, before: Scene, what: str, anew: bool = False) -> None:
        """Note a change of a scene ("name = value"); those of one value that follow each other, as
        a slider makes them, count as one. anew: its run begins at the start."""
        name, is_change, _ = what.partition(" = ")
        self._forth.clear()
        if not (is_change and self._last == name and self._back):
            self._back = [*self._back[1 - MOST :], Kept(before, self.file, anew)]
        self._last = name if is_change else ""

    def take(self, before: Scene, scene: Scene) -> None:
        """Note that the scene of a file was taken up."""
        self.note(before, "", anew=True)
        self.file = scene

    def next(self, forth: bool) -> Kept | None:
        """What is gone back to next, or forth; None where there is nothing."""
        some = self._forth if forth else self._back
        return some[-1] if some else None

    def go(self, before: Scene, forth: bool) -> None:
        """Note that it was gone there, from a scene."""
        here, there = (self._forth, self._back) if forth else (self._back, self._forth)
        gone = here.pop()
        there.append(Kept(before, self.file, gone.anew))
        self.file, self._last = gone.file, ""
