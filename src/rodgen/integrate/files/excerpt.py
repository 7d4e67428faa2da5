"""Chosen samples of a result file: of the others nothing but their times is read."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.files.layout import NO_STATS, Run, open_header
from rodgen.integrate.files.netcdf import RecordFile
from rodgen.integrate.files.quantities import changes_in, plain
from rodgen.integrate.solution import Solution
from rodgen.scene import SceneError


class Excerpt:
    """A result file; scene: that of its run; model: its module, where it is built; t: times of
    all its samples [s], (T,).

    Raises SceneError for files that rodgen did not write.
    """

    def __init__(self, path: Path):
        self.path = path
        self.model: ModuleType | None = None
        self._header, self.scene = open_header(path)
        try:
            with RecordFile(path, self._header, "r") as file:
                self._run = Run.of(file.fixed("run").tobytes(), path)
                self.t = plain(file.records()["time"])
                states = file.records()["y"].shape[1:]
        except (LookupError, OSError, TypeError, ValueError) as error:
            raise SceneError("file", str(path), f"written by rodgen ({error})") from None
        if states != self.scene.initial_state().shape:
            raise SceneError("file", str(path), "written by rodgen (not so: y)")

    def at(self, kept: NDArray[np.intp]) -> Solution:
        """The samples with these numbers, without their work and events."""
        try:
            with RecordFile(self.path, self._header, "r") as file:
                records = file.records()
                y, changes = plain(records["y"][kept]), changes_in(records, kept)
        except (OSError, ValueError) as error:  # it was changed meanwhile
            raise SceneError("file", str(self.path), f"as it was ({error})") from None
        stats = self._run.stats or NO_STATS
        run = self._run
        how = run.status, run.message, self.model
        return Solution(self.scene, self.t[kept], y, {}, stats, *how, changes=changes)
