"""The memory that a computation may take, to which each is held before it begins.

Each says how much it needs, as a function of the number of links; what is too much is refused in a
line instead of minutes later, by the system.
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


def limit() -> float:
    """Bytes that a computation may take: half of what the machine, the container or the job has, or
    the gigabytes of RODGEN_MEMORY. Raises InputError where that is no number."""
    given = os.environ.get(SET)
    if given:
        with suppress(ValueError):
            if 0 < float(given) < math.inf:
                return 1e9 * float(given)
        raise InputError(SET, given, "a number of gigabytes")
    return SHARE * min(_found(), default=UNKNOWN)


def _found() -> list[float]:
    """What each who limits it allows [bytes]."""
    found = []
    with suppress(AttributeError, ValueError, OSError):  # of other systems
        found.append(float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")))
    for file in _group_files():
        with suppress(OSError, ValueError):  # "max" is none
            found.append(float(file.read_text()))
    if sys.platform != "win32":
        import resource

        soft = resource.getrlimit(resource.RLIMIT_AS)[0]
        found += [float(soft)] * (soft != resource.RLIM_INFINITY)
    return found


def _group_files() -> list[Path]:
    """Files that may have a limit of the control groups that this process is in (version 1 and 2),
    and of those around them."""
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
    """Raise InputError, with how many links there may be, for a computation whose need [bytes] with
    so many is more than may be taken.

    what: the computation, in words; need: of a number of links, the more the more; field: that the
    message names.
    """
    if is_small(need(links)) or need(links) <= (have := limit()):
        return
    most, beyond = 0, links
    while beyond - most > 1:
        middle = (most + beyond) // 2
        most, beyond = (middle, beyond) if need(middle) <= have else (most, middle)
    allowed = f"at most {most}: for {what} some {gigabytes(need(links))} of memory are needed with"
    raise InputError(field, links, f"{allowed} {links}, of {gigabytes(have)} here ({SET})")


def is_small(count: float) -> bool:
    """Whether so many bytes are there anyway, unless RODGEN_MEMORY says otherwise."""
    return count <= SMALL and SET not in os.environ


def gigabytes(count: float) -> str:
    """So many bytes, in words."""
    return f"{count / 1e9:.3g} GB" if count < 1e11 else f"{count / 1e9:.0f} GB"
