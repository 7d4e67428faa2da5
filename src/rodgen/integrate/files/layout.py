"""What a result file is made of, and how to tell one: coordinates, quantities over time, events,
the text of the run."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.changes import Changes
from rodgen.integrate.files.header import Header, read_header
from rodgen.integrate.files.netcdf import MOST, PAGE
from rodgen.integrate.files.quantities import (
    PARAMETERS,
    WORK,
    Quantity,
    event_variables,
    parameter_names,
    quantities,
)
from rodgen.integrate.solution import Solution, Stats
from rodgen.integrate.stepper import Array, Counts
from rodgen.scene import Scene, SceneError

FORMAT = "rodgen 2"
RUNNING = "running"  # status in a file whose run has not ended
NO_STATS = Stats.of(Counts(), 0.0)
TEXT = {"_Encoding": "utf-8"}  # what xarray makes text from


class Run(NamedTuple):
    """How a run goes; lost: events for which the file had no room."""

    status: str = RUNNING
    message: str = ""
    stats: Stats | None = None
    lost: int = 0

    def text(self) -> bytes:
        """As PAGE bytes of JSON; a message that is too long is cut."""
        run = {**self._asdict(), "stats": self.stats and asdict(self.stats)}
        message = self.message
        while len(text := json.dumps({**run, "message": message}).encode()) > PAGE:
            if not message:
                raise ValueError(f"{len(text)} bytes of status and stats, more than {PAGE}")
            # In JSON a character needs 12 bytes at most.
            message = message[: -max(1, (len(text) - PAGE) // 12)]
        return text.ljust(PAGE)

    @classmethod
    def of(cls, text: str | bytes, path: Path) -> Run:
        """What `text` made; raises SceneError for other text, in the file at path."""
        try:
            run = json.loads(text)
            stats = run["stats"] and Stats(**run["stats"])
            return cls(str(run["status"]), str(run["message"]), stats, int(run["lost"]))
        except (KeyError, TypeError, ValueError) as error:
            raise SceneError("file", str(path), f"written by rodgen ({error!r})") from None


def contents(
    scene: Scene,
    model: ModuleType,
    p: Array,
    terms: Sequence[str],
    events: int,
    changed: bool = False,
) -> tuple[dict[str, int | None], dict[str, Quantity], dict[str, str]]:
    """Dimensions, variables (with one sample at rest) and attributes of a file without samples.

    changed: each sample has parameters of its own. Raises SceneError for more than the format can
    hold.
    """
    states, n = len(model.STATE), scene.rod.links
    zero = np.zeros(1)
    work = dict.fromkeys(terms, zero)
    rest = Solution(scene, zero, np.zeros((1, states)), work, NO_STATS, model=model)
    rest._p, rest.changes = p, Changes(p[None], zero) if changed else None
    with np.errstate(all="ignore"):
        sample = quantities(rest)
    if sum(quantity.values.nbytes for quantity in sample.values()) > MOST:
        raise SceneError("rod.links", n, f"fewer: a sample has more than the {MOST} bytes allowed")
    if 8 * states * events > MOST:
        allowed = f"at most {MOST // (8 * states)} to be kept, of {states} states each"
        raise SceneError("events", events, allowed)
    names = np.array(model.STATE, dtype="S")
    dimensions = {"time": None, "state": states, "link": n, "joint": n + 1, "axis": 2}
    dimensions |= {"letter": 1, "state_letter": names.itemsize, "run_letter": PAGE}
    variables = {
        "state": Quantity(("state", "state_letter"), _letters(names), TEXT),
        "link": Quantity(("link",), np.arange(n, dtype="i4"), {}),
        "joint": Quantity(("joint",), np.arange(n + 1, dtype="i4"), {}),
        "axis": Quantity(("axis", "letter"), _letters(np.array([b"x", b"y"])), TEXT),
        "run": Quantity(("run_letter",), _letters(np.array(Run().text())), TEXT),
    }
    if events:
        dimensions["event"] = events
        none = np.broadcast_to(np.nan, (events, states))
        variables |= event_variables(np.full(events, -1), none[:, 0], none)
    if changed:
        labels = np.array(parameter_names(scene), dtype="S")
        dimensions |= {"parameter": len(labels), "parameter_letter": labels.itemsize}
        over = ("parameter", "parameter_letter")
        variables["parameter"] = Quantity(over, _letters(labels), TEXT)
    how = {key: model.PROVENANCE[key] for key in ("target", "form")}
    return dimensions, variables | sample, {**attributes(scene), **how}


def attributes(scene: Scene) -> dict[str, str]:
    """Which format, from which version, of which scene."""
    table = json.dumps(scene.model_dump(exclude_none=True))
    return {"format": FORMAT, "rodgen": version("rodgen"), "scene": table}


def _letters(texts: NDArray[np.bytes_]) -> NDArray[np.bytes_]:
    """Texts (...) as letters (..., longest)."""
    return texts[..., None].view("S1")


def open_header(path: Path) -> tuple[Header, Scene]:
    """Header of a result file, and its scene; raises SceneError for other files."""
    try:
        with open(path, "rb") as file:
            if file.read(4) == b"\x89HDF":
                raise ValueError("HDF5: from rodgen before 'rodgen 2'")
            header = read_header(file)
    except (OSError, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise SceneError("file", str(path), f"a NetCDF file that can be read ({reason})") from None
    if header.attributes.get("format") != FORMAT:
        raise SceneError("file", str(path), f"written by rodgen (format {FORMAT!r})")
    try:
        return header, Scene.from_dict(json.loads(header.attributes["scene"]))
    except (KeyError, ValueError) as error:
        raise SceneError("file", str(path), f"written by rodgen ({error})") from None


def check_layout(header: Header, scene: Scene, model: ModuleType, p: Array, path: Path) -> None:
    """Raise SceneError unless the file holds just what `contents` says for this scene."""
    found = {name: (v.dimensions, v.dtype, v.shape) for name, v in header.variables.items()}
    terms = [name[len(WORK) :] for name in found if name.startswith(WORK)]
    events = header.variables["event_number"].shape[0] if "event_number" in found else 0
    _, variables, _ = contents(scene, model, p, terms, events, PARAMETERS in found)
    due = {
        name: (over, values.dtype.newbyteorder(">"), values.shape["time" in over :])
        for name, (over, values, _) in variables.items()
    }
    if found != due:
        wrong = ", ".join(sorted(name for name in found | due if found.get(name) != due.get(name)))
        raise SceneError("file", str(path), f"written by rodgen (not so: {wrong})")
