"""Background of an animation: axes, scale, title, colours, legend."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import MultipleLocator

from rodgen.model.term import COUPLE
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.show.animation.frame_times import FilmSettings
from rodgen.show.animation.motion import Camera
from rodgen.show.canvas import BODY, CENTRE, GUIDE, INK, MOMENTS, PAPER, TAIL, moment_norm

GRID_STYLE: dict[str, Any] = {"color": GUIDE, "alpha": 0.45, "linewidth": 0.7}
FILM_DPI = 100.0  # of a film of 1280 x 720; letters grow with the film
SMALLEST_LETTERS = 0.62  # of theirs there
KEY = 0.3  # inches below the legend, for the scale of the arrows
COUPLE_KEY = 0.2  # inches below that, for the scale of curved arrows
SPACING = 0.6  # inches between lines of the grid, at least: room for a number
MARGINS = 0.82, 2.3, 0.62, 0.55  # inches left, right, below and above the axes


class Stage:
    """Figure of a film, of just so many pixels. axes: where the rod is drawn, in equal scales;
    grid_step: metres between two lines of the grid, along both axes."""

    grid_step: float

    def __init__(self, settings: FilmSettings):
        width, height = settings.width, settings.height
        self.zoom = max(min(width / 1280, height / 720), SMALLEST_LETTERS)
        dots = FILM_DPI * self.zoom
        # A little more than the pixels, as matplotlib cuts off what is left of a pixel.
        size = (width + 0.01) / dots, (height + 0.01) / dots
        self.figure = Figure(figsize=size, dpi=dots)
        self.figure.set_layout_engine("none")  # whatever the style in use
        self.canvas: Any = FigureCanvasAgg(self.figure)  # matplotlib's has no types
        left, right, below, above = (inches * dots for inches in MARGINS)
        self.size = width - left - right, height - below - above  # of the axes, in pixels
        self._place = left / width, below / height, self.size[0] / width, self.size[1] / height
        self.axes = self.figure.add_axes(self._place)
        self.axes.grid(visible=False)

    @property
    def aspect(self) -> float:
        """Width over height of what is seen."""
        return self.size[0] / self.size[1]

    def set_limits(self, camera: Camera) -> None:
        """Show what the camera sees, with a grid where the camera stands still."""
        axes = self.axes
        low, high = camera.middle - camera.half, camera.middle + camera.half
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        axes.update_datalim([low, high])  # by which matplotlib sizes the arrow of the key
        self.grid_step = _round_up(SPACING * self.figure.dpi / self.pixels_per_metre(camera))
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MultipleLocator(self.grid_step))
        axes.tick_params(colors=INK, labelsize=9)
        for spine in axes.spines.values():
            spine.set_color(GUIDE)
        if camera.view == "fixed":
            axes.grid(**GRID_STYLE)
            axes.set_axisbelow(True)
            names = (_axis_label("x", camera.origin[0, 0]), _axis_label("y", camera.origin[0, 1]))
        elif camera.view == "centre":
            names = ("x from the centre of gravity [m]", "y from the centre of gravity [m]")
        else:
            names = ("along the principal axis of the smaller moment [m]", "across [m]")
        axes.set_xlabel(names[0], color=INK, fontsize=10)
        axes.set_ylabel(names[1], color=INK, fontsize=10)

    def set_title(self, scene: Scene, speed: float) -> None:
        """Write the name of the scene, and the speed of the film."""
        left, top = self._place[0], self._place[1] + self._place[3]
        top += 0.12 / self.figure.get_figheight()
        self.figure.text(left, top, scene.name, color=INK, fontsize=14, weight="bold")
        if speed != 1:
            shown = f"{speed:.3g} times real time" if speed > 1 else f"slowed {1 / speed:.3g} times"
            place: dict[str, Any] = {"transform": self.axes.transAxes, "va": "bottom"}
            self.axes.text(0.012, 0.02, shown, color=INK, fontsize=9, **place)

    def add_colours(self, label: str, limit: float, largest: float) -> None:
        """Add the colour bar; limit: value at its ends; largest: value that occurs."""
        colours = ScalarMappable(moment_norm(limit), MOMENTS)
        (right, low), height = self.panel_corner, self._place[3]
        place = right, low + 0.45 * height, 0.16 / self.figure.get_figwidth(), 0.55 * height
        beyond = "both" if largest > 1.001 * limit else "neither"
        bar = self.figure.colorbar(colours, cax=self.figure.add_axes(place), extend=beyond)
        bar.set_label(label, color=INK, fontsize=10)
        bar.ax.tick_params(colors=INK, labelsize=9)
        bar.outline.set_edgecolor(GUIDE)

    def add_legend(
        self, first: tuple[str, str], bodies: bool, loads: Sequence[str], view: str
    ) -> None:
        """Add a legend of marks, trails and arrows, and of the grid where its lines have no
        numbers; first: mark and name of joint 0."""
        marks = [
            Line2D([], [], color=INK, linewidth=0, marker=first[0], markersize=6, label=first[1]),
            Line2D([], [], color=TAIL, marker="o", markersize=6, label="tail"),
            Line2D([], [], color=CENTRE, marker="o", markersize=6, label="centre of gravity"),
        ]
        marks[-1].set(markerfacecolor=PAPER, markeredgewidth=2)
        if bodies:
            disc = Line2D([], [], color=BODY, marker="o", markersize=9, markeredgecolor=INK)
            disc.set(linewidth=0, label="bodies, by mass")
            marks.append(disc)
        for name in loads:
            load = TERMS[name]
            mark = r"$\circlearrowleft$" if load.kind == COUPLE else r"$\rightarrow$"
            line = Line2D([], [], color=load.colours[0], linewidth=0, marker=mark)
            line.set(markersize=10 if load.kind == COUPLE else 16, label=load.label)
            marks.append(line)
        if view != "fixed":
            marks.append(Line2D([], [], color=GUIDE, label=f"grid of {self.grid_step:g} m"))
        place = self.panel_corner[0], self.panel_corner[1] + KEY / self.figure.get_figheight()
        self.figure.legend(
            handles=marks,
            loc="lower left",
            bbox_to_anchor=place,
            frameon=False,
            fontsize=9,
            labelcolor=INK,
            borderpad=0,
            borderaxespad=0,
        )

    def add_couple_key(self, largest: float) -> None:
        """Add a line on the scale of curved arrows; largest: moment of the longest [N m]."""
        left, low = self.panel_corner
        text = f"3/4 of a circle: {largest:.3g} N m"
        low -= COUPLE_KEY / self.figure.get_figheight()
        self.figure.text(left, low, text, color=INK, fontsize=9)

    def pixels_per_metre(self, camera: Camera) -> float:
        """Return the scale of the picture."""
        return self.size[1] / (2 * float(camera.half[1]))

    def add_lines(self, **style: Any) -> LineCollection:
        """Add lines that are drawn on request, as are all artists that follow."""
        made = LineCollection([], animated=True, **style)
        self.axes.add_collection(made, autolim=False)
        return made

    def add_line(self, color: str, **style: Any) -> Line2D:
        """Add one line through many points."""
        made = Line2D([], [], color=color, animated=True, **style)
        self.axes.add_line(made)
        return made

    def add_mark(
        self, shape: tuple[str, float], face: str, edge: str, width: float = 0.9
    ) -> Line2D:
        """Add a mark at every point; shape: matplotlib's marker and its size in points."""
        style = {"marker": shape[0], "markersize": shape[1], "markeredgewidth": width}
        return self.add_line(edge, linewidth=0, markerfacecolor=face, **style)

    def add_clock(self) -> Text:
        """Add text in the upper left corner of the axes."""
        place: dict[str, Any] = {"transform": self.axes.transAxes, "va": "top", "animated": True}
        return self.axes.text(0.012, 0.98, "", color=INK, fontsize=12, **place)

    def draw_background(self) -> Any:
        """Draw all that stands still, and return it for canvas.restore_region."""
        self.canvas.draw()
        return self.canvas.copy_from_bbox(self.figure.bbox)

    @property
    def panel_corner(self) -> tuple[float, float]:
        """Lower left corner of the panel beside the axes, as shares of the figure."""
        gap = 0.25 / self.figure.get_figwidth()
        return self._place[0] + self._place[2] + gap, self._place[1]


def _round_up(least: float) -> float:
    """Return the smallest of 1, 2 or 5 times a power of ten that is not below."""
    unit = 10.0 ** math.floor(math.log10(least))
    return unit * next(digit for digit in (1, 2, 5, 10) if digit * unit >= least)


def _axis_label(name: str, origin: float) -> str:
    """Return the label of an axis whose zero is at its origin."""
    if not origin:
        return f"{name} [m]"
    return f"{name} {'-' if origin > 0 else '+'} {abs(origin):.15g} m [m]"
