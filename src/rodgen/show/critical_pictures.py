"""Curves of a critical load: frequencies and growth rates over the load that is scaled."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import linear_sum_assignment

from rodgen.analyse.critical import Critical
from rodgen.analyse.eigenvalues import Complex
from rodgen.analyse.load_family import LoadFamily
from rodgen.analyse.scaled_load import GROUPS, label_of, symbol_of
from rodgen.analyse.scene_family import load_family
from rodgen.arrays import Array
from rodgen.errors import AnalysisError
from rodgen.model.term import typeset
from rodgen.show.canvas import CURVE, FAINT, LINE, SPECIAL, make_axes, set_title

FORCES = 400  # at which eigenvalues are computed
BEYOND_CRITICAL = 0.3  # of the critical force, that the curves go on
NEAR = 0.1  # of the critical force, up to where growth fills the picture


def stability_curves(found: Critical) -> Figure:
    """Frequencies of the lowest modes, and growth rates below, over the load that is scaled."""
    scene = found.scene
    speed = found.speed if scene.boundary_condition.translates else None
    family = load_family(scene, found.t, speed, load=found.load)
    start = min(0.0, found.searched[0])
    beyond = found.value + BEYOND_CRITICAL * max(abs(found.value), family.unit * (not found.value))
    forces, s = _eigenvalue_curves(family, start, beyond, found)
    s = connect_curves(s)
    frequency = np.where(s.imag < 0, np.nan, s.imag) / (2 * np.pi)  # of each pair, one
    slow = family.zero_tolerance / (2 * np.pi)
    at_start = np.where(frequency[0] > slow, frequency[0], np.inf)
    modes = np.argsort(at_start)[: max(*found.modes, 2) + 1]
    modes = modes[np.isfinite(at_start[modes])]
    figure, (upper, lower) = make_axes(6.4, 5.6, 2, sharex=True, height_ratios=(3, 2))
    upper.plot(forces, frequency[:, modes], color=CURVE, linewidth=LINE)
    top = float(np.nanmax(frequency[:, modes], initial=0.0))
    upper.set_ylim(0, 1.08 * max(top, 1e-300))
    for number, mode in enumerate(modes.tolist(), 1):
        place = (forces[0], frequency[0, mode])
        upper.annotate(f"{number}", place, (3, 2), textcoords="offset points", color=FAINT)
    upper.plot(
        found.value,
        found.frequency,
        "o",
        color=SPECIAL,
        clip_on=False,
        in_layout=False,
        markersize=5,
    )
    lower.plot(forces, s.real, color=CURVE, linewidth=LINE)
    lower.set_ylim(_growth_limits(forces, s.real, found.value, family))
    lower.plot(found.value, 0.0, "o", color=SPECIAL, markersize=5)
    for axes in (upper, lower):
        axes.axvline(found.value, color=SPECIAL, linestyle="--", linewidth=0.8)
    at = f" at {found.frequency:.5g} Hz" if found.frequency else ""
    upper.set(ylabel="frequency [Hz]")
    set_title(figure, f"{scene.name}: {found.kind} from {found.value:.6g} {found.unit}{at}")
    label = label_of(found.load) + f" [{typeset(found.unit)}]" * (found.load not in GROUPS)
    lower.set(xlabel=label, ylabel="growth [1/s]", xlim=(forces[0], forces[-1]))
    if found.load_parameter and found.load not in GROUPS:
        scale = found.load_parameter / found.value
        beside = upper.secondary_xaxis(
            "top",
            functions=(partial(np.multiply, scale), partial(np.multiply, 1 / scale)),
        )
        beside.set_xlabel(typeset(symbol_of(found.load)))
    return figure


def connect_curves(s: Complex) -> Complex:
    """Order eigenvalues (forces, k) so that each column is one curve, which goes on as it came."""
    found = s.copy()
    for at in range(1, len(s)):
        before = found[at - 1]
        ahead = 2 * before - found[at - 2] if at > 1 else before
        ahead = np.where(np.isnan(ahead), before, ahead)
        cost = np.abs(ahead[:, None] - s[at])
        largest = float(np.nanmax(cost, initial=1.0))
        found[at] = s[at, linear_sum_assignment(np.nan_to_num(cost, nan=10 * largest))[1]]
    return found


def _growth_limits(
    forces: Array, growth: Array, force: float, family: LoadFamily
) -> tuple[float, float]:
    """Return limits for the growth [1/s]: up to its largest a little beyond the critical force, not
    to what comes much later, and down to the least damped motion wherever it dies away fastest."""
    most = np.nan_to_num(growth, nan=-np.inf).max(axis=1)
    near = forces <= force + NEAR * abs(force)
    high = max(float(most[near].max()), 1e-6 * family.lowest_frequency)
    low = float(most.min()) if family.is_damped else -high  # flutter dies away as it grows
    return 1.1 * min(low, -high / 4), 1.1 * max(high, -low / 4)


def _eigenvalue_curves(
    family: LoadFamily, low: float, high: float, found: Critical
) -> tuple[Array, Complex]:
    """Return forces and eigenvalues at them, those left out of the search as nan; only up to the
    critical force where there is no steady state beyond."""
    for end in (high, found.value * (1 - 1e-6)):
        forces = np.linspace(low, end, FORCES)
        try:
            return forces, family.motions(forces, elastic=found.elastic).s
        except AnalysisError as error:
            last = error
    raise last


PICTURES_OF = {Critical: {"curves": stability_curves}}
