"""Remake the reference solutions of data/: python benchmarks/references.py [JOB ...]

Each comes from a method that no contestant is of, and its error is estimated by the difference to
a solution of another family. Needs rodgen[bench] with heyoka and scikit-sundae; some ten minutes.
"""

from __future__ import annotations

import ctypes
import json
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import native
import numpy as np
from integrate_jobs import BEAM, DAMPED, DATA, JOBS, R50, R200, Job
from problem import Vector

HERE = Path(__file__).parent
PUBLISHED = HERE.parent / "tests" / "physics" / "ivp_beam_t5.json"
VALUES = ("mass", "length", "bending_stiffness", "follower_force")


def extrapolated(job: Job, columns: int, steps: int) -> Vector:
    """By extrapolation.c: the order is twice the columns."""
    text = (HERE / "extrapolation.c").read_text(encoding="utf-8")
    flags = ("-O2", f"-DN={job.scene.rod.links}", f"-DK={columns}")
    run = native.compiled({"extrapolation.c": text}, "extrapolated", flags).function
    given, y = job.scene.parameters, job.start.copy()
    p = np.array([*(given[name] for name in VALUES), given.get("internal_damping", 0.0)])
    arrays = (native._pointer(a) for a in (y, p, np.array([float(steps)])))
    run(ctypes.c_double(job.span[1]), *arrays)
    return y


def by(file: str, make: str, job: Job, *settings: object, **named: object) -> Vector:
    """By one setting of a contestant."""
    contestant = getattr(import_module(f"peers.runs.{file}"), make)(job, *settings, **named)
    y: Vector = contestant.integrate().y
    return y


def published(job: Job) -> Vector:
    """The solution printed in the test set: 16 digits, angles then rates."""
    return np.array(json.loads(PUBLISHED.read_text(encoding="utf-8"))["y"])


Way = tuple[str, Callable[[Job], Vector]]
MIDPOINT = "midpoint rule extrapolated to order {}, {} equal steps, 80-bit numbers"
WAYS: dict[Job, tuple[Way, Way]] = {
    R50: (
        (MIDPOINT.format(20, 10_000), lambda job: extrapolated(job, 10, 10_000)),
        (
            "heyoka, Taylor series, tolerance 1e-16",
            lambda job: by("taylor", "contestant", job, 1e-16, compact_mode=True),
        ),
    ),
    R200: (
        (MIDPOINT.format(16, 110_000), lambda job: extrapolated(job, 8, 110_000)),
        (
            "SciPy DOP853, rtol 1e-12, atol 1e-13",
            lambda job: by("scipy_methods", "with_solve_ivp", job, "DOP853", 1e-12, 1e-13),
        ),
    ),
    DAMPED: (
        (
            "CVODE BDF, rtol 1e-11, atol 1e-12",
            lambda job: by("sundials", "contestant", job, "BDF", 1e-11, 1e-12),
        ),
        (
            "SciPy Radau, rtol 1e-9, atol 1e-11",
            lambda job: by("scipy_methods", "with_solve_ivp", job, "Radau", 1e-9, 1e-11),
        ),
    ),
    BEAM: (
        (
            "problem Beam, Test Set for IVP Solvers (Bari), revision 1.2 of 2006: RADAU, "
            "rtol = atol = 1.1e-18, as printed there",
            published,
        ),
        (
            "SciPy DOP853, rtol 1e-13, atol 1e-15",
            lambda job: by("scipy_methods", "with_solve_ivp", job, "DOP853", 1e-13, 1e-15),
        ),
    ),
}


def make(job: Job) -> None:
    """Write the file of a job."""
    (source, first), (check, second) = WAYS[job]
    start = time.perf_counter()
    phi, other = job.phi(first(job)), job.phi(second(job))
    estimate = float(np.abs(phi - other).max())
    content = {
        "job": job.name,
        "what": f"angles of the moving links [rad] at t = {job.span[1]:g} s",
        "source": source,
        "checked_by": check,
        "error_estimate": float(f"{estimate:.1e}"),
        "error_estimate_is": "largest difference of an angle between the two",
        "largest_angle": float(np.abs(phi).max()),
        "phi": phi.tolist(),
    }
    DATA.mkdir(exist_ok=True)
    text = json.dumps(content, indent=0)
    (DATA / f"{job.name}.json").write_text(text + "\n", encoding="utf-8")
    print(f"{job.name}: off by {estimate:.1e}; {time.perf_counter() - start:.0f} s", flush=True)


if __name__ == "__main__":
    chosen = sys.argv[1:] or [job.name for job in JOBS]
    for job in JOBS:
        if job.name in chosen:
            make(job)
