"""The rod whose costs are measured, and rows of a table of costs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rodgen
from rodgen.analyse.precision.contestant import Measurement, describe_error
from rodgen_evidence.report import cases
from rodgen_evidence.report.interleaved_timing import Batch, time_in_turns

Array = NDArray[np.float64]

VALUES = {
    **cases.ROD,
    "follower_force": 300.0,
    "follower_angle": 0.1,
    "gravity": 9.81,
    "internal_damping": 5.0,
    "external_damping": 0.5,
}
THRUST, DAMPED = ("follower",), ("follower", "internal_damping")
BATCH, FEW, SLOW = 0.005, 5, 0.02  # seconds of a batch; rounds where a call takes so long
ROUNDS, QUICK_ROUNDS = 15, 5


def built(links: int, terms: tuple[str, ...], target: str = "c", form: str = "chain") -> ModuleType:
    """The module of a free uniform rod."""
    return rodgen.build(rodgen.Structure(links, terms=terms), target, form)


def parameter_vector(module: ModuleType) -> Array:
    """Parameters of a module, with the numbers of VALUES."""
    names = {name: value for name, value in VALUES.items() if name in module.PARAMETERS}
    p: Array = module.parameters(**names)
    return p


def state(links: int) -> Array:
    """A random state near to straight."""
    draw = np.random.default_rng(1)
    return 0.1 * draw.standard_normal(2 * (links + 2))


def scene(links: int, damping: float = 0.0, angle: float = 0.0, **integrate: Any) -> rodgen.Scene:
    """The rod slightly bent under thrust, at an angle to its tail."""
    loads: dict[str, Any] = {"follower": {"force": VALUES["follower_force"], "angle": angle}}
    if damping:
        loads["internal_damping"] = {"coefficient": damping}
    return rodgen.Scene.from_dict(
        cases.rod(f"rod_n{links}", links, 1.0, loads=loads) | {"integrate": integrate}
    )


def row(what: str, who: str, links: int, seconds: float | None = None, **more: Any) -> Measurement:
    """A cost, or why there is none."""
    empty: Measurement = {"rounds": None, "setup": None, "failed": ""}
    return {"what": what, "who": who, "n": links, "seconds": seconds, **empty, **more}


def compare_costs(
    what: str,
    links: int,
    contestants: Mapping[str, Callable[[], Batch]],
    quick: bool,
    most: int = ROUNDS,
) -> list[Measurement]:
    """Seconds per call of all, in rounds, of which there are fewer where a call is slow; each is
    made first, and one that cannot be is a row that failed."""
    batches: dict[str, Batch] = {}
    rows: list[Measurement] = []
    for name, make in contestants.items():
        try:
            batches[name] = make()
            batches[name](1)
        except Exception as error:  # another's library may fail in any way
            batches.pop(name, None)
            rows.append(row(what, name, links, failed=describe_error(error)))
    if not batches:
        return rows
    slow = max(batch(1) for batch in batches.values()) > SLOW
    rounds = min(most, FEW if slow or quick else ROUNDS)
    times = time_in_turns(batches, rounds, BATCH)
    return [row(what, who, links, times[who], rounds=rounds) for who in batches] + rows
