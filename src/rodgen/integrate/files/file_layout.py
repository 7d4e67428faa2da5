"""Layout of a result file or a Dataset: coordinates, quantities over time, events; and checksums.

One checksum (CRC-32) is of all that is written once: header, scene, labels. It is in the text of
the run, which has one of itself; each sample and each event has its own. These begin from the first
one and the number of the sample, so that a sample of another file, or of another place, is not
taken for it.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.files.netcdf import MOST, NUMRECS, PAGE, Header
from rodgen.integrate.stepper import Counts, Stats
from rodgen.integrate.trajectory import Changes, Trajectory
from rodgen.model.quantities import FILE, QUANTITIES
from rodgen.result import REMARK, Note
from rodgen.scene import Scene
from rodgen.system import System

FORMAT = "rodgen 3"
UNITS = {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s", "phi_": "rad", "omega_": "rad/s"}
WORK = "work_"  # and the name of the term
PARAMETERS, GIVEN = "parameters", "energy_given"  # of a run that was changed while it went on
TEXT = {"_Encoding": "utf-8"}  # what xarray makes text from

CHECKSUM = "checksum"  # last in a record
EVENT = "event_number", "event_time", "event_y", "event_checksum"
RUN = "run"  # the variable with the text
SEAL = b'{"checksum": "', 8  # how a sealed text begins, and digits that follow
RUNNING = "running"  # status in a file whose run has not ended
NO_STATS = Stats.of(Counts(), 0.0)


class ResultVariable(NamedTuple):
    """Values over dimensions, with their attributes: units, long_name."""

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, str]


def variables_of(
    trajectory: Trajectory, kept: Sequence[str] = (FILE,)
) -> dict[str, ResultVariable]:
    """Variables of a trajectory over time that files hold, by name; kept: which quantities, by
    where they are kept."""
    found = {
        "time": ResultVariable(("time",), trajectory.t, {"units": "s"}),
        "y": ResultVariable(("time", "state"), trajectory.y, {"long_name": "state"}),
    }
    for quantity in QUANTITIES:
        if quantity.kept in kept:
            for name, words in trajectory.names(quantity):
                attributes = {"units": quantity.unit.replace("^", ""), "long_name": words}
                over = ("time", *quantity.dimensions)
                found[name] = ResultVariable(over, trajectory.values(name), attributes)
    changes = trajectory.changes
    if changes is not None:
        attributes = {"long_name": "parameters that held"}
        found[PARAMETERS] = ResultVariable(("time", "parameter"), changes.p, attributes)
        attributes = {"units": "J", "long_name": "energy that changes and kicks have put in"}
        found[GIVEN] = ResultVariable(("time",), changes.given, attributes)
    return found


def state_units(states: Sequence[str]) -> list[str]:
    """Units of the states with these names."""
    return [UNITS.get(name.rstrip("0123456789"), "") for name in states]


def parameter_names(scene: Scene) -> list[str]:
    """Labels of the columns of parameters, one for every number of those that are several."""
    structure = scene.structure
    names = []
    for name in structure.parameters:
        several = structure.index_ranges.get(name)
        names += [name] if several is None else [f"{name}_{at}" for at in several]
    return names


def changes_in(records: NDArray[Any]) -> Changes | None:
    """Changes in the run of some records of a file; None for a run that was not changed."""
    if PARAMETERS not in (records.dtype.names or ()):
        return None
    return Changes(native_copy(records[PARAMETERS]), native_copy(records[GIVEN]))


def native_copy(values: NDArray[Any]) -> Array:
    """Copy an array as C-contiguous doubles in the byte order of this machine."""
    return np.array(values, dtype=float, order="C")


def event_variables(number: NDArray[Any], t: Array, y: Array) -> dict[str, ResultVariable]:
    """Variables of events: number of their kind in the scene, (E,), times, (E,), states, (E, S)."""
    return {
        "event_number": ResultVariable(
            ("event",), number.astype("i4"), {"long_name": "kind of event"}
        ),
        "event_time": ResultVariable(("event",), t, {"units": "s", "long_name": "time of event"}),
        "event_y": ResultVariable(("event", "state"), y, {"long_name": "state at event"}),
    }


def contents(
    system: System,
    model: ModuleType,
    terms: Sequence[str],
    events: int,
    changed: bool = False,
) -> tuple[dict[str, int | None], dict[str, ResultVariable], dict[str, str]]:
    """Dimensions, variables (with one sample at rest) and attributes of a file without samples.

    changed: each sample has parameters of its own. Raises InputError for more than the format can
    hold.
    """
    states, n, scene = len(model.STATE), system.structure.n_links, system.scene
    zero = np.zeros(1)
    work = dict.fromkeys(terms, zero)
    rest = Trajectory(system, zero, np.zeros((1, states)), work, NO_STATS, model=model)
    rest.changes = Changes(system.p[None], zero) if changed else None
    with np.errstate(all="ignore"):
        sample = variables_of(rest)
    if sum(quantity.values.nbytes for quantity in sample.values()) > MOST:
        raise InputError("rod.links", n, f"fewer: a sample has more than the {MOST} bytes allowed")
    if 8 * states * events > MOST:
        allowed = f"at most {MOST // (8 * states)} to be kept, of {states} states each"
        raise InputError("events", events, allowed)
    names = np.array(model.STATE, dtype="S")
    dimensions = {"time": None, "state": states, "link": n, "joint": n + 1, "axis": 2}
    dimensions |= {"letter": 1, "state_letter": names.itemsize, "run_letter": PAGE}
    variables = {
        "state": ResultVariable(("state", "state_letter"), _letters(names), TEXT),
        "link": ResultVariable(("link",), np.arange(n, dtype="i4"), {}),
        "joint": ResultVariable(("joint",), np.arange(n + 1, dtype="i4"), {}),
        "axis": ResultVariable(("axis", "letter"), _letters(np.array([b"x", b"y"])), TEXT),
        "run": ResultVariable(("run_letter",), _letters(np.array(RunState().text())), TEXT),
    }
    if events:
        dimensions["event"] = events
        none = np.broadcast_to(np.nan, (events, states))
        variables |= event_variables(np.full(events, -1), none[:, 0], none)
        zeros = np.zeros(events, "i4")
        variables["event_checksum"] = ResultVariable(("event",), zeros, {"long_name": "its CRC-32"})
    if changed:
        labels = np.array(parameter_names(scene), dtype="S")
        dimensions |= {"parameter": len(labels), "parameter_letter": labels.itemsize}
        over = ("parameter", "parameter_letter")
        variables["parameter"] = ResultVariable(over, _letters(labels), TEXT)
    # The last: in a record it is of all before it.
    sample[CHECKSUM] = ResultVariable(
        ("time",), np.zeros(1, "i4"), {"long_name": "CRC-32 of a sample"}
    )
    how = {key: model.PROVENANCE[key] for key in ("target", "form")}
    return dimensions, variables | sample, {**attributes(scene), **how}


def attributes(scene: Scene) -> dict[str, str]:
    """Attributes of a file: its format, the version of rodgen, and the scene."""
    table = json.dumps(scene.to_dict())
    return {"format": FORMAT, "rodgen": version("rodgen"), "scene": table}


def _letters(texts: NDArray[np.bytes_]) -> NDArray[np.bytes_]:
    """Split texts (...) into letters (..., longest)."""
    return texts[..., None].view("S1")


def check_layout(header: Header, system: System, model: ModuleType, path: Path) -> None:
    """Raise InputError unless the file holds just what `contents` says for this scene."""
    found = {name: (v.dimensions, v.dtype, v.shape) for name, v in header.variables.items()}
    terms = [name[len(WORK) :] for name in found if name.startswith(WORK)]
    events = header.variables["event_number"].shape[0] if "event_number" in found else 0
    _, variables, _ = contents(system, model, terms, events, PARAMETERS in found)
    due = {
        name: (over, values.dtype.newbyteorder(">"), values.shape["time" in over :])
        for name, (over, values, _) in variables.items()
    }
    if found != due:
        wrong = ", ".join(sorted(name for name in found | due if found.get(name) != due.get(name)))
        raise InputError("file", str(path), f"written by rodgen (not so: {wrong})")


def checksum_of_header(header: Header, read: Callable[[int, int], bytes]) -> int:
    """Checksum of what does not change before the records; read: bytes from here, so many."""
    changing = [header.variables[name] for name in (RUN, *EVENT) if name in header.variables]
    left_out = [(NUMRECS, NUMRECS + 4), *((v.begin, v.begin + v.size) for v in changing)]
    found = at = 0
    for begin, end in [*sorted(left_out), (header.start, header.start)]:
        found = zlib.crc32(read(at, begin - at), found)
        at = end
    return found


def checksums_of_records(records: NDArray[Any], first: int, fixed: int) -> NDArray[np.int32]:
    """Checksums of records (K,), which end in room for them; first: the number of the first."""
    content, size = memoryview(records.tobytes()), records.dtype.itemsize
    found = [
        zlib.crc32(content[at : at + size - 4], fixed + first + k & 0xFFFFFFFF)
        for k, at in enumerate(range(0, len(content), size))
    ]
    return np.array(found, np.uint32).view(np.int32)


def checksum_of_event(at: int, number: int, t: Any, y: Any, fixed: int) -> np.int32:
    """Checksum of the event in this place of the file."""
    content = b"".join(np.asarray(v, ">f8").tobytes() for v in (number, t, y))
    return np.uint32(zlib.crc32(content, fixed + at & 0xFFFFFFFF)).view(np.int32)


def is_empty(number: NDArray[Any], t: NDArray[Any], y: NDArray[Any], found: NDArray[Any]) -> bool:
    """Whether places for events are empty, as a new file has them."""
    nothing = np.array(np.nan, ">f8").view(">i8")
    numbers = (number == -1).all() and not found.any()
    return bool(numbers and all((v.view(">i8") == nothing).all() for v in (t, y)))


def seal(text: bytes) -> bytes:
    """Put the checksum of a text of JSON that begins as SEAL does into it."""
    head, digits = SEAL
    assert text.startswith(head)
    rest = text[len(head) + digits :]
    return head + b"%08x" % zlib.crc32(rest) + rest


def is_intact(text: bytes) -> bool:
    """Whether a text has the checksum that `seal` gave it."""
    return text.startswith(SEAL[0]) and text == seal(text)


LEFT_OUT = "a file has no room for the other notes of the run"


class RunState(NamedTuple):
    """State of a run as its file tells it. lost: events for which the file had no room; samples,
    events: how many of them count; fixed: checksum of what in the file does not change."""

    status: str = RUNNING
    message: str = ""
    stats: Stats | None = None
    lost: int = 0
    samples: int = 0
    events: int = 0
    fixed: int = 0
    notes: tuple[Note, ...] = ()

    def text(self) -> bytes:
        """Encode it as PAGE bytes of JSON with a checksum; where they are too few, notes are left
        out, the last first, and a message is cut."""
        run = {"checksum": "0" * SEAL[1], **self._asdict()}
        run["stats"] = self.stats and asdict(self.stats)
        run["notes"] = notes = [note.to_dict() for note in self.notes]
        message = self.message
        while len(text := json.dumps({**run, "message": message}).encode()) > PAGE:
            if len(notes) > 1:
                notes[-2:] = [Note(REMARK, LEFT_OUT).to_dict()]
                continue
            if not message:
                raise ValueError(f"{len(text)} bytes of status and stats, more than {PAGE}")
            # In JSON a character needs 12 bytes at most.
            message = message[: -max(1, (len(text) - PAGE) // 12)]
        return seal(text.ljust(PAGE))

    @classmethod
    def of(cls, text: bytes, path: Path) -> RunState:
        """Decode what `text` made; raises InputError for other text, in the file at path."""
        if not is_intact(text):
            raise InputError("file", str(path), "as it was written (damaged: how the run went)")
        run = json.loads(text)
        run["stats"] = run["stats"] and Stats(**run["stats"])
        run["notes"] = tuple(Note(**one) for one in run["notes"])
        return cls(**{name: run[name] for name in cls._fields})
