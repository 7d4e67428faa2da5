"""The style of rodgen's pictures for matplotlib: fonts that are read in a column of a paper, thin
lines, and the colours of the palette.
"""

from __future__ import annotations

from typing import Any

from cycler import cycler

from rodgen.model.palette import LIGHT, colours_of

FONT = 8.0  # points: of labels in most journals, at the width of a column

#: Settings of matplotlib: ``matplotlib.style.use(rodgen.style)``, also as a context.
style: dict[Any, Any] = {
    "font.size": FONT,
    "font.family": "sans-serif",
    "axes.titlesize": FONT,
    "axes.labelsize": FONT,
    "xtick.labelsize": FONT - 1,
    "ytick.labelsize": FONT - 1,
    "legend.fontsize": FONT - 1,
    "figure.titlesize": FONT,
    "figure.labelsize": FONT,
    "figure.figsize": (4.4, 3.3),  # inches
    "figure.dpi": 150,
    "figure.constrained_layout.use": True,
    "savefig.dpi": 250,
    "text.color": LIGHT["ink"],
    "axes.labelcolor": LIGHT["ink"],
    "axes.edgecolor": LIGHT["axis"],
    "xtick.color": LIGHT["axis"],
    "ytick.color": LIGHT["axis"],
    "xtick.labelcolor": LIGHT["ink"],
    "ytick.labelcolor": LIGHT["ink"],
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "lines.linewidth": 1.0,
    "lines.markersize": 4.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": LIGHT["grid"],
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "axes.prop_cycle": cycler(color=colours_of("series")),
    "image.cmap": "viridis",
    "svg.fonttype": "none",  # text stays text
    "pdf.fonttype": 42,
}
