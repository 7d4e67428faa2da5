"""Tables 3.1 and 3.2: natural frequencies, from the eigenvalues and from a simulation by FFT."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from pandas import DataFrame

from rodgen.analyse.modes import natural_modes
from rodgen.analyse.references import continuum
from rodgen.analyse.spectrum import Spectrum, spectrum
from rodgen.integrate import simulate
from rodgen_evidence.thesis import data, hypotheses, scenes
from rodgen_evidence.thesis.percentages import base_of
from rodgen_evidence.thesis.table import (
    LINKS,
    VERDICT,
    Remark,
    ThesisTable,
    beside,
    column,
    percent,
)

MANY = 40  # links of table 3.1
# Bent so little that it is linear: the free rod symmetrically about its middle, as in the thesis.
BENT = {"free": "0.001*(2*s - 1)**3", "cantilever": "0.001*s"}
PEAKS = {"free": 3, "cantilever": 5}
SAFETY = 0.8  # of the largest stable step

COLUMNS_3_1 = (
    column("name", "frequency"),
    column("thesis_analytical", "thesis: analytical", "Hz", ".4f"),
    column("thesis", "thesis: simulated", "Hz", ".4f"),
    column("simulated", "ours: simulated, FFT", "Hz", ".4f"),
    column("discrete", "discrete model, n = 40", "Hz", ".6f"),
    column("continuum", "continuum, length L", "Hz", ".4f"),
    column("short", "continuum, length L - L/n", "Hz", ".4f"),
    column("deviation", "thesis against discrete", "%", "+.3f"),
    column("ours_deviation", "our FFT against discrete", "%", "+.5f"),
    VERDICT,
)
COLUMNS_3_2 = (
    LINKS,
    column("thesis", "thesis: simulated", "Hz", ".4f"),
    column("simulated", "ours: simulated, FFT", "Hz", ".4f"),
    column("discrete", "discrete model, uniform", "Hz", ".6f"),
    column("lumped", "discrete model, lumped", "Hz", ".4f"),
    column("continuum", "continuum", "Hz", ".4f"),
    column("deviation", "thesis against discrete", "%", "+.3f"),
    column("thesis_seconds", "run time, thesis", "s", ".3f"),
    column("seconds", "run time, ours", "s", ".3f"),
    VERDICT,
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
def simulate_spectrum(links: int, boundary: str) -> tuple[Spectrum, float]:
    """Find frequencies as the thesis does, and the run time [s] of the simulation."""
    scene = scenes.steel_rod(
        links,
        boundary,
        BENT[boundary],
        method="semi_implicit_euler",
        step=stable_step(links),
        span=[0.0, scenes.SPAN],
        output_every=scenes.STEP,
    )
    solution = simulate(scene)
    return spectrum(solution, peaks=PEAKS[boundary]), solution.stats.wall_seconds


@lru_cache(maxsize=32)
def discrete(links: int, boundary: str, inertia: str = "uniform") -> NDArray[np.float64]:
    """Natural frequencies of the discrete model [Hz], by eigenvalues."""
    scene = scenes.steel_rod(links, boundary)
    return natural_modes(scene.replace({"rod.inertia": inertia}), 5).frequencies


def closest(found: Spectrum, frequency: float) -> float:
    """The peak closest to a frequency [Hz]."""
    return float(found.frequencies[np.argmin(np.abs(found.frequencies - frequency))])


def table_3_1() -> ThesisTable:
    """Natural frequencies of the free rod and the cantilever."""
    printed = data.TABLE_3_1
    found = [_of_mode(*at) for at in zip(printed["boundary"], printed["mode"], strict=True)]
    rows = beside(DataFrame(found), printed["simulated"], "see below").assign(
        name=printed["name"],
        thesis_analytical=printed["analytical"].astype(float),
        ours_deviation=lambda rows: percent(rows["simulated"], rows["discrete"]),
    )
    table = ThesisTable(
        "3.1", "Natural frequencies", COLUMNS_3_1, rows, [*CONDITIONS, f"{MANY} links"]
    )
    peaks = simulate_spectrum(MANY, "free")[0]
    table.assumed = [
        f"Initial bend of about 0.001 rad, {BENT['free']} of the free rod and "
        f"{BENT['cantilever']} of the cantilever: the thesis does not give its impulse.",
        f"Semi-implicit Euler steps of {stable_step(MANY):.3g} s, sampled every 8e-4 s: the "
        "printed step is not stable (see below).",
        f"FFT of {scenes.SPAN:g} s in a sine^6 window with peaks between the bins; tones closer "
        f"than {peaks.resolution:.2g} Hz are one peak.",
    ]
    off = percent(rows["thesis_analytical"], rows["short"].fillna(rows["continuum"]))
    table.notes = [
        *hypotheses.of_frequencies(rows, float(discrete(MANY, "free", "lumped")[0])),
        *hypotheses.of_step(rows, MANY, limit(MANY)),
        Remark("found", base_of("3.1")),
        Remark(
            "shown",
            "The analytical column, of the length L of the free rod and L - L/n of the cantilever, "
            f"is {off.min():+.4f} to {off.max():+.4f} % from the roots of the characteristic "
            "equations.",
        ),
        hypotheses.of_common_base(),
    ]
    return table


def _of_mode(boundary: str, mode: int) -> dict[str, float]:
    exact = float(discrete(MANY, boundary)[mode - 1])
    rod, moving = scenes.STEEL, 1 - 1 / MANY
    short = scenes.Beam(
        length=rod["length"] * moving,
        bending_stiffness=rod["bending_stiffness"],
        mass=rod["mass"] * moving,
    )
    held = boundary != "free"
    return {
        "simulated": closest(simulate_spectrum(MANY, boundary)[0], exact),
        "discrete": exact,
        "continuum": continuum.natural_frequency(boundary, mode, **rod),
        "short": continuum.natural_frequency(boundary, mode, **short) if held else np.nan,
    }


def table_3_2() -> ThesisTable:
    """Convergence of the first frequency of the free rod."""
    printed = data.TABLE_3_2
    rows = beside(DataFrame(map(_first, printed["links"])), printed["simulated"], "see below")
    rows["links"], rows["thesis_seconds"] = printed["links"], printed["seconds"].astype(float)
    table = ThesisTable("3.2", "First frequency of the free rod", COLUMNS_3_2, rows, [*CONDITIONS])
    table.assumed = [
        "As in table 3.1, with the largest whole fraction of 8e-4 s that is stable at each n. Run "
        "time: the simulation alone, FFT not counted, on one core."
    ]
    table.notes = hypotheses.of_convergence(rows)
    return table


def _first(links: int) -> dict[str, float]:
    exact = float(discrete(links, "free")[0])
    found, seconds = simulate_spectrum(links, "free")
    return {
        "simulated": closest(found, exact),
        "discrete": exact,
        "lumped": float(discrete(links, "free", "lumped")[0]),
        "continuum": continuum.natural_frequency("free", 1, **scenes.STEEL),
        "seconds": seconds,
    }
