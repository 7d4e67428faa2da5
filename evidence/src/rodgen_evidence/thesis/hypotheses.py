"""Hypotheses on where tables 3.1 and 3.2 come from, each worked out to what it amounts to."""

from __future__ import annotations

import numpy as np
from pandas import DataFrame

from rodgen.analyse.spectrum import find_peaks
from rodgen.integrate import simulate
from rodgen_evidence.thesis import data, scenes
from rodgen_evidence.thesis.table import Remark, percent

BENDS = (0.01, 0.3, 0.6)  # rad at the ends: amplitudes at which f1 is looked at
BIN = 1 / scenes.SPAN  # Hz
ON_BIN = 0.005  # bins, within which a value printed to 1e-4 Hz lies on one
PADDED = 65536  # samples: the power of two after the 62500 of 50 s


def of_frequencies(rows: DataFrame, lumped: float) -> list[Remark]:
    """Ideas on table 3.1 from its rows; lumped: f1 of as many free lumped links [Hz]."""
    printed, discrete = rows["thesis"], rows["discrete"]
    bins = printed * PADDED * scenes.STEP
    on = rows["name"][(bins - bins.round()).abs() < ON_BIN]
    euler, kutta = (
        numerical_frequency(discrete[0], scenes.STEP, method)
        for method in ("semi_implicit_euler", "thesis_runge_kutta")
    )
    pairs = zip(rows["name"], printed - discrete, strict=True)
    away = ", ".join(f"{name} {off:+.3f}" for name, off in pairs)
    return [
        Remark(
            "refuted",
            f"The number of links: f1 of 40 free links is {discrete[0]:.4f} Hz with uniform and "
            f"{lumped:.4f} Hz with lumped mass, both below the printed {printed[0]:.4f} Hz.",
        ),
        Remark(
            "refuted",
            f"The bins of the FFT: those of 50 s are {BIN:g} Hz apart, and the values are off by "
            f"(Hz) {away}. With zeros appended to {PADDED} samples only {', '.join(on)} "
            "lies on a bin.",
        ),
        Remark(
            "refuted",
            f"The time step: steps of 8e-4 s would make {euler:.4f} Hz of f1 by the semi-implicit "
            f"Euler and {kutta:.4f} Hz by the thesis's Runge-Kutta method.",
        ),
        _on_clamp(rows.dropna(subset="short")),
    ]


def _on_clamp(rows: DataFrame) -> Remark:
    """The frequencies of the cantilever between its model and the shorter continuum."""
    model, short = (list(percent(rows["thesis"], rows[key])) for key in ("discrete", "short"))
    return Remark(
        "open",
        f"The cantilever: f1 is {model[0]:+.2f} % from the model with its clamp and "
        f"{short[0]:+.2f} % from the continuum of length L - L/n, the others {min(model[1:]):+.2f} "
        f"to {max(model[1:]):+.2f} % from the model but {min(short[1:]):+.2f} to "
        f"{max(short[1:]):+.2f} % from that continuum. No one model gives both.",
    )


def of_step(rows: DataFrame, links: int, limit: float) -> list[Remark]:
    """The printed step against the largest stable one [s] of that many links."""
    heavier = (scenes.STEP / limit) ** 2
    scaled = BIN * np.sqrt(1000)
    away = (rows["thesis"] - rows["discrete"]).abs() / scaled
    return [
        Remark(
            "shown",
            f"The printed step cannot have been used with the printed mass: {links} links of a rod "
            f"of 15.7 kg need steps below {limit:.2g} s (2/omega of the fastest motion), "
            f"{scenes.STEP / limit:.0f} times less.",
        ),
        Remark(
            "consistent",
            f"It is stable for a mass above {heavier:.0f} times 15.7 kg, as it would be with "
            "15700, the mass in grams, taken as kilograms. All frequencies would then be 31.6 "
            f"times lower and the bins of 50 s, scaled back, {scaled:.2f} Hz wide. The values are "
            f"off by {', '.join(f'{x:.1f}' for x in away)} of these bins, in the order of the "
            "table: reading a spectrum so coarse would explain most rows, but not f4 and f5 of "
            "the cantilever.",
        ),
    ]


def of_common_base() -> Remark:
    """The base that the printed deviations of 3.1 would need."""
    printed = data.TABLE_3_1.set_index("name")[["analytical", "simulated", "percent"]].astype(float)
    lower = percent(printed["simulated"] / (1 + printed["percent"] / 100), printed["analytical"])
    words = ", ".join(f"{name} {off:+.3f} %" for name, off in lower.items())
    return Remark(
        "consistent",
        "The printed deviations would follow from analytical values that differ from the printed "
        f"ones by: {words}. Four rows of the cantilever ask for the same 0.11 to 0.12 %: as if "
        "they had been worked out before a constant of the rod was changed.",
    )


def of_convergence(rows: DataFrame) -> list[Remark]:
    """Ideas on table 3.2 from its rows."""
    first = rows.iloc[0]
    bends = {bend: bent(first["links"], bend) for bend in BENDS}
    words = ", ".join(f"{f:.2f} Hz at {bend:g} rad" for bend, f in bends.items())
    changes = rows["deviation"].abs()
    return [
        Remark(
            "shown",
            "The model does not converge like this: f1 of the discrete model with uniform links "
            "is off by "
            f"{percent(first['discrete'], first['continuum']):+.3f} % at "
            f"n = {first['links']}, the printed value by {first['deviation']:+.2f} %.",
        ),
        Remark(
            "refuted",
            f"Lumped mass: at n = {first['links']} it gives {first['lumped']:.3f} Hz and converges "
            "with the order 2 to the continuum, not from 12.63 to 13.39 Hz within 20 links.",
        ),
        Remark(
            "open",
            f"A large amplitude lowers f1 (ends turned by: {words}, n = {first['links']}, from "
            "the motion in full), so that values below the linear one could come from a strong "
            f"impulse; the values from n = 20 on, up to {changes[2:].max():.2f} % "
            "above, could not.",
        ),
        _on_times(rows),
    ]


def _on_times(rows: DataFrame) -> Remark:
    """Remark on how run times grow over the finer half of the rows."""
    ends = rows.iloc[[len(rows) // 3, -1]]
    links = ends["links"].tolist()
    grown = np.log(ends[["links", "thesis_seconds", "seconds"]].astype(float)).diff().iloc[1]
    thesis, ours = grown[["thesis_seconds", "seconds"]] / grown["links"]
    return Remark(
        "consistent",
        f"From n = {links[0]} to {links[1]} run times grow with n^{thesis:.1f} in the thesis, "
        f"where all steps are equal and a dense system is solved in each, and with n^{ours:.1f} "
        "here, where a step costs O(n) but the number of stable steps grows with n^2.",
    )


def numerical_frequency(frequency: float, step: float, method: str) -> float:
    """Frequency [Hz] that a method with a step [s] makes of an undamped oscillation."""
    z = (2 * np.pi * frequency * step) ** 2
    # The velocity at the end of the step, with the shares of q and v in the mean acceleration:
    # the step is a matrix with these entries, whose eigenvalues turn by the shifted frequency.
    of_q, of_v = (-z, 0.0) if method == "semi_implicit_euler" else _thesis(z)
    step_matrix = np.array([[1 + of_q, 1 + of_v], [of_q, 1 + of_v]])
    turned = np.abs(np.angle(np.linalg.eigvals(step_matrix))).max()
    return float(turned / (2 * np.pi * step))


def _thesis(z: float) -> tuple[float, float]:
    """Mean acceleration of the thesis's Runge-Kutta method by q and by v, h = 1, omega^2 = z."""
    pair = np.eye(2)

    def move(a: np.ndarray) -> np.ndarray:
        return np.asarray(-z * (pair[0] + pair[1] + a))

    first = -z * pair[0]
    second = move(first / 2)
    third = move(second / 2)
    mean = (first + 2 * (second + third) + move(third)) / 6
    return float(mean[0]), float(mean[1])


def bent(links: int, bend: float) -> float:
    """f1 [Hz] of a free rod whose ends are turned by +-bend [rad] at first, without damping."""
    scene = scenes.steel_rod(
        links,
        "free",
        f"{-bend}*cos(pi*s)",
        method="dop853",
        rtol=1e-7,
        span=[0.0, 3.0],
        output_every=0.002,
    )
    solution = simulate(scene)
    angle = solution.phi[:, -1] - solution.phi[:, 0]
    found = find_peaks(solution.t, angle, peaks=1)
    return float(found.frequencies[0])
