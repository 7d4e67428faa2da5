"""Times of deriving, each beside a yardstick measured in the same run.

python -m rodgen_evidence.benchmarks.main_job
"""

from __future__ import annotations

import os
import statistics
import sys
import tempfile
from collections.abc import Sequence

from rodgen_evidence.benchmarks import Times
from rodgen_evidence.report.interleaved_timing import process

RODGEN = [sys.executable, "-c", "from rodgen.cli import main; main()"]


def median(command: list[str], runs: int, **environment: str) -> float:
    """Median wall time of a whole process [s]."""
    return statistics.median(process(command, **environment) for _ in range(runs))


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
from rodgen.derive.proofs.any_n import prove_any_n
list(prove_any_n("free", "uniform"))
"""


def main_job(sizes: Sequence[tuple[int, int]] = ((20, 3), (50, 1)), runs: int = 3) -> Times:
    """Imports, derivations, and `rodgen derive` of so many links, so many times each."""
    times = Times("main job")
    numpy = median([sys.executable, "-c", "import numpy"], 2 * runs + 1)
    both = median([sys.executable, "-c", "import numpy, rodgen"], 2 * runs + 1)
    times.add("import rodgen, beyond NumPy", both - numpy, "import numpy", numpy)
    plain, ours, sympy, proof = (
        median([sys.executable, "-c", code], runs)
        for code in (PLAIN, POLYNOMIAL, "import sympy", ANY_N)
    )
    times.add("LagrangesMethod on polynomials, n=8", ours, "on expressions", plain)
    times.add("proof for any n", proof, "import sympy", sympy)
    for links, colds in sizes:
        with tempfile.TemporaryDirectory() as folder:
            command = [*RODGEN, "derive", str(links), "--out", folder]
            cold = [
                median(command, 1, RODGEN_CACHE=os.path.join(folder, str(run)))
                for run in range(colds)
            ]
            kept = median(command, runs, RODGEN_CACHE=os.path.join(folder, "0"))
        times.add(f"derive N={links}, cold", statistics.median(cold), "unchanged", kept)
    return times


if __name__ == "__main__":
    main_job().show()
