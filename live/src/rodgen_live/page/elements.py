"""The components of the page: keys, connection, picture of the rod, plots (static/).

Which arrays a message carries: message.py. What window.rodgenLive tells in the page: hub.js.
Every element of the page with data-text="key" shows the text of that key; the connection itself
writes the key "connection", empty while it stands.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import nicegui
from nicegui import ui
from nicegui.element import Element

from rodgen.model.palette import DARK, LIGHT, Colours, colours_of
from rodgen.model.term import AIR, COUPLE, DRAG, FORCE, SPREAD, WEIGHT
from rodgen.model.terms import TERMS

STATIC = Path(__file__).parents[1] / "static"
LIBRARY = Path(nicegui.__file__).parent / "static"
SHEETS = "vendor/uPlot.min.css", "page.css"
ICONS = STATIC / "vendor" / "icons.woff2"  # made by `--update` of live/tests/test_appearance.py
ICON_FONT = re.compile(r'"Material Icons";[^}]*url\([\'"]?(.*?)[\'"]?\)')
TOOLS = LOOK, KICK, PULL = "look", "kick", "pull"  # what dragging from a link does


class Layer(NamedTuple):
    """Layer of the picture: its label, whether it is shown at first, and the term that a scene must
    have for it."""

    label: str
    shown: bool = True
    term: str | None = None


# How the picture draws a load, by what it acts on.
ARROWS = {FORCE: "point", AIR: "point", WEIGHT: "mass", COUPLE: "link"}
ARROWS |= dict.fromkeys((DRAG, SPREAD), "joints")
LOADS = {name: term for name, term in TERMS.items() if term.kind in ARROWS}
LAYERS = {
    "bending": Layer("bending moment, as colour"),
    "joints": Layer("joints"),
    "ends": Layer("names of the ends"),
    "cg": Layer("centre of gravity"),
    "axes": Layer("principal axes of inertia", shown=False),
    **{name: Layer(term.label, not term.is_damping, name) for name, term in LOADS.items()},
    "trail": Layer("trail of tail and centre of gravity"),
    "grid": Layer("grid"),
    "beside": Layer("run that is kept: beside, not behind", shown=False),
}
# Props of the picture at first, beside those that follow from its scene.
FIRST: dict[str, Any] = {
    "show": {name: layer.shown for name, layer in LAYERS.items()},
    "view": "fixed",
    "tool": PULL,
    "hold": False,
    "perMetre": 0.0,
    "times": 1,
    "mode": None,
}


def icon_font() -> str | None:
    """Path in LIBRARY of the font of all icons that there are, or None."""
    found = ICON_FONT.search((LIBRARY / "fonts.css").read_text("utf-8"))
    return found[1] if found else None


def style_sheet() -> str:
    """Style sheet of a page: colours, that of the plots, and its own."""
    colours = f"body {{ {_as_css(LIGHT)} }}\nbody.body--dark {{ {_as_css(DARK)} }}\n"
    return colours + "\n".join((STATIC / sheet).read_text(encoding="utf-8") for sheet in SHEETS)


class Component(Element):
    """An element with props of these names (see static/)."""

    def __init__(self, **props: Any) -> None:
        super().__init__()
        self._props.update(props)


class Keys(Component, component=STATIC / "keys.js"):
    """Keys of the whole page, by name as in KeyboardEvent.key, and what each of them does. Controls
    keep the keys that they use themselves, and the browser its shortcuts.

    Props: keys, and held: those that count again while they are held down. Events: "key" {key}.
    """

    def __init__(self, does: Mapping[str, Callable[[], object]], held: str = "") -> None:
        super().__init__(keys=list(does), held=list(held))
        self.on("key", lambda event: does[event.args["key"]]())


class Aria(Component, component=STATIC / "aria.js"):
    """Corrections to the roles and labels of sliders and lists for screen readers. One a page."""


class Channel(Component, component=STATIC / "channel.js", esm={"rodgen-live": str(STATIC)}):
    """The WebSocket of the page at `address`, relative to the page's own host ("/live?id=..."),
    opened again every 2 s where it is lost. It shows nothing. One a page.

    Props: address.
    """


def arrows_of(names: Iterable[str]) -> list[dict[str, Any]]:
    """Arrows of loads, as the page draws them; layer: by which they are switched on and off."""
    return [
        {
            "term": name,
            "layer": load.base_name,
            "label": load.label,
            "kind": ARROWS[load.kind],
            "colours": load.colours,
        }
        for name, load in ((name, TERMS[name]) for name in names)
        if load.kind in ARROWS
    ]


class RodCanvas(Component, component=STATIC / "rod.js"):
    """The rod as the newest state has it; fills the box that it is given (a height is needed). What
    a state does not have (see message.rod_arrays) is not drawn.

    Props: show {name: bool} (see LAYERS), loads (those that are drawn, as the vocabulary has them),
    bodies [{name, link, along, across, size}] (see scene.link_parts.BodyOutline), ties [{link,
    share, x, y}] (see scene.anchors.SupportPoint), bed [[x, y], [x, y]] of a foundation, obstacles
    [[[x, y], ...]], lines of stops and walls, which push from their right, view
    ("fixed", "centre": the centre of gravity stays where it is, "axes": and the principal axes as
    well), support ("none", "wall", "pin"), restShape [rad], tool (see TOOLS), perMetre
    (of a kick, [N s] for a metre dragged), hold (what pulls stays where it is let go), times (by
    which displacements from the rod at rest are enlarged), mode (a mode shape to draw, see
    page/mode_panel.py), label (for screen readers), rod (any number: another one fits the picture
    anew and clears the scales; another number of links does so too).
    Events: "kick" {link, share, dx, dy}: what was dragged from a link, at `share` (0 start, 1 end),
    in metres; "pull" {link, share, x, y}: it was taken hold of, and the pointer is at that place of
    the world [m]; "move" {x, y}: it is elsewhere; "release": it lets go.
    Methods in the page: fit(), png(name), which has the browser download the picture.
    """


class TimeLine(Component, component=STATIC / "timeline.js"):
    """A slider over the samples of the run with the changes and kicks marked on it, steps of a
    sample to either side, and a loop from A to B; the channel carries where on it the page looks.

    Props: speed [simulated seconds per second] at which it plays.
    Keys, on the slider: see page/toolbar.py.
    """


class Plots(Component, component=STATIC / "plots.js"):
    """Plots in a grid of one to three columns, each with buttons: pause, reset zoom, PNG, CSV,
    remove; and dragged by its head. The page keeps at most 20000 rows of each.

    A plot is zoomed by dragging over it, by the wheel with Ctrl or once it was clicked, by + - and
    arrows; double click or 0 resets. While paused, rows are kept and not shown.

    Props: specs, a list of plots as JSON, in the order shown: {"id", "kind" ("time", "phase",
    "profile", "spectrum", "poincare", "sweep"), "title", "x": {"label", "unit", "log", "least",
    "period", "turn"}, "y": {"label", "unit", "log", "least"}, "series": [{"name", "label", "unit",
    "period", "turn"}], "window": s, "wrapped"}; least: of what moves by less, the scale is that of
    this; period: by what a quantity jumps; turn: the whole turn of an angle, 0 if it has none;
    wrapped: whole turns are not shown; dashed: whether a curve of a sweep is. Events: "removed"
    {id}, "picked" {id, row} (of a sweep, a click on a row), "moved" {ids} (all, in the new order),
    "wrapped" {id, wrapped}: the page has done so already. Method in the page: sweep(id, rows,
    marks), of which marks are lines at some values, with words. Rows that come before their plot
    are kept for it.
    """


def early_scripts() -> str:
    """Script that loads those of the components while the page connects, before it is told of
    them."""
    used: tuple[type[Element], ...] = (*Component.__subclasses__(), ui.select, ui.input)
    place = f"/_nicegui/{nicegui.__version__}/components/"
    keys = [one.component.key for one in used if one.component]
    return f'<script type="module">for (const key of {keys}) import("{place}" + key);</script>'


def _as_css(palette: Colours) -> str:
    """Declarations of custom properties, --rg-NAME: colours with commas between."""
    return " ".join(f"--rg-{name}: {', '.join(colours_of(name, palette))};" for name in palette)
