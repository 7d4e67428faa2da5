"""Picture of a spectrum."""

from __future__ import annotations

from matplotlib.figure import Figure

from rodgen.analyse.spectrum import Spectrum
from rodgen.show.canvas import CURVE, LINE, SPECIAL, make_figure


def spectral_density(found: Spectrum) -> Figure:
    """Spectral density over frequency, with a line at every peak."""
    figure = make_figure(6.5, 4.0)
    axes = figure.add_subplot()
    axes.semilogy(found.bins[1:], found.density[1:], color=CURVE, linewidth=LINE)
    for frequency in found.frequencies:
        axes.axvline(frequency, color=SPECIAL, linewidth=0.8, linestyle=":")
    axes.set(xlabel="frequency [Hz]", ylabel="density [unit^2/Hz]")
    axes.grid(alpha=0.3)
    return figure


PICTURES_OF = {Spectrum: {"density": spectral_density}}
