"""Speed, accuracy and size of the right-hand side, beside what is asked and what others offer.

    python benchmarks/rhs.py [c] [python] [accuracy] [costs] [peers]

Medians of batches that take turns. The yardstick is the plain elimination of yardstick.c, compiled
with the flags of the C target. Peers that are not installed are skipped: pip install rodgen[bench].
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version

import costs
from accuracy import accuracy
from against_peers import against_peers
from from_python import from_python
from in_c import in_c
from report import Report
from rich.console import Console

from rodgen.judge.surroundings import flags

SECTIONS: dict[str, tuple[str, Callable[[Report], None]]] = {
    "c": ("C in a C loop", in_c),
    "python": ("from Python", from_python),
    "accuracy": ("accuracy: largest error of accelerations, random states", accuracy),
    "costs": ("set-up and memory", costs.costs),
}
VERSIONS = (
    *("rodgen", "sympy", "numpy", "scipy", "cffi"),
    *("numba", "casadi", "pin", "mujoco", "pydy", "cython", "heyoka", "scikit-sundae"),
)


def machine() -> str:
    """All that took part, and how busy the machine was otherwise."""
    found = [f"Python {platform.python_version()}"]
    for name in VERSIONS:
        with suppress(PackageNotFoundError):
            found.append(f"{name} {version(name)}")
    with suppress(OSError, AttributeError):
        found.append(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    return ", ".join(found)


def main() -> None:
    console = Console(width=None if sys.stdout.isatty() else 140)  # else tables fold at 80
    chosen = sys.argv[1:] or [*SECTIONS, "peers"]
    for name in chosen:
        if name == "peers":
            console.print(against_peers(console))
        elif name in SECTIONS:
            title, measure = SECTIONS[name]
            report = Report(title)
            measure(report)
            console.print(report.table)
        else:
            sys.exit(f"{name}: one of {', '.join([*SECTIONS, 'peers'])}")
    console.print(f"{machine()}; C flags: {flags()}", highlight=False)


if __name__ == "__main__":
    main()
