"""Verdicts of stability on random scenes, against eigenvalues in 50-digit arithmetic.

python -m rodgen_evidence.verdicts [--scenes 200] [--first 0] [--out results]

`critical_load`, `static_equilibrium`, `natural_modes` and `continue_equilibria` of every scene, at
20 loads each. A scene takes five seconds. What is finished stands in verdicts.jsonl, and is not
done again while neither rodgen nor this package changes.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from rich.progress import track

from rodgen_evidence.verdicts.campaign import campaign, show


def main() -> int:
    """Judge the scenes that are asked for; 1 if a verdict is wrong."""
    parser = argparse.ArgumentParser(prog="python -m rodgen_evidence.verdicts")
    parser.add_argument("--scenes", type=int, default=200, help="how many")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--out", type=Path, default=Path("results"), help="folder of the results")
    asked = parser.parse_args()
    lines = campaign(range(asked.first, asked.first + asked.scenes), asked.out)
    return int(show(list(track(lines, "scenes", total=asked.scenes))) > 0)


if __name__ == "__main__":
    sys.exit(main())
