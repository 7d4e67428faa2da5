"""Pictures of spectra: of motions, and of Lyapunov exponents with their means over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rodgen.analyse.chaos.lyapunov import Exponents
from rodgen.analyse.spectrum import Spectrum
from rodgen.display import Plottable
from rodgen.model.term import typeset
from rodgen.show.canvas import (
    ALONG,
    CURVE,
    FAINT,
    LINE,
    SPECIAL,
    make_axes,
    make_pair,
    set_title,
)

MOST_MEANS = 12  # of means that settle
NAMED_MEANS = 6  # of these, with a name each
BEYOND_PEAKS = 1.5  # times the last peak, up to where a spectrum is drawn
SPECTRUM = 3  # exponents from which on there is a picture of all of them


def spectral_density(found: Spectrum) -> Figure:
    """Spectral density over frequency, with a line and a number at every peak."""
    figure, (axes,) = make_axes(6.5, 4.0)
    axes.semilogy(found.bins[1:], found.density[1:], color=CURVE, linewidth=LINE)
    heights = np.interp(found.frequencies, found.bins, found.density)
    places = zip(found.frequencies, heights, strict=True)
    for number, place in enumerate(places, 1):
        axes.axvline(place[0], color=SPECIAL, linewidth=0.8, linestyle=":")
        how: dict[str, Any] = {"textcoords": "offset points", "color": SPECIAL}
        axes.annotate(f"{number}", place, (2, 2), **how)
    axes.set_xlim(0.0, min(BEYOND_PEAKS * max(found.frequencies), found.bins[-1]))
    axes.set(xlabel="frequency [Hz]", ylabel=f"density [{typeset('unit^2/Hz')}]")
    return figure


def convergence(found: Exponents) -> Figure:
    """Means over time with their errors at the end; from three on, beside them the spectrum."""
    several = len(found.exponents) >= SPECTRUM
    figure, (axes, *beside) = make_pair(7.4, 3.4) if several else make_axes(6.0, 4.0)
    _means(axes, found)
    if several:
        _spectrum(beside[0], found)
    set_title(figure, f"{found.scene.name}: Lyapunov exponents")
    return figure


def _means(axes: Axes, found: Exponents) -> None:
    count = len(found.exponents)
    shown: Sequence[int] = range(count)
    if count > MOST_MEANS:  # the largest, and the smallest that answer them
        shown = [*range(MOST_MEANS // 2), *range(count - MOST_MEANS // 2, count)]
    colours = ALONG(np.linspace(0.0, 1.0, len(shown)))
    few = found.t - (found.t[0] - (found.t[1] - found.t[0])) if len(found.t) > 1 else found.t
    for at, colour in zip(shown, colours, strict=True):
        label = (
            rf"$\lambda_{{{at + 1}}}$ = {found.exponents[at]:.4g}" if count <= NAMED_MEANS else None
        )
        axes.plot(few, found.running[:, at], color=colour, linewidth=LINE, label=label)
        error = found.errors[at]
        axes.errorbar(few[-1] * 1.08, found.exponents[at], error, color=colour, capsize=2.5)
    axes.axhline(0.0, color=FAINT, linewidth=0.7)
    axes.set(xscale="log", xlabel="time averaged over [s]", ylabel="mean rate of growth [1/s]")
    late = found.running[len(found.running) // 50 :]
    axes.set_xlim(few[len(few) // 50] / 1.5, few[-1] * 1.3)
    low, high = float(late.min()), float(late.max())
    room = 0.08 * (high - low) + float(found.errors.max())
    axes.set_ylim(low - room, high + room)
    if count <= NAMED_MEANS:
        axes.legend()


def _spectrum(axes: Axes, found: Exponents) -> None:
    numbers = np.arange(1, len(found.exponents) + 1)
    axes.axhline(0.0, color=FAINT, linewidth=0.7)
    axes.errorbar(
        numbers, found.exponents, found.errors, fmt="o", color=CURVE, markersize=3.5, capsize=2.5
    )
    axes.set(xlabel="number", ylabel="exponent [1/s]")
    if len(numbers) <= MOST_MEANS:
        axes.set_xticks(numbers)


PICTURES_OF: dict[type[Plottable], Mapping[str, Callable[[Any], Figure]]] = {
    Exponents: {"means": convergence},
    Spectrum: {"density": spectral_density},
}
