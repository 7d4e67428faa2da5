"""Times of the main job, each beside a yardstick measured in the same run.

    python benchmarks/main_job.py

Medians of several runs; the ratio is what to quote, the machine's speed drifts.
"""

from __future__ import annotations

import os
import platform
import statistics
import subprocess
import sys
import tempfile
import timeit
from importlib.metadata import version

from rich.console import Console
from rich.table import Table

RODGEN = [sys.executable, "-c", "from rodgen.cli import main; main()"]


def process(command: list[str], runs: int, **env: str) -> float:
    """Median wall time of a whole process [s]."""

    def once() -> None:
        subprocess.run(command, check=True, capture_output=True, env={**os.environ, **env})

    return statistics.median(timeit.repeat(once, number=1, repeat=runs))


def imports(table: Table) -> None:
    numpy = process([sys.executable, "-c", "import numpy"], 7)
    both = process([sys.executable, "-c", "import numpy, rodgen"], 7)
    row(table, "import rodgen, beyond NumPy", both - numpy, "import numpy", numpy)


PLAIN = """
from rodgen.derive.explicit import ExplicitDerivation
from sympy.physics.mechanics import LagrangesMethod
d = ExplicitDerivation(8)
lagrangian = d.calculus.expr(d.kinetic_energy - d.spring_energy)
method = LagrangesMethod(lagrangian, d.coordinates)
method.form_lagranges_equations()
"""
POLYNOMIAL = """
from rodgen.derive.explicit import ExplicitDerivation
ExplicitDerivation(8).lagranges_method
"""
ANY_N = """
from rodgen.derive.proof_any_n import prove_any_n
list(prove_any_n("free", "uniform"))
"""


def derivations(table: Table) -> None:
    plain = process([sys.executable, "-c", PLAIN], 3)
    ours = process([sys.executable, "-c", POLYNOMIAL], 3)
    row(table, "LagrangesMethod on polynomials, n=8", ours, "on expressions", plain)
    sympy = process([sys.executable, "-c", "import sympy"], 3)
    row(table, "proof for any n", process([sys.executable, "-c", ANY_N], 3), "import sympy", sympy)
    for links, runs in ((20, 3), (50, 1)):
        with tempfile.TemporaryDirectory() as folder:
            command = [*RODGEN, "derive", str(links), "--out", folder]
            cold = [
                process(command, 1, RODGEN_CACHE=os.path.join(folder, str(run)))
                for run in range(runs)
            ]
            kept = process(command, 3, RODGEN_CACHE=os.path.join(folder, "0"))
        row(table, f"derive N={links}, cold", statistics.median(cold), "unchanged", kept)


def row(table: Table, what: str, time: float, yardstick: str, other: float) -> None:
    table.add_row(what, _shown(time), yardstick, _shown(other), f"{time / other:.2f}")


def _shown(seconds: float) -> str:
    return f"{seconds:.2f} s" if seconds > 0.1 else f"{seconds * 1e6:.1f} us"


def main() -> None:
    table = Table(title="main job")
    for column in ("what", "time", "yardstick", "its time", "ratio"):
        table.add_column(column, justify="left" if column in ("what", "yardstick") else "right")
    imports(table)
    derivations(table)
    console = Console()
    console.print(table)
    versions = ", ".join(f"{p} {version(p)}" for p in ("rodgen", "sympy", "numpy", "scipy"))
    console.print(f"Python {platform.python_version()}, {versions}; {os.cpu_count()} cores")


if __name__ == "__main__":
    main()
