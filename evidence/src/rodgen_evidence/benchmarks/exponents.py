"""Times of Lyapunov exponents beside the run itself, and of tangents beside heyoka's.

python -m rodgen_evidence.benchmarks.exponents

The first exponent of a chain of 20 links over 1000 s against its run; a double pendulum with all
four tangents, orthonormal every second, against heyoka's variational equations of the same
pendulum, where that is installed (the extra `peers` of this package).
"""

from __future__ import annotations

import time
from importlib.util import find_spec

import numpy as np

import rodgen
from rodgen.integrate.variations import PARTS, Variations
from rodgen_evidence.benchmarks import Times
from rodgen_evidence.benchmarks.many import best
from rodgen_evidence.report.costs.cost_rows import Array

G, ANGLES, TOLERANCE = 9.81, (1.5, 0.5), 1e-12


def chain(links: int, span: float, rtol: float) -> rodgen.Scene:
    """A chain of links of 0.1 m and 0.1 kg, or two of 1 m and 1 kg, let go from a pin."""
    each = 1.0 if links == 2 else 0.1
    rod = {"links": links, "length": each * links, "bending_stiffness": 0.0, "mass": each * links}
    return rodgen.Scene.from_dict(
        {
            "name": "chain",
            "rod": {**rod, "boundary": "pinned"},
            "loads": {"gravity": {"g": G}},
            "initial": {"phi": list(ANGLES) if links == 2 else 0.0},
            "integrate": {
                "method": "dop853",
                "span": [0.0, span],
                "rtol": rtol,
                "atol": 0.01 * rtol,
                "output_every": span / 10,
            },
        }
    )


def of_rodgen(span: int) -> Array:
    """Sums of logarithms (4,) of a double pendulum, orthonormal every second."""
    on = Variations.of(chain(2, float(span), TOLERANCE))
    total = np.zeros(4)
    for second in range(span):
        on.advance_to(second + 1.0)
        q, r = np.linalg.qr(on.tangents.T)
        total += np.log(np.abs(np.diag(r)))
        on.tangents = q.T
    return total


def of_heyoka(span: int) -> tuple[float, Array]:
    """Processor time [s] and these sums by heyoka, whose compilation does not count."""
    import heyoka as hy

    a, b, v, w = hy.make_vars("a", "b", "v", "w")
    c, s = hy.cos(a - b), hy.sin(a - b)
    one = -0.5 * s * w * w - 1.5 * G * hy.cos(a)
    two = 0.5 * s * v * v - 0.5 * G * hy.cos(b)
    det = 4 / 9 - c * c / 4
    first, second = (one / 3 - 0.5 * c * two) / det, (4 / 3 * two - 0.5 * c * one) / det
    equations = [(a, v), (b, w), (v, first), (w, second)]
    varied = hy.var_ode_sys(equations, hy.var_args.vars, order=1)
    taylor = hy.taylor_adaptive(varied, [*ANGLES, 0.0, 0.0], tol=TOLERANCE)
    begun = time.process_time()
    total, frame = np.zeros(4), np.eye(4)
    for at in range(span):
        taylor.propagate_until(at + 1.0)
        frame, r = np.linalg.qr(taylor.state[4:].reshape(4, 4) @ frame)
        total += np.log(np.abs(np.diag(r)))
        taylor.state[4:] = np.eye(4).ravel()
    return time.process_time() - begun, total


def exponents(links: int = 20, span: float = 1000.0, rounds: int = 3) -> Times:
    """A row for the first exponent of a chain, and one for the double pendulum."""
    times = Times("Lyapunov exponents")
    scene = chain(links, span, 1e-6)
    model = rodgen.build(scene, "c", parts=(*PARTS, "flow", "power"))
    run = best(
        rounds, lambda: rodgen.simulate(scene, model=model, progress=False), time.process_time
    )
    first = best(
        rounds,
        lambda: rodgen.lyapunov_exponents(scene, count=1, model=model),
        time.process_time,
    )
    times.add(f"first exponent, n={links}, {span:g} s", first, "the run", run)
    if find_spec("heyoka"):
        seconds = max(2, int(2 * span))
        ours = best(rounds, lambda: of_rodgen(seconds), time.process_time)
        theirs = min(of_heyoka(seconds)[0] for _ in range(rounds))
        times.add(f"double pendulum, 4 tangents, {seconds} s", ours, "heyoka", theirs)
    else:
        print("heyoka is not installed: no peer")
    return times


if __name__ == "__main__":
    exponents().show()
