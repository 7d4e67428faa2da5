"""What a module costs besides its calls: derivation from cold, and memory of one evaluation."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from problem import built, packed, state
from report import Report

HERE = Path(__file__).parent
RODGEN = "from rodgen.cli import main; main()"
# A module that has been written is loaded, which compiles it, and called once.
LOAD = """
import sys, pathlib, numpy, rodgen.loading
module = rodgen.loading.load_module(pathlib.Path(sys.argv[1]))
p = module.parameters(mass=1, length=1, bending_stiffness=1, follower_force=1,
                      internal_damping=1, external_damping=1)
assert numpy.isfinite(module.rhs(0.0, numpy.ones(len(module.STATE)), p)).all()
"""
PEAK = "import sys, costs; print(costs.peak(sys.argv[1], int(sys.argv[2])))"


def costs(report: Report) -> None:
    """Set-up from cold, and memory."""
    cold(report)
    memory(report)


def cold(report: Report, links: int = 1000) -> None:
    """Derive, emit and compile with an empty cache, in processes of their own."""
    what = f"derive, emit, compile, load, cold, n={links}, all loads, C"
    with tempfile.TemporaryDirectory() as folder:
        out, env = Path(folder, "out"), {"RODGEN_CACHE": str(Path(folder, "cache"))}
        try:
            arguments = ["derive", str(links), "--target", "c", "--out", str(out)]
            written, _ = process(RODGEN, arguments, **env)
            module = next(out.glob("rod_*.py"))
            compiled, _ = process(LOAD, [str(module)], **env)
        except (RuntimeError, StopIteration) as error:
            report.note(what, "-", "at most 15 s", f"cannot be had: {error}")
            return
    report.time(what, written + compiled, 15.0)
    report.note("", f"{written:.1f} s + {compiled:.1f} s", verdict="derived and written + compiled")


def memory(report: Report, links: int = 100_000) -> None:
    """Peak memory of one evaluation, and its growth from a tenth of the links."""
    for target in ("c", "numpy"):
        what = f"memory of one evaluation, {target}, n={links}"
        try:
            few, many = (int(process(PEAK, [target, str(n)])[1]) for n in (links // 10, links))
        except RuntimeError as error:
            report.note(what, "-", "works, O(n)", f"cannot be had: {error}")
            continue
        shown = f"{many / 2**20:.1f} MiB, {many / links:.0f} bytes a link"
        report.row(what, many, 20.0 * few, shown, "O(n): at most 20 times n/10's")


def peak(target: str, links: int) -> int:
    """Bytes by which resident memory rises in one evaluation, the result included."""
    for n in (100, links):  # the first one for what is imported or set up once
        module = built(n, target=target)
        y, p = state(n), packed(module)
        before = _reset_peak()
        module.rhs(0.0, y, p)
        rise = _peak() - before
    return max(rise, y.nbytes)  # memory that was free already is not seen


def _reset_peak() -> int:
    """Current memory, from which the peak counts again where the system can do that."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")
    return _peak()


def _peak() -> int:
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
        return 1024 * int(next(line for line in lines if line.startswith("VmHWM")).split()[1])
    except (OSError, StopIteration):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def process(code: str, arguments: list[str], **env: str) -> tuple[float, str]:
    """Wall time and output of a Python process; RuntimeError with its error if it fails."""
    start = time.perf_counter()
    made = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        env={
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")]),
            "COLUMNS": "200",
            **env,
        },
    )
    if made.returncode:
        told = made.stderr.rpartition("Traceback")[2].splitlines()  # all of it where there is none
        lines = [line for line in told if line.strip() and not line.startswith(" ")]
        raise RuntimeError(lines[0] if lines else f"exit status {made.returncode}")
    return time.perf_counter() - start, made.stdout
