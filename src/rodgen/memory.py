"""Memory limit of computations, checked before they begin.

Each states its need as a function of the number of links. One that needs too much is refused at
once, instead of being killed by the system minutes later.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from rodgen.errors import InputError

SET = "RODGEN_MEMORY"  # bytes that may be taken [GB], instead of what is found
SHARE = 0.5  # of what there is
SMALL = 2e7  # bytes that are there anyway
UNKNOWN = 4e9  # bytes that a machine has which does not say
GROUPS, OWN_GROUPS = Path("/sys/fs/cgroup"), Path("/proc/self/cgroup")  # of containers and jobs
Need = Callable[[int], float]


def memory_limit() -> float:
    """Memory that a computation may take [bytes]: half of what the machine, the container or the
    job has, or the gigabytes of RODGEN_MEMORY. Raises InputError where that is no number."""
    given = os.environ.get(SET)
    if given:
        with suppress(ValueError):
            if 0 < float(given) < math.inf:
                return 1e9 * float(given)
        raise InputError(SET, given, "a number of gigabytes")
    return SHARE * min(_system_limits(), default=UNKNOWN)


def _system_limits() -> list[float]:
    """Memory limits of the machine, the control groups and the process [bytes]."""
    found = []
    with suppress(AttributeError, ValueError, OSError):  # of other systems
        found.append(float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")))
    for file in _cgroup_files():
        with suppress(OSError, ValueError):  # "max" is none
            found.append(float(file.read_text()))
    if sys.platform != "win32":
        import resource

        soft = resource.getrlimit(resource.RLIMIT_AS)[0]
        found += [float(soft)] * (soft != resource.RLIM_INFINITY)
    return found


def _cgroup_files() -> list[Path]:
    """Files with memory limits of the control groups (version 1 and 2) around this process."""
    found = [GROUPS / "memory.max"]
    with suppress(OSError, ValueError):
        for line in OWN_GROUPS.read_text().splitlines():
            _, kinds, place = line.split(":", 2)
            old = "memory" in kinds.split(",")
            if kinds and not old:
                continue
            root = GROUPS / "memory" if old else GROUPS
            name = "memory.limit_in_bytes" if old else "memory.max"
            inner = root / place.strip("/")
            around = (one for one in (inner, *inner.parents) if one.is_relative_to(root))
            found += [folder / name for folder in around]
    return found


def check_memory(what: str, links: int, need: Need, field: str = "rod.links") -> None:
    """Raise InputError for a computation that needs more memory [bytes] than it may take; the
    message says how many links fit.

    what: the computation, in words; need: a function of the number of links, increasing; field:
    what the message names.
    """
    if is_small(need(links)) or need(links) <= (have := memory_limit()):
        return
    most, beyond = 0, links
    while beyond - most > 1:
        middle = (most + beyond) // 2
        most, beyond = (middle, beyond) if need(middle) <= have else (most, middle)
    allowed = (
        f"at most {most}: for {what} some {format_gigabytes(need(links))} of memory are needed with"
    )
    raise InputError(field, links, f"{allowed} {links}, of {format_gigabytes(have)} here ({SET})")


def is_small(count: float) -> bool:
    """Whether this many bytes need no check: at most SMALL, and RODGEN_MEMORY is not set."""
    return count <= SMALL and SET not in os.environ


def format_gigabytes(count: float) -> str:
    """Text of a number of bytes, in GB."""
    return f"{count / 1e9:.3g} GB" if count < 1e11 else f"{count / 1e9:.0f} GB"
