"""Chosen samples of a result file: of the others nothing but their times is read."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.files.netcdf import RecordFile
from rodgen.integrate.files.quantities import changes_in, plain
from rodgen.integrate.files.status import NO_STATS
from rodgen.integrate.files.stored import Stored, as_rodgens
from rodgen.integrate.solution import Solution
from rodgen.scene import SceneError


class Excerpt:
    """A result file; scene: that of its run; model: its module, where it is built; t: times of its
    samples [s], (T,), of those that are not damaged; notes: what is to be said of it.

    Raises SceneError for files that rodgen did not write, and, unless strict is False, for those
    that are not as they were written.
    """

    def __init__(self, path: Path, strict: bool = True):
        self.path = path
        self.model: ModuleType | None = None
        with Stored(path, strict) as file, as_rodgens(path):
            records, self._good = file.samples()
            file.events()  # none of them is shown, but a damaged file is to be told of
            self.t = plain(records["time"])[self._good]
            states = records["y"].shape[1:]
            self.scene, self.notes = file.scene, tuple(file.notes)
            self._header, self._run = file.header, file.run
        if states != self.scene.initial_state().shape:
            raise SceneError("file", str(path), "written by rodgen (not so: y)")

    def at(self, kept: NDArray[np.intp]) -> Solution:
        """The samples with these numbers, without their work and events."""
        try:
            with RecordFile(self.path, self._header, "r") as file:
                file.count = int(self._good[-1]) + 1
                records, numbers = file.records(), self._good[kept]
                y, changes = plain(records["y"][numbers]), changes_in(records, numbers)
        except (OSError, ValueError) as error:  # it was changed meanwhile
            raise SceneError("file", str(self.path), f"as it was ({error})") from None
        stats = self._run.stats or NO_STATS
        run = self._run
        how = run.status, run.message, self.model
        return Solution(self.scene, self.t[kept], y, {}, stats, *how, changes=changes)
