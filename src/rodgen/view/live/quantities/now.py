"""What the rows of the text panel show, and from where."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

from rodgen.integrate.stepper import Array
from rodgen.scene import Scene
from rodgen.view.live.quantities.groups import Groups
from rodgen.view.live.quantities.numbers import five
from rodgen.view.live.quantities.per_link import PerLink, per_link
from rodgen.view.live.quantities.present import Present, Row
from rodgen.view.live.quantities.source import Source


class Now:
    """What the rows show: the last sample of a run, and what follows from it."""

    def __init__(self, scene: Scene, model: ModuleType, present: Present):
        self.scene, self.model, self.present = scene, model, present
        self.source = Source(scene, model)
        self.groups = Groups(self.source, present.chunk.last())

    def group(self, name: str) -> Array:
        """The columns of a group at present."""
        row: Array = self.groups[name][0]
        return row

    def parameter(self, name: str) -> float:
        """A parameter of the module, or of a load that changes with time, at present."""
        if name in self.source.loads:
            return float(self.group("loads")[self.source.loads.index(name)])
        return self.source.parameter(name, self.present.p)

    @property
    def fins(self) -> Array:
        """Fin factors of all joints, the last parameters."""
        return self.present.p[self.model.PARAMETERS.index("fin_factor_0") :]

    @property
    def per_link(self) -> PerLink:
        """Of one link and one spring."""
        return per_link(self.model, self.present.p)


Entry = tuple[Row, Callable[[Now], str]]


def parameter(name: str, label: str, unit: str) -> Entry:
    """A row that shows a parameter."""
    return Row(name, label, unit), lambda now: five(now.parameter(name))


def column(key: str, label: str, unit: str, group: str, column: int) -> Entry:
    """A row that shows a column of a group."""
    return Row(key, label, unit), lambda now: five(float(now.group(group)[column]))
