"""What a caller in Python sees: calls of one state, of many, and Jacobians."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from problem import LOADS, Vector, built, disagreement, packed, state
from report import Report, duration

from rodgen.judge.timing import calls, interleaved

Matrix = NDArray[np.float64]


def from_python(report: Report) -> None:
    """Both targets."""
    for terms, loads in LOADS:
        _c(report, terms, loads)
    for links, limit in ((50, 60e-6), (1000, 250e-6)):
        for terms, loads in LOADS:
            what = f"NumPy, {loads}, n={links}, rhs(t, y, p)"
            module, y = built(links, terms), state(links)
            batch = calls(partial(module.rhs, 0.0, y, packed(module)))
            report.time(what, interleaved({"rhs": batch}).median("rhs"), limit)
    for terms, loads in LOADS:
        _several(report, 50, terms, f"C, {loads}, n=50, rhs_batch, a state", 0.15e-6)
    for kind in (("free", "uniform"), ("clamped", "lumped")):
        for terms, loads in LOADS:
            if kind[0] != "free":
                what = f"C, {', '.join(kind)}, {loads}, n=50, rhs_batch, a state"
                _several(report, 50, terms, what, None, kind)
    _several(report, 1000, LOADS[0][0], "C, follower, n=1000, rhs_batch, a state", None)
    for links in (50, 200):
        for target in ("c", "numpy"):
            _jacobian(report, links, target)


def _c(report: Report, terms: tuple[str, ...], loads: str, links: int = 20) -> None:
    what = f"C, {loads}, n={links}, rhs(t, y, p)"
    module = report.module(what, built, links, terms, "c")
    if module is None:
        return
    y, p = state(links), packed(module)
    out = np.empty_like(y)
    times = interleaved(
        {
            "new": calls(partial(module.rhs, 0.0, y, p)),
            "out": calls(partial(module.rhs, 0.0, y, p, out)),
        }
    )
    report.time(what, times.median("new"), 2e-6)
    report.time("the same, rhs(t, y, p, out)", times.median("out"), 1e-6)


def _several(
    report: Report,
    links: int,
    terms: tuple[str, ...],
    what: str,
    limit: float | None,
    kind: tuple[str, str] = ("free", "uniform"),
) -> None:
    """Many states, each with its own parameters, in one call."""
    count, base = 256, 2 if kind[0] == "free" else 0
    module = report.module(what, built, links, terms, "c", kind=kind)
    if module is None:
        return
    Y = np.array([state(links, seed=seed, base=base) for seed in range(count)])
    P = np.tile(packed(module), (count, 1)) * np.linspace(1.0, 1.1, count)[:, None]
    out = np.empty_like(Y)
    module.rhs_batch(0.0, Y, P, out)
    off = max(disagreement(out[i], module.rhs(0.0, Y[i], P[i])) for i in range(count))
    if report.agree(what, off, 1e-10, "rhs"):
        batch = calls(partial(module.rhs_batch, 0.0, Y, P, out))
        report.time(what, interleaved({"batch": batch}).median("batch") / count, limit)


def _jacobian(report: Report, links: int, target: str) -> None:
    """Beside differences of rhs, one call for every state."""
    what = f"{'C' if target == 'c' else 'NumPy'}, follower, n={links}, jac"
    module = report.module(what, built, links, target=target)
    if module is None:
        return
    y, p = state(links), packed(module)
    others = {"differences": partial(_differences, module, y, p)}
    if target == "c":
        others["differences by rhs_batch"] = partial(_batch_differences, module, y, p)
    exact = module.jac(0.0, y, p)
    for name, other in others.items():
        off = float(np.abs(exact - other()).max() / np.abs(exact).max())
        if not report.agree(what, off, 1e-5, name):
            return
    contestants: dict[str, Callable[[], object]] = {"jac": partial(module.jac, 0.0, y, p), **others}
    times = interleaved({name: calls(do) for name, do in contestants.items()}, rounds=15)
    report.note(what, duration(times.median("jac")))
    for name in others:
        beside = f"{times.ratio('jac', name):.2g} of it takes jac"
        report.note(f"the same by {name}", duration(times.median(name)), verdict=beside)


def _steps(y: Vector) -> Vector:
    return 1.5e-8 * np.maximum(1.0, np.abs(y))


def _differences(module: ModuleType, y: Vector, p: Vector) -> Matrix:
    """Forward differences as SciPy takes them."""
    h, J, moved = _steps(y), np.empty((len(y), len(y))), y.copy()
    at = module.rhs(0.0, y, p)
    for j in range(len(y)):
        moved[j] = y[j] + h[j]
        J[j] = (module.rhs(0.0, moved, p) - at) / (moved[j] - y[j])
        moved[j] = y[j]
    return J.T


def _batch_differences(module: ModuleType, y: Vector, p: Vector) -> Matrix:
    """The same, all states in one call."""
    moved = y + np.diag(_steps(y))
    dy = module.rhs_batch(0.0, moved, p)
    return ((dy - module.rhs(0.0, y, p)) / (np.diag(moved) - y)[:, None]).T
