"""Solutions as xarray's Datasets, and in NetCDF files (see stream.py)."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.files.layout import NO_STATS, RUNNING, Run, attributes, open_header
from rodgen.integrate.files.netcdf import RecordFile
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
from rodgen.integrate.files.stream import Stream
from rodgen.integrate.files.whole import replaced
from rodgen.integrate.solution import Event, Solution
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError

if TYPE_CHECKING:
    import xarray

INTERRUPTED = "interrupted"


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


def load(path: str | Path, most: int | None = None) -> Solution:
    """Read a Solution from a NetCDF file that rodgen wrote; raises SceneError for others.

    most: samples to be read, evenly spaced with the first and the last (all, if not given);
    energy_error is that of all. The run of a file that has not been ended counts as interrupted.
    """
    path = Path(path)
    header, scene = open_header(path)
    try:
        with RecordFile(path, header, "r") as file:  # not through xarray: the file may be growing
            text = file.fixed("run").tobytes()
            whole, events = file.records(), _events(file, scene)
            off = float(np.abs(whole["energy_balance"]).max(initial=0.0))
            records = _thinned(whole, most)
            terms = [name for name in header.record.names or () if name.startswith(WORK)]
            work = {name[len(WORK) :]: plain(records[name]) for name in terms}
            t, y = plain(records["time"]), plain(records["y"])
            changes = changes_in(records)
    except (LookupError, OSError, TypeError, ValueError) as error:
        raise SceneError("file", str(path), f"written by rodgen ({error})") from None
    run = Run.of(text, path)
    status, message = run.status, run.message
    if status == RUNNING:
        status, message = INTERRUPTED, _how_far(t, scene)
    stats = run.stats or NO_STATS
    if run.lost:
        message = f"{message}; {run.lost} more events than the file has room for".lstrip("; ")
    solution = Solution(scene, t, y, work, stats, status, message, events=events, changes=changes)
    solution.energy_error = off  # of all samples, also of those that are not read
    return solution


def _thinned(records: NDArray[Any], most: int | None) -> NDArray[Any]:
    if most is None or len(records) <= most:
        return records
    kept = np.linspace(0, len(records) - 1, most).round().astype(int)
    thinned: NDArray[Any] = records[np.unique(kept)]
    return thinned


def _how_far(t: Array, scene: Scene) -> str:
    """What is said of a run that did not come to say it itself."""
    at = f"killed after t = {t[-1]:.9g} s" if len(t) else "killed before its first sample"
    return f"{at} of {scene.integrate.span[1]:.9g} s; rodgen run --resume continues it"


def _events(file: RecordFile, scene: Scene) -> tuple[Event, ...]:
    if "event_number" not in file.header.variables:
        return ()
    number, t, y = (file.fixed(f"event_{what}") for what in ("number", "time", "y"))
    kept = np.flatnonzero(number >= 0)
    names = (scene.events[k].name for k in number[kept])
    return tuple(map(Event, names, map(float, t[kept]), plain(y[kept])))
