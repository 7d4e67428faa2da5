"""Open questions of section 5.1 of the thesis, answered with the rod of its section 3.3."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from pandas import DataFrame

from rodgen.analyse.chaos.lyapunov import lyapunov_exponents
from rodgen.analyse.critical import critical_load
from rodgen.analyse.cycles.cycle_result import Cycle
from rodgen.analyse.cycles.cycle_search import CycleSearch
from rodgen.analyse.cycles.hopf import first_hopf
from rodgen.analyse.cycles.periodic_motion import find_cycle
from rodgen.analyse.modes import natural_modes
from rodgen.analyse.references import continuum
from rodgen.scene import Scene
from rodgen.system import ParameterRange, System
from rodgen_evidence.thesis import scenes
from rodgen_evidence.thesis.table import Remark, ThesisTable, column, percent

COLUMNS = (
    column("question", "asked in 5.1"),
    column("rod", "rod"),
    column("quantity", "quantity"),
    column("value", "value", "", ".6g"),
)
LINKS, FINE = 10, 40
INTERNAL = 0.3  # m^2/s
EXTERNAL = (0.0, 0.02, 0.2, 1.0)  # 1/s
FORCE, FAR, CHAOTIC = 100.0, 140.0, 200.0  # N
SPAN = 800.0  # s, a hundred swings or more
FREQUENCIES, SHAPES, AFTER, MEDIUM = (
    "natural frequencies of the free rod",
    "mode shapes",
    "behaviour beyond the critical load",
    "influence of external damping on it",
)
BEGIN, ONSET = "cycles begin at [N]", "flutter begins at [N]"
SWING = "amplitude of the angles"
KEY, ENDS = "loads.follower.force", (20.0, 100.0)


class OutlookRow(NamedTuple):
    """A row of the table; value: of the quantity, in the unit that it names."""

    question: str
    rod: str
    quantity: str
    value: float


def cantilever(force: float, external: float = 0.0) -> Scene:
    """Cantilever under thrust [N], with both dampings of the thesis."""
    loads: dict[str, Any] = {
        "follower": {"force": force},
        "internal_damping": {"coefficient": INTERNAL},
    }
    if external:
        loads["external_damping"] = {"coefficient": external}
    return scenes.long_rod(
        LINKS,
        "cantilever",
        loads=loads,
        initial={"phi": "0.1*s"},
        span=[0.0, SPAN],
        rtol=1e-8,
        atol=1e-10,
        output_every=0.2,
    )


def shape(boundary: str, k: int, s: np.ndarray) -> np.ndarray:
    """The k-th mode of the continuum, free or clamped at s = 0, at places s of [0, 1]."""
    b = float(continuum.wave_number(boundary, k))
    sign = 1.0 if boundary == "free" else -1.0
    # As exp(b) is large, its part is taken apart: cosh - sinh loses what is left.
    ratio = (np.cosh(b) - sign * np.cos(b)) / (np.sinh(b) - sign * np.sin(b))
    w = np.cosh(b * s) + sign * np.cos(b * s) - ratio * (np.sinh(b * s) + sign * np.sin(b * s))
    return np.asarray(w / np.abs(w).max())


def bending() -> Iterator[OutlookRow]:
    """Frequencies and shapes of the first three modes beside the continuum."""
    places = np.linspace(0, 1, FINE + 1)
    for boundary in ("free", "clamped"):
        modes = natural_modes(scenes.long_rod(FINE, boundary), 3)
        rod = f"{boundary}, {FINE} links"
        for k in (1, 2, 3):
            if boundary == "free":
                exact = float(continuum.natural_frequency(boundary, k, **scenes.LONG))
                off = float(percent(modes.frequencies[k - 1], exact))
                yield OutlookRow(FREQUENCIES, rod, f"f{k}, off the continuum [%]", off)
            across = np.real(modes.displacements[k - 1][:, 1])
            w = shape(boundary, k, places)
            across = across * np.sign(across @ w) / np.abs(across).max()
            far = float(np.abs(across - w).max())
            yield OutlookRow(
                SHAPES, rod, f"mode {k}: farthest off the continuum, of its largest", far
            )


def beyond() -> Iterator[OutlookRow]:
    """Yield where and how cycles begin, how far they swing, and where they are lost."""
    scene, rod = cantilever(FORCE), f"cantilever, {LINKS} links, c_int = {INTERNAL:g}"
    search = CycleSearch.of(System(scene))
    hopf, _ = first_hopf(search, ParameterRange(search.system, KEY, ENDS))
    yield OutlookRow(AFTER, rod, BEGIN, hopf.value)
    kind = "first Lyapunov coefficient (below 0: supercritical)"
    yield OutlookRow(AFTER, rod, kind, hopf.lyapunov)
    for force in (FORCE, FAR):
        yield from _cycle(AFTER, rod, force, find_cycle(cantilever(force)))
    for force in (FAR, CHAOTIC):
        found = lyapunov_exponents(cantilever(force), count=1)
        yield OutlookRow(
            AFTER, rod, f"first exponent at {force:g} N [1/s]", float(found.exponents[0])
        )
        yield OutlookRow(AFTER, rod, f"its error at {force:g} N [1/s]", float(found.errors[0]))


def cycles_by_damping() -> Iterator[OutlookRow]:
    """Yield how far the cycles swing with more and more external damping."""
    for external in EXTERNAL:
        rod = f"cantilever, {LINKS} links, c_int = {INTERNAL:g}, c_ext = {external:g}"
        scene = cantilever(FORCE, external)
        yield OutlookRow(MEDIUM, rod, ONSET, critical_load(scene).value)
        yield from _cycle(MEDIUM, rod, FORCE, find_cycle(scene))


def _cycle(question: str, rod: str, force: float, cycle: Cycle) -> Iterator[OutlookRow]:
    yield OutlookRow(question, rod, f"{SWING} at {force:g} N [rad]", cycle.amplitude)
    yield OutlookRow(question, rod, f"period at {force:g} N [s]", cycle.period)


def table_outlook() -> ThesisTable:
    """The questions and what was found."""
    rows = DataFrame([*bending(), *beyond(), *cycles_by_damping()])
    table = ThesisTable("outlook", "What section 5.1 leaves to do", COLUMNS, rows)
    table.conditions = ["L = 5 m, EI = 100 N m^2"]
    table.assumed = [
        f"m = {scenes.MASS:g} kg; c_int in m^2/s, c_ext in 1/s. Motions begin at phi = 0.1 s.",
        "Cycles by Newton's method from a run, exponents over "
        f"{SPAN:g} s. Verifying by principal axes is not needed: frequencies are eigenvalues.",
    ]
    value = dict(zip(rows["quantity"], rows["value"], strict=True))
    medium = rows[rows["question"] == MEDIUM]
    onsets, swings = (
        [float(x) for x in medium["value"][medium["quantity"].str.startswith(words)]]
        for words in (ONSET, SWING)
    )
    table.notes = [
        Remark(
            "shown",
            f"Beyond {value[BEGIN]:.2f} N the cantilever swings in a limit cycle that begins "
            f"softly. At {CHAOTIC:g} N it never comes back to itself: small errors grow, the "
            "motion is chaotic.",
        ),
        Remark(
            "shown",
            f"External damping from none to {EXTERNAL[-1]:g} 1/s moves the onset of flutter from "
            f"{onsets[0]:.2f} to {onsets[-1]:.2f} N, and shrinks the swing at {FORCE:g} N from "
            f"{swings[0]:.2f} to {swings[-1]:.2f} rad. The least of it moves the onset most: with "
            f"{EXTERNAL[1]:g} 1/s it is {onsets[1]:.2f} N.",
        ),
        Remark(
            "found",
            "Branches of cycles, their bifurcations and the free rod's choice between swinging "
            "and tumbling stand in docs/limit-cycles.md, chaos in docs/chaos.md, runs in parallel "
            "in docs/studies.md.",
        ),
    ]
    return table
