"""Solutions as xarray's Datasets, and in NetCDF files (see stream.py)."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.files.layout import attributes
from rodgen.integrate.files.quantities import (
    WORK,
    changes_in,
    derived,
    event_variables,
    parameter_names,
    plain,
    quantities,
    state_units,
)
from rodgen.integrate.files.status import NO_STATS, RUNNING
from rodgen.integrate.files.stored import INTERRUPTED, Stored, as_rodgens, warn
from rodgen.integrate.files.stream import Stream
from rodgen.integrate.files.whole import replaced
from rodgen.integrate.solution import Solution
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene

if TYPE_CHECKING:
    import xarray


def to_xarray(solution: Solution) -> xarray.Dataset:
    """Dataset over time, state, link, joint and axis, with the unit of every state; work by load
    as work_<term>; events, where there are any, by the number of their kind in the scene."""
    import xarray  # only where it is needed: it takes longer to import than to load a file

    n = solution.scene.rod.links
    states = list(solution.model.STATE)
    coordinates: dict[str, Any] = {
        "state": states,
        "state_units": ("state", state_units(states)),
        "link": np.arange(n),
        "joint": np.arange(n + 1),
        "axis": ["x", "y"],
        "principal": ["smaller", "larger"],
    }
    if solution.changes is not None:
        coordinates["parameter"] = parameter_names(solution.scene)
    notes = {
        **attributes(solution.scene),
        "stats": json.dumps(asdict(solution.stats)),
        "status": solution.status,
        "message": solution.message,
        "energy_error": solution.energy_error,
    }
    variables = quantities(solution) | derived(solution)
    if solution.events:
        times, y = zip(*((event.t, event.y) for event in solution.events), strict=True)
        number = np.array(_event_numbers(solution))
        variables |= event_variables(number, np.array(times), np.array(y))
    return xarray.Dataset(variables, coordinates, notes)


def _event_numbers(solution: Solution) -> list[int]:
    """Number in the scene of the kind of every event."""
    names = [event.name for event in solution.scene.events]
    return [names.index(event.name) for event in solution.events]


def save(solution: Solution, path: Path) -> None:
    """Write a NetCDF file, whole or not at all; raises SceneError where there is no folder."""
    parts = (solution.scene, solution.model, solution._p, list(solution.work))
    room, changes = len(solution.events), solution.changes
    with (
        replaced(path) as part,
        Stream.create(part, *parts, events=room, changed=changes is not None) as stream,
    ):
        stream.append(solution.t, solution.y, solution.work, changes)
        for number, event in zip(_event_numbers(solution), solution.events, strict=True):
            stream.add_event(number, event.t, event.y)
        stream.finish(solution.status, solution.message, solution.stats)


def load(path: str | Path, most: int | None = None, *, strict: bool = True) -> Solution:
    """Read a Solution from a NetCDF file that rodgen wrote; raises SceneError for others, and for
    one that is not as it was written, with the times of samples that are damaged.

    most: samples to be read, evenly spaced with the first and the last (all, if not given);
    energy_error is that of all. strict: if not so, all is read that is not damaged, and what is
    left out is warned of (FileWarning). The run of a file that has not been ended counts as
    interrupted. Files of rodgen before format "rodgen 3" cannot be checked, and are warned of.
    """
    with Stored(Path(path), strict) as file:
        records, good = file.samples()
        solution = solution_of(file, records, good, most)
        warn(file.notes)
    return solution


def solution_of(
    file: Stored, records: NDArray[Any], good: NDArray[np.intp], most: int | None = None
) -> Solution:
    """Of those records of a file that are good, evenly spaced ones, at most so many."""
    with as_rodgens(file.path):
        off = float(np.abs(records["energy_balance"])[good].max(initial=0.0))
        if most is not None and len(good) > most:
            kept = np.unique(np.linspace(0, len(good) - 1, most).round().astype(int))
            good = good[kept]
        whole = len(good) == len(records)
        taken = records if whole else records[good]
        terms = [name for name in records.dtype.names or () if name.startswith(WORK)]
        work = {name[len(WORK) :]: plain(taken[name]) for name in terms}
        t, y = plain(taken["time"]), plain(taken["y"])
        changes = changes_in(taken)
        if y.shape[1:] != file.scene.initial_state().shape:
            raise ValueError("not so: y")
        events = file.events()
    run = file.run
    status, message = run.status, run.message
    if status == RUNNING:
        status, message = INTERRUPTED, _how_far(t, file.scene)
    if run.lost:
        message = f"{message}; {run.lost} more events than the file has room for"
    for note in file.notes if file.checked else ():
        message = f"{message}; {note}"
    how = status, message.lstrip("; ")
    stats = run.stats or NO_STATS
    solution = Solution(file.scene, t, y, work, stats, *how, events=events, changes=changes)
    solution.energy_error = off  # of all samples, also of those that are not read
    return solution


def _how_far(t: Array, scene: Scene) -> str:
    """What is said of a run that did not come to say it itself."""
    at = f"killed after t = {t[-1]:.9g} s" if len(t) else "killed before its first sample"
    return f"{at} of {scene.integrate.span[1]:.9g} s; rodgen run --resume continues it"
