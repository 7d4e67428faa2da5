"""The tables of a scene with other sizes of its loads."""

from __future__ import annotations

from typing import Any

import numpy as np

from rodgen_evidence.verdicts.link_chain import Table

SIZES = "force", "force_per_length", "g", "x", "y", "normal", "tangential"


def with_load(table: Table, load: str, size: float, others: float = 1.0) -> Table:
    """The tables of a scene with another size of one load, and a share of the others; forces by
    feedback act in full."""
    loads = {name: _scale(one, others) for name, one in table["loads"].items()}
    if load == "follower":
        one = table["loads"][load]
        several = _scale(one, others) if isinstance(one, list) else [one]
        several = [several[0] | {"force": size}, *several[1:]]
        loads[load] = several if isinstance(one, list) else several[0]
    elif load == "distributed_follower":
        loads[load] = {"force_per_length": size / table["rod"]["length"]}
    elif load == "gravity":
        loads[load] = {"g": size}
    elif load == "tip":
        x, y = (table["loads"][load].get(axis, 0.0) for axis in "xy")
        length = float(np.hypot(x, y))
        loads[load] = {"x": size * x / length, "y": size * y / length}
    return table | {"loads": loads}


def _scale(load: Any, share: float) -> Any:
    """Multiply the sizes of a load by a share."""
    if share == 1.0:
        return load
    if isinstance(load, list):
        return [_scale(one, share) for one in load]
    sizes = {key: v for key, v in load.items() if key in SIZES and not isinstance(v, str)}
    return load | {key: share * v for key, v in sizes.items()}
