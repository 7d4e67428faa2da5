"""The rod whose costs are measured, and rows of a table of costs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rodgen
from rodgen.judge.timing import Batch, interleaved
from rodgen.judge.unit import Row

Array = NDArray[np.float64]

VALUES = {
    "mass": 50.0,
    "length": 5.0,
    "bending_stiffness": 100.0,
    "follower_force": 300.0,
    "follower_angle": 0.1,
    "gravity": 9.81,
    "internal_damping": 5.0,
    "external_damping": 0.5,
}
THRUST, DAMPED = ("follower",), ("follower", "internal_damping")
BATCH, FEW, SLOW = 0.005, 5, 0.02  # seconds of a batch; rounds where a call takes so long
ROUNDS, QUICK_ROUNDS = 15, 5
LETTERS = 200  # of a reason


def built(links: int, terms: tuple[str, ...], target: str = "c", form: str = "chain") -> ModuleType:
    """The module of a free uniform rod."""
    return rodgen.build(rodgen.Structure(links, terms=terms), target, form)


def packed(module: ModuleType) -> Array:
    """Those of VALUES that a module has."""
    names = {name: value for name, value in VALUES.items() if name in module.PARAMETERS}
    p: Array = module.parameters(**names)
    return p


def state(links: int) -> Array:
    """A random state near to straight."""
    draw = np.random.default_rng(1)
    return 0.1 * draw.standard_normal(2 * (links + 2))


def scene(links: int, damping: float = 0.0, **integrate: Any) -> rodgen.Scene:
    """The rod slightly bent under thrust."""
    loads: dict[str, Any] = {"follower": {"force": VALUES["follower_force"]}}
    if damping:
        loads["internal_damping"] = {"coefficient": damping}
    return rodgen.Scene.from_dict(
        {
            "name": f"rod_n{links}",
            "rod": {
                "links": links,
                "length": VALUES["length"],
                "mass": VALUES["mass"],
                "bending_stiffness": VALUES["bending_stiffness"],
            },
            "loads": loads,
            "initial": {"phi": "0.01*cos(pi*s)"},
            "integrate": integrate,
        }
    )


def row(what: str, who: str, links: int, seconds: float | None = None, **more: Any) -> Row:
    """A cost, or why there is none."""
    empty: Row = {"rounds": None, "setup": None, "failed": ""}
    return {"what": what, "who": who, "n": links, "seconds": seconds, **empty, **more}


def why(error: BaseException) -> str:
    """A failure in one line."""
    return " ".join(str(error).split())[:LETTERS] or repr(error)


def compared(
    what: str, links: int, contestants: Mapping[str, Callable[[], Batch]], quick: bool
) -> list[Row]:
    """Seconds per call of all; each is made first, and one that cannot be is a row that failed."""
    batches: dict[str, Batch] = {}
    rows: list[Row] = []
    for name, make in contestants.items():
        try:
            batches[name] = make()
            batches[name](1)
        except Exception as error:  # another's library may fail in any way
            batches.pop(name, None)
            rows.append(row(what, name, links, failed=why(error)))
    if not batches:
        return rows
    rounds = _rounds(batches, quick)
    times = interleaved(batches, rounds, BATCH)
    return [row(what, who, links, times.median(who), rounds=rounds) for who in batches] + rows


def _rounds(batches: Mapping[str, Batch], quick: bool) -> int:
    slowest = max(batch(1) for batch in batches.values())
    return FEW if slowest > SLOW or quick else ROUNDS
