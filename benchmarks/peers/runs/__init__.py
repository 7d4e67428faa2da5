"""What a user would integrate a whole motion with instead, as families of settings.

Every file offers functions (job, error asked for) -> settings from loose to tight.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from importlib import import_module
from typing import Any

from integrate_jobs import Job
from our_runs import SHARES
from work_precision import Contestant, Family

PEERS = {
    "MuJoCo Euler": ("mujoco_steps", "euler"),
    "MuJoCo RK4": ("mujoco_steps", "rk4"),
    "SciPy DOP853": ("scipy_methods", "dop853"),
    "SciPy Radau": ("scipy_methods", "radau"),
    "SciPy BDF": ("scipy_methods", "bdf"),
    "SciPy LSODA": ("scipy_methods", "lsoda"),
    "CVODE Adams": ("sundials", "adams"),
    "CVODE BDF": ("sundials", "bdf"),
    "heyoka": ("taylor", "unrolled"),
    "heyoka, compact": ("taylor", "compact"),
}
SCIPY = tuple(name for name in PEERS if name.startswith("SciPy"))
# How many times the error asked for a peer may have: heyoka's tolerances are few.
GRACE = {"heyoka": 1.5, "heyoka, compact": 1.5}
TWO_TOLERANCES = (*SCIPY, "CVODE Adams", "CVODE BDF")


def families(names: Iterable[str], job: Job, asked: float) -> dict[str, Family]:
    """The settings of peers; what they need is imported when the first is come to."""
    found: dict[str, Family] = {}
    for name in names:
        if name in TWO_TOLERANCES:
            for share in SHARES:
                found[f"{name}, atol {share:g} rtol"] = _family(name, job, asked, share)
        else:
            found[name] = _family(name, job, asked)
    return found


def _family(name: str, *arguments: Any) -> Iterator[Contestant]:
    file, function = PEERS[name]
    yield from getattr(import_module(f"peers.runs.{file}"), function)(*arguments)
