"""Tables 3.1 and 3.2: natural frequencies, from the eigenvalues and from a simulation by FFT."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse import continuum
from rodgen.analyse.fourier import Spectrum, spectrum
from rodgen.analyse.modes import natural_modes
from rodgen.integrate import simulate
from rodgen.scene import Scene
from rodgen.thesis import data, hypotheses, scenes
from rodgen.thesis.percentages import base_of
from rodgen.thesis.table import Cell, Column, Note, Table, percent, verdict

LINKS = 40
# Bent so little that it is linear: the free rod symmetrically about its middle, as in the thesis.
BENT = {"free": "0.001*(2*s - 1)**3", "cantilever": "0.001*s"}
PEAKS = {"free": 3, "cantilever": 5}
SAFETY = 0.8  # of the largest stable step

COLUMNS_3_1 = (
    Column("name", "frequency"),
    Column("thesis_analytical", "thesis: analytical", "Hz", ".4f"),
    Column("thesis", "thesis: simulated", "Hz", ".4f"),
    Column("simulated", "ours: simulated, FFT", "Hz", ".4f"),
    Column("discrete", "discrete model, n = 40", "Hz", ".6f"),
    Column("continuum", "continuum, length L", "Hz", ".4f"),
    Column("short", "continuum, length L - L/n", "Hz", ".4f"),
    Column("deviation", "thesis against discrete", "%", "+.3f"),
    Column("ours_deviation", "our FFT against discrete", "%", "+.5f"),
    Column("verdict", "verdict"),
)
COLUMNS_3_2 = (
    Column("links", "links"),
    Column("thesis", "thesis: simulated", "Hz", ".4f"),
    Column("simulated", "ours: simulated, FFT", "Hz", ".4f"),
    Column("discrete", "discrete model, uniform", "Hz", ".6f"),
    Column("lumped", "discrete model, lumped", "Hz", ".4f"),
    Column("continuum", "continuum", "Hz", ".4f"),
    Column("deviation", "thesis against discrete", "%", "+.3f"),
    Column("thesis_seconds", "run time, thesis", "s", ".3f"),
    Column("seconds", "run time, ours", "s", ".3f"),
    Column("verdict", "verdict"),
)
CONDITIONS = [
    "L = 2 m, A = 0.001 m^2, I = 8.33e-9 m^4, E = 210e9 Pa, m = 15 700 g, step 8e-4 s, 50 s"
]


def limit(links: int) -> float:
    """The largest stable step of the semi-implicit Euler method [s]: 2 / omega of the free rod,
    omega = 4 sqrt(3) n^2 sqrt(EI / (M L^3)) (held, it is slower)."""
    rod = scenes.STEEL
    rate = np.sqrt(rod["bending_stiffness"] / (rod["mass"] * rod["length"] ** 3))
    return float(2 / (4 * np.sqrt(3) * links**2 * rate))


def stable_step(links: int) -> float:
    """A whole fraction of the thesis's step that is stable [s]."""
    return float(scenes.STEP / max(1, np.ceil(scenes.STEP / (SAFETY * limit(links)))))


@lru_cache(maxsize=32)
def simulated(links: int, boundary: str, span: float = scenes.SPAN) -> tuple[Spectrum, float]:
    """Frequencies as the thesis finds them, and the run time [s] of the simulation."""
    scene = scenes.steel_rod(
        links,
        boundary,
        BENT[boundary],
        method="semi_implicit_euler",
        step=stable_step(links),
        span=[0.0, span],
        output_every=scenes.STEP,
    )
    solution = simulate(scene)
    return spectrum(solution, peaks=PEAKS[boundary]), solution.stats.wall_seconds


@lru_cache(maxsize=32)
def discrete(links: int, boundary: str, inertia: str = "uniform") -> NDArray[np.float64]:
    """Natural frequencies of the discrete model [Hz], by eigenvalues."""
    scene = scenes.steel_rod(links, boundary)
    if inertia != "uniform":
        table = scene.model_dump(exclude_none=True)
        table["rod"]["inertia"] = inertia
        scene = Scene.from_dict(table)
    return natural_modes(scene, 5).frequencies


def closest(found: Spectrum, frequency: float) -> float:
    """The peak closest to a frequency [Hz]."""
    return float(found.frequencies[np.argmin(np.abs(found.frequencies - frequency))])


def table_3_1(links: int = LINKS, span: float = scenes.SPAN) -> Table:
    """Natural frequencies of the free rod and the cantilever."""
    rows = [_row_3_1(row, links, span) for row in data.TABLE_3_1]
    table = Table("3.1", "Natural frequencies", COLUMNS_3_1, rows, [*CONDITIONS, "40 links"])
    peaks = simulated(links, "free", span)[0]
    table.assumed = [
        f"Initial bend of about 0.001 rad, {BENT['free']} of the free rod and "
        f"{BENT['cantilever']} of the cantilever: the thesis does not give its impulse.",
        f"Semi-implicit Euler steps of {stable_step(links):.3g} s, sampled every 8e-4 s: the "
        "printed step is not stable (see below).",
        f"FFT of {span:g} s in a sine^6 window with peaks between the bins; tones closer than "
        f"{peaks.resolution:.2g} Hz are one peak.",
    ]
    table.notes = [
        *hypotheses.of_frequencies(rows, float(discrete(links, "free", "lumped")[0])),
        *hypotheses.of_step(rows, links, limit(links)),
        Note("found", base_of("3.1")),
        _note_on_analytical(rows),
        hypotheses.of_common_base(),
    ]
    return table


def _note_on_analytical(rows: list[dict[str, Cell]]) -> Note:
    """The analytical column against the continuum of the length that it is for."""
    off = [
        percent(float(row["thesis_analytical"] or 0), float(row["short"] or row["continuum"] or 1))
        for row in rows
    ]
    return Note(
        "shown",
        f"The analytical column, of the length L of the free rod and L - L/n of the cantilever, is "
        f"{min(off):+.4f} to {max(off):+.4f} % from the roots of the characteristic equations.",
    )


def _row_3_1(row: data.Frequency, links: int, span: float) -> dict[str, Cell]:
    exact = float(discrete(links, row.boundary)[row.mode - 1])
    ours = closest(simulated(links, row.boundary, span)[0], exact)
    rod, moving = scenes.STEEL, 1 - 1 / links
    short = scenes.Beam(
        length=rod["length"] * moving,
        bending_stiffness=rod["bending_stiffness"],
        mass=rod["mass"] * moving,
    )
    held = row.boundary != "free"
    return {
        "name": row.name,
        "thesis_analytical": float(row.analytical),
        "thesis": float(row.simulated),
        "simulated": ours,
        "discrete": exact,
        "continuum": continuum.natural_frequency(row.boundary, row.mode, **rod),
        "short": continuum.natural_frequency(row.boundary, row.mode, **short) if held else None,
        "deviation": percent(float(row.simulated), exact),
        "ours_deviation": percent(ours, exact),
        "verdict": verdict(row.simulated, exact, "see below"),
    }


def table_3_2(links: tuple[int, ...] | None = None, span: float = scenes.SPAN) -> Table:
    """Convergence of the first frequency of the free rod; links: those of the rows, or all."""
    printed = [row for row in data.TABLE_3_2 if links is None or row.links in links]
    rows = [_row_3_2(row, span) for row in printed]
    table = Table("3.2", "First frequency of the free rod", COLUMNS_3_2, rows, [*CONDITIONS])
    table.assumed = [
        "As in table 3.1, with the largest whole fraction of 8e-4 s that is stable at each n. Run "
        "time: the simulation alone, FFT not counted, on one core."
    ]
    table.notes = hypotheses.of_convergence(rows)
    return table


def _row_3_2(row: data.FirstFrequency, span: float) -> dict[str, Cell]:
    exact = float(discrete(row.links, "free")[0])
    found, seconds = simulated(row.links, "free", span)
    return {
        "links": row.links,
        "thesis": float(row.frequency),
        "simulated": closest(found, exact),
        "discrete": exact,
        "lumped": float(discrete(row.links, "free", "lumped")[0]),
        "continuum": continuum.natural_frequency("free", 1, **scenes.STEEL),
        "deviation": percent(float(row.frequency), exact),
        "thesis_seconds": float(row.seconds),
        "seconds": seconds,
        "verdict": verdict(row.frequency, exact, "see below"),
    }
