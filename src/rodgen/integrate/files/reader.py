"""Solutions from result files: all of one, or some of its samples."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array, even_indices
from rodgen.integrate.files.file_layout import NO_STATS, RUNNING, WORK, changes_in, native_copy
from rodgen.integrate.files.result_file import ResultFile, as_input_error, warn_of_notes
from rodgen.integrate.solution import Solution
from rodgen.integrate.stepper import INTERRUPTED
from rodgen.scene import Scene
from rodgen.system import System


def load(path: str | Path, max_samples: int | None = None, *, strict: bool = True) -> Solution:
    """Read a Solution from a NetCDF file that rodgen wrote.

    The run of a file that has not been ended counts as interrupted.

    Parameters
    ----------
    path
        The file.
    max_samples
        Samples to be read, evenly spaced with the first and the last; all, if not given.
        `energy_error` is that of all.
    strict
        If False, all is read that is not damaged, and what is left out is warned of.

    Returns
    -------
    Solution
        The run, whose module is built when it is asked for.

    Raises
    ------
    InputError
        For other files, and for one that is not as it was written, with the times of samples that
        are damaged.

    Warns
    -----
    FileWarning
        Of what is left out.

    Examples
    --------
    >>> import rodgen, tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "run.nc"
    >>> sol = rodgen.simulate(rodgen.Scene.example("missile"), progress=False)
    >>> sol.save(path)
    >>> bool((rodgen.load(path).y == sol.y).all())
    True
    """
    with ResultFile(Path(path), strict) as file:
        records, good = file.samples()
        solution = solution_of(file, records, good, max_samples)
        warn_of_notes(file.notes)
    return solution


def solution_of(
    file: ResultFile, records: NDArray[Any], good: NDArray[np.intp], max_samples: int | None = None
) -> Solution:
    """Solution of the good records of a file, or of so many of them, evenly spaced."""
    with as_input_error(file.path):
        off = float(np.abs(records["energy_balance"])[good].max(initial=0.0))
        if max_samples is not None and len(good) > max_samples:
            good = good[even_indices(0, len(good) - 1, max_samples)]
        whole = len(good) == len(records)
        taken = records if whole else records[good]
        terms = [name for name in records.dtype.names or () if name.startswith(WORK)]
        work = {name[len(WORK) :]: native_copy(taken[name]) for name in terms}
        t, y = native_copy(taken["time"]), native_copy(taken["y"])
        changes = changes_in(taken)
        if y.shape[1:] != file.scene.initial_state().shape:
            raise ValueError("not so: y")
        events = file.events()
    run = file.run
    status, message = run.status, run.message
    if status == RUNNING:
        status, message = INTERRUPTED, _killed_message(t, file.scene)
    if run.lost:
        message = f"{message}; {run.lost} more events than the file has room for"
    for note in file.notes:
        message = f"{message}; {note}"
    how = status, message.lstrip("; ")
    stats = run.stats or NO_STATS
    solution = Solution(System(file.scene), t, y, work, stats, *how, events=events, changes=changes)
    solution.run_notes = run.notes
    solution.energy_error = off  # of all samples, also of those that are not read
    return solution


def _killed_message(t: Array, scene: Scene) -> str:
    """Message of a run that was killed: how far it came."""
    at = f"killed after t = {t[-1]:.9g} s" if len(t) else "killed before its first sample"
    return f"{at} of {scene.integrate.span[1]:.9g} s; rodgen run --resume continues it"
