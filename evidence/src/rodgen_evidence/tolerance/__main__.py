"""Errors of runs over their tolerances on random scenes, and what methods cost at equal error.

python -m rodgen_evidence.tolerance [--scenes 300] [--first 0] [--out results]

Every method with error control at rtol 1e-4 to 1e-10, against two families of methods at their
tightest. A scene takes some five seconds of processor time, the first of each structure twenty
more. What is finished stands in tolerance.jsonl, and is not done again while neither rodgen nor
what is measured changes.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from rich.console import Console
from rich.progress import track

from rodgen_evidence.tolerance.error_tables import show_errors
from rodgen_evidence.tolerance.records import records
from rodgen_evidence.tolerance.rule_tables import show_costs

ALLOWED = 0.01  # of the scenes
WIDTH = 200  # characters of the tables in a file


def main() -> int:
    """Measure the scenes that are asked for; 1 if too many runs of auto are off."""
    parser = argparse.ArgumentParser(prog="python -m rodgen_evidence.tolerance")
    parser.add_argument("--scenes", type=int, default=300, help="how many")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--out", type=Path, default=Path("results"), help="folder of the results")
    asked = parser.parse_args()
    numbers = range(asked.first, asked.first + asked.scenes)
    console = Console() if sys.stdout.isatty() else Console(width=WIDTH)
    lines = list(track(records(numbers, asked.out), "scenes", total=asked.scenes))
    wrong, far = show_errors(lines, console)
    show_costs(lines, console)
    seconds = sum(line["seconds"] for line in lines)
    console.print(f"{len(lines)} scenes took {seconds:.0f} s")
    return int(wrong > ALLOWED * len(lines) or far > 0)


if __name__ == "__main__":
    sys.exit(main())
