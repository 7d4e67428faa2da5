"""Conversion of runs to xarray Datasets and pandas tables, and saving to NetCDF files."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.integrate.files import atomic_write
from rodgen.integrate.files.file_layout import (
    attributes,
    event_variables,
    parameter_names,
    state_units,
    variables_of,
)
from rodgen.integrate.files.stream import Stream
from rodgen.integrate.trajectory import Trajectory
from rodgen.model.quantities import (
    DATASET,
    FILE,
    FORCES,
    QUANTITIES,
    SHOWN,
    Index,
    Quantity,
    numbers,
)
from rodgen.result import NOTES, notes_as_text

if TYPE_CHECKING:
    import pandas
    import xarray


def to_xarray(trajectory: Trajectory) -> xarray.Dataset:
    """Dataset over time, state, link, joint and axis, with the unit of every state; work by load
    as work_<term>; events, where there are any, by the number of their kind in the scene."""
    import xarray  # only where it is needed: it takes longer to import than to load a file

    n = trajectory.scene.rod.links
    states = list(trajectory.model.STATE)
    coordinates: dict[str, Any] = {
        "state": states,
        "state_units": ("state", state_units(states)),
        "link": np.arange(n),
        "joint": np.arange(n + 1),
        "axis": ["x", "y"],
        "principal": ["smaller", "larger"],
    }
    if trajectory.changes is not None:
        coordinates["parameter"] = parameter_names(trajectory.scene)
    said = {
        **attributes(trajectory.scene),
        "stats": json.dumps(asdict(trajectory.stats)),
        "status": trajectory.status,
        "message": trajectory.message,
        "energy_error": trajectory.energy_error,
        NOTES: notes_as_text(trajectory.run_notes),
    }
    found = variables_of(trajectory, (FILE, DATASET))
    if trajectory.events:
        times, y = zip(*((event.t, event.y) for event in trajectory.events), strict=True)
        number = np.array(_event_numbers(trajectory))
        found |= event_variables(number, np.array(times), np.array(y))
    return xarray.Dataset(found, coordinates, said)


def _event_numbers(trajectory: Trajectory) -> list[int]:
    """Numbers in the scene of the kinds of all events."""
    names = [event.name for event in trajectory.scene.watched_events]
    return [names.index(event.name) for event in trajectory.events]


def to_pandas(trajectory: Trajectory) -> pandas.DataFrame:
    """Table of what a Dataset holds and of added states, a column a number, units in `attrs`."""
    import pandas  # only where it is needed: it takes long to import

    columns, units = {}, {}
    for quantity in QUANTITIES:
        if quantity.kept == SHOWN:
            continue
        for name, _ in trajectory.names(quantity):
            values = trajectory.values(name)
            for number, at in _numbers(trajectory, quantity, name):
                columns[number] = values[(slice(None), *at)]
                units[number] = quantity.unit
    for back, name in enumerate(reversed(trajectory.extra_states), start=1):
        columns[name] = trajectory.y[:, -back]
        units[name] = ""
    frame = pandas.DataFrame(columns, pandas.Index(trajectory.t, name="t"))
    frame.attrs["units"] = {"t": "s", **units}
    return frame


def _numbers(trajectory: Trajectory, quantity: Quantity, name: str) -> Iterator[tuple[str, Index]]:
    """Names of the single numbers of a quantity, and their indices beside the time."""
    links = trajectory.scene.rod.links
    if quantity.each == FORCES:
        for joint in range(links + 1):
            yield from ((f"{name}_{joint}_{axis}", (joint, k)) for k, axis in enumerate("xy"))
    elif quantity.each:
        yield name, ()
    else:
        yield from (
            (one.name, one.at) for one in numbers(quantity, trajectory.boundary_condition, links)
        )


def save(trajectory: Trajectory, path: Path) -> None:
    """Write a NetCDF file, whole or not at all; raises InputError where there is no folder."""
    parts = trajectory.system, trajectory.model, list(trajectory.work)
    room, changes = len(trajectory.events), trajectory.changes
    with (
        atomic_write(path) as part,
        Stream.create(part, *parts, events=room, changed=changes is not None) as stream,
    ):
        stream.append(trajectory.t, trajectory.y, trajectory.work, changes)
        for number, event in zip(_event_numbers(trajectory), trajectory.events, strict=True):
            stream.add_event(number, event.t, event.y)
        stream.write_notes(trajectory.run_notes)
        stream.finish(trajectory.status, trajectory.message, trajectory.stats)
