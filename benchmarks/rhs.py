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
from functools import partial
from importlib.metadata import PackageNotFoundError, version

import costs
import exact
import native
import numpy as np
from against_peers import against_peers
from problem import ALL, FOLLOWER, built, disagreement, packed, state
from report import MISSING, Report
from rich.console import Console
from timing import calls, interleaved

LOADS = ((FOLLOWER, "follower"), (ALL, "all loads"))
RATIO = 0.65  # to the yardstick
VERSIONS = (
    *("rodgen", "sympy", "numpy", "scipy", "cffi"),
    *("numba", "casadi", "pin", "mujoco", "pydy", "cython"),
)


def in_c(report: Report) -> None:
    """The C target in a C loop, against the plain elimination, and its growth."""
    for links in (50, 200, 1000):
        what = f"C in a C loop, follower, n={links}"
        module = report.module(what, built, links, target="c")
        if module is None:
            continue
        ours, plain = native.of_module(module), native.yardstick(links, native.flags_of(module))
        y, p = state(links), packed(module)
        off = disagreement(ours(y, p), plain(y, p))
        if not off < 1e-9:
            report.note(what, "-", verdict=f"NOT: differs from the yardstick by {off:.1e}")
            continue
        times = interleaved({"ours": ours.batch(y, p), "plain": plain.batch(y, p)})
        ratio = times.ratio("ours", "plain")
        shown = f"{times.median('ours') * 1e6:.2f} us, {ratio:.2f} of"
        asked = f"{RATIO} of the yardstick's {times.median('plain') * 1e6:.2f} us"
        report.row(what, ratio, RATIO, f"{shown} the yardstick", asked)
    growth(report)


def growth(report: Report) -> None:
    """From n=2000 to n=20000."""
    what, batches = "C in a C loop, growth, n=20000 over n=2000", {}
    for links in (2000, 20000):
        module = report.module(what, built, links, target="c")
        if module is None:
            return
        batches[str(links)] = native.of_module(module).batch(state(links), packed(module))
    ratio = interleaved(batches, rounds=21, seconds=0.02).ratio("20000", "2000")
    report.row(what, ratio, 11.0, f"{ratio:.2f} times", "at most 11 times")


def from_python(report: Report) -> None:
    """What a caller in Python sees."""
    for terms, loads in LOADS:
        module = report.module(f"C from Python, {loads}", built, 20, terms, "c")
        if module is not None:
            y, p = state(20), packed(module)
            out = np.empty_like(y)
            times = interleaved(
                {
                    "new": calls(partial(module.rhs, 0.0, y, p)),
                    "out": calls(partial(module.rhs, 0.0, y, p, out)),
                }
            )
            report.time(f"C from Python, {loads}, n=20, rhs(t, y, p)", times.median("new"), 2e-6)
            report.time("the same, rhs(t, y, p, out)", times.median("out"), 1e-6)
    for links, limit in ((50, 60e-6), (1000, 250e-6)):
        for terms, loads in LOADS:
            what = f"NumPy target, {loads}, n={links}"
            module = report.module(what, built, links, terms)
            if module is not None:
                y, p = state(links), packed(module)
                batch = calls(partial(module.rhs, 0.0, y, p))
                report.time(what, interleaved({"rhs": batch}).median("rhs"), limit)
    for terms, loads in LOADS:
        several(report, terms, loads)


def several(report: Report, terms: tuple[str, ...], loads: str, links: int = 50) -> None:
    """Many states in one call."""
    count, what = 256, f"rhs_batch, C, {loads}, n={links}, a state"
    module = report.module(what, built, links, terms, "c")
    if module is None:
        return
    Y = np.array([state(links, seed=seed) for seed in range(count)])
    P, out = np.tile(packed(module), (count, 1)), np.empty_like(Y)
    module.rhs_batch(0.0, Y, P, out)
    off = max(disagreement(out[i], module.rhs(0.0, Y[i], P[i])) for i in range(count))
    if not off < 1e-10:
        report.note(what, "-", verdict=f"NOT: differs from rhs by {off:.1e}")
        return
    batch = calls(partial(module.rhs_batch, 0.0, Y, P, out))
    report.time(what, interleaved({"batch": batch}).median("batch") / count, 0.15e-6)


def accuracy(report: Report, links: int = 200) -> None:
    """Largest relative error of the accelerations against 50-digit arithmetic."""
    verified = exact.verified()
    report.note("50-digit O(n) against 50-digit dense form, n=20", f"{verified:.0e}")
    if not verified < 1e-40:
        raise ArithmeticError("the 50-digit reference is wrong")
    states = [
        state(links, spread, speed, seed)
        for spread, speed in ((1e-3, 1e-2), (0.1, 0.1), (3.0, 3.0))
        for seed in (1, 2, 3)
    ]
    for terms, loads in LOADS:
        truth = [exact.exact_rhs(links, terms, y) for y in states]
        dense = float("inf")
        for name, how in (  # the dense form first: the others are held against it
            ("dense NumPy", {"form": "dense"}),
            ("NumPy", {}),
            ("C", {"target": "c"}),
        ):
            what = f"error, {name}, {loads}, n={links}"
            module = report.module(what, built, links, terms, **how)
            if module is None:
                continue
            p = packed(module)
            off = max(
                exact.error(module.rhs(0.0, y, p), dy) for y, dy in zip(states, truth, strict=True)
            )
            if name == "dense NumPy":
                dense = off
                report.note(what, f"{off:.1e}")
            else:
                limit = min(dense, 1e-11)
                asked = f"at most dense's {dense:.1e} and 1e-11" if dense < np.inf else "1e-11"
                report.row(what, off, limit, f"{off:.1e}", asked)


def sizes(report: Report) -> None:
    """Set-up from cold, and memory."""
    costs.cold(report)
    costs.memory(report)


SECTIONS: dict[str, tuple[str, Callable[[Report], None]]] = {
    "c": ("in a C loop", in_c),
    "python": ("from Python", from_python),
    "accuracy": ("accuracy, random states", accuracy),
    "costs": ("set-up and memory", sizes),
}


def flags() -> str:
    """What the C target is compiled with, where it can be."""
    try:
        return " ".join(native.flags_of(built(20, target="c")))
    except MISSING:
        return "no C target"


def versions() -> str:
    """Of all that took part."""
    found = [f"Python {platform.python_version()}"]
    for name in VERSIONS:
        with suppress(PackageNotFoundError):
            found.append(f"{name} {version(name)}")
    return ", ".join(found)


def main() -> None:
    console, chosen = Console(), sys.argv[1:] or [*SECTIONS, "peers"]
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
    console.print(f"{versions()}; {os.cpu_count()} cores; C flags: {flags()}", highlight=False)


if __name__ == "__main__":
    main()
