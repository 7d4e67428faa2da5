"""What a result file is made of: coordinates, quantities over time, events, checksums."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.changes import Changes
from rodgen.integrate.files.checks import CHECKSUM
from rodgen.integrate.files.header import Header
from rodgen.integrate.files.netcdf import MOST, PAGE
from rodgen.integrate.files.quantities import (
    PARAMETERS,
    WORK,
    Quantity,
    event_variables,
    parameter_names,
    quantities,
)
from rodgen.integrate.files.status import NO_STATS, Run
from rodgen.integrate.solution import Solution
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError

FORMAT = "rodgen 3"
TEXT = {"_Encoding": "utf-8"}  # what xarray makes text from


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
        zeros = np.zeros(events, "i4")
        variables["event_checksum"] = Quantity(("event",), zeros, {"long_name": "its CRC-32"})
    if changed:
        labels = np.array(parameter_names(scene), dtype="S")
        dimensions |= {"parameter": len(labels), "parameter_letter": labels.itemsize}
        over = ("parameter", "parameter_letter")
        variables["parameter"] = Quantity(over, _letters(labels), TEXT)
    # The last: in a record it is of all before it.
    sample[CHECKSUM] = Quantity(("time",), np.zeros(1, "i4"), {"long_name": "CRC-32 of a sample"})
    how = {key: model.PROVENANCE[key] for key in ("target", "form")}
    return dimensions, variables | sample, {**attributes(scene), **how}


def attributes(scene: Scene) -> dict[str, str]:
    """Which format, from which version, of which scene."""
    table = json.dumps(scene.model_dump(exclude_none=True))
    return {"format": FORMAT, "rodgen": version("rodgen"), "scene": table}


def _letters(texts: NDArray[np.bytes_]) -> NDArray[np.bytes_]:
    """Texts (...) as letters (..., longest)."""
    return texts[..., None].view("S1")


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
