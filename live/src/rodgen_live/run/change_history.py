"""History of a run: marks of what was done to it, and when; undo and redo."""

from __future__ import annotations

from typing import NamedTuple

from rodgen.scene import Scene
from rodgen.system import System

MOST_MARKS, MOST_STEPS = 200, 100


class ChangeMark(NamedTuple):
    """A change or a kick, in words, and when it acted [s]."""

    t: float
    what: str

    def __str__(self) -> str:
        return f"{self.what} at t = {self.t:.6g} s"


class ChangeMarks:
    """The changes and kicks since the start, in order; of too many, the first ones and the last."""

    def __init__(self) -> None:
        self.every: tuple[ChangeMark, ...] = ()

    def note(self, t: float, what: str) -> None:
        """Add a change ("name = value") or a kick; changes of one name in a row count as one."""
        name, is_change, _ = what.partition(" = ")
        kept = self.every
        if is_change and kept and kept[-1].what.startswith(f"{name} = "):
            kept = kept[:-1]
        self.every = (*kept[: MOST_MARKS - 1], ChangeMark(t, what))

    def drop_from(self, mark: ChangeMark) -> None:
        """Drop a mark, and those after it."""
        kept = self.every[: self.every.index(mark)] if mark in self.every else self.every
        self.every = tuple(one for one in kept if one.t <= mark.t)


class UndoState(NamedTuple):
    """A step to go back to: a system; the scene of the file that it was made of; whether a run of
    it begins at its start; what was done to it, in words; the kick or pull before which the run
    goes back, if it was one."""

    system: System
    file: Scene
    anew: bool
    what: str
    mark: ChangeMark | None = None


class Undo:
    """History of the changes of a run's scene. file: the scene as it was taken up, before any
    change. To be used from one thread at a time."""

    def __init__(self, scene: Scene):
        self.file = scene
        self._back: list[UndoState] = []
        self._forth: list[UndoState] = []
        self._last = ""

    def note(self, before: System, what: str, anew: bool = False) -> None:
        """Add a change of a system ("name = value", or other words); those of one value that follow
        each other, as a slider makes them, count as one. anew: its run begins at the start."""
        name, is_change, _ = what.partition(" = ")
        last, self._last = self._last, name if is_change else ""
        if is_change and last == name and self._back:
            self._forth.clear()
            self._back[-1] = self._back[-1]._replace(what=what)
        else:
            self._add(UndoState(before, self.file, anew, what))

    def note_mark(self, system: System, mark: ChangeMark) -> None:
        """Add a kick or a pull of a run: each is a step of its own."""
        self._last = ""
        self._add(UndoState(system, self.file, False, str(mark), mark))

    def _add(self, state: UndoState) -> None:
        self._forth.clear()
        self._back = [*self._back[1 - MOST_STEPS :], state]

    def drop_marks(self) -> None:
        """Drop kicks and pulls: the run that had them is over."""
        self._back = [kept for kept in self._back if kept.mark is None]

    def note_scene(self, before: System, scene: Scene) -> None:
        """Add the change to the scene of a file."""
        self.note(before, f"scene {scene.name}", anew=True)
        self.file = scene

    def next_state(self, forth: bool) -> UndoState | None:
        """Step that is undone next, or redone (forth); None where there is none."""
        some = self._forth if forth else self._back
        return some[-1] if some else None

    def note_move(self, before: System, forth: bool) -> None:
        """Note that the next step was undone, or redone (forth), from a system."""
        here, there = (self._forth, self._back) if forth else (self._back, self._forth)
        gone = here.pop()
        if gone.mark is None:
            there.append(gone._replace(system=before, file=self.file))
        self.file, self._last = gone.file, ""
