"""The components of the page: keys, connection, picture of the rod, plots (static/).

Which arrays a message carries: message.py. What window.rodgenLive tells in the page: hub.js.
Every element of the page with data-text="key" shows the text of that key; the connection itself
writes the key "connection", empty while it stands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple

import nicegui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from rodgen.model.palette import DARK, LIGHT, Colours, colours_of
from rodgen.model.term import DRAG, FORCE, SPREAD, WEIGHT
from rodgen.model.terms import TERMS

STATIC = Path(__file__).parents[1] / "static"
LIBRARY = Path(nicegui.__file__).parent / "static"
SHEETS = "vendor/uPlot.min.css", "page.css"
ICONS = STATIC / "vendor" / "icons.woff2"  # made by `--update` of tests/live/test_appearance.py
View = Literal["fixed", "centre", "axes"]
TOOLS = LOOK, KICK, PULL = "look", "kick", "pull"  # what dragging from a link does


class Layer(NamedTuple):
    """Layer of the picture: its label, whether it is shown at first, and the term that a scene must
    have for it."""

    label: str
    shown: bool = True
    term: str | None = None


# How the picture draws a load, by what it acts on.
ARROWS = {FORCE: "point", WEIGHT: "mass", DRAG: "joints", SPREAD: "joints"}
LOADS = {name: term for name, term in TERMS.items() if term.kind in ARROWS}
LAYERS = {
    "moment": Layer("bending moment, as colour"),
    "joints": Layer("joints"),
    "ends": Layer("names of the ends"),
    "cg": Layer("centre of gravity"),
    "axes": Layer("principal axes of inertia", shown=False),
    **{name: Layer(term.label, not term.is_damping, name) for name, term in LOADS.items()},
    "trail": Layer("trail of tail and centre of gravity"),
    "grid": Layer("grid"),
    "beside": Layer("run that is kept: beside, not behind", shown=False),
}

SHOWN = {name: layer.shown for name, layer in LAYERS.items()}  # at first


def style_sheet() -> str:
    """Style sheet of a page: colours, that of the plots, and its own."""
    colours = f"body {{ {_as_css(LIGHT)} }}\nbody.body--dark {{ {_as_css(DARK)} }}\n"
    return colours + "\n".join((STATIC / sheet).read_text(encoding="utf-8") for sheet in SHEETS)


Handler = Callable[[dict[str, Any]], object]


def _listen(element: Element, event: str, keys: list[str], handler: Handler) -> None:
    def handle(arguments: GenericEventArguments) -> None:
        handler({key: arguments.args.get(key) for key in keys})

    element.on(event, handle, keys)


class Keys(Element, component=STATIC / "keys.js"):
    """Keys of the whole page, by name as in KeyboardEvent.key, and what each of them does. Controls
    keep the keys that they use themselves, and the browser its shortcuts.

    Props: keys, and held: those that count again while they are held down. Events: "key" {key}.
    """

    def __init__(self, does: Mapping[str, Callable[[], object]], held: str = "") -> None:
        super().__init__()
        self._props.update(keys=list(does), held=list(held))
        _listen(self, "key", ["key"], lambda e: does[e["key"]]())


class Aria(Element, component=STATIC / "aria.js"):
    """Corrections to the roles and labels of sliders and lists for screen readers. One a page."""


class Channel(Element, component=STATIC / "channel.js", esm={"rodgen-live": str(STATIC)}):
    """The WebSocket of the page at `address`, relative to the page's own host ("/live?id=..."),
    opened again after 1 s to 5 s where it is lost. It shows nothing. One a page.

    Props: address.
    """

    def __init__(self, address: str) -> None:
        super().__init__()
        self._props["address"] = address


def arrows_of(names: Iterable[str]) -> list[dict[str, Any]]:
    """Arrows of loads, as the page draws them; layer: by which they are switched on and off."""
    loads = ((name, TERMS[name]) for name in names)
    return [
        {
            "term": name,
            "layer": load.base_name,
            "label": load.label,
            "kind": ARROWS[load.kind],
            "colours": load.colours,
        }
        for name, load in loads
        if load.kind in ARROWS
    ]


class RodCanvas(Element, component=STATIC / "rod.js"):
    """The rod as the newest state has it; fills the box that it is given (a height is needed).

    Arrays of a state: "joints", "omega" of the links, "moment", "forces:<term>" (of a load that
    acts on joints), and "point": [x, y of the centre of gravity from the origin [m], angle of a
    principal axis [rad], gravity [m/s^2] (left out, or 0, where there is none)]. What a state does
    not have is not drawn. "trail" are places of the tail and the centre of gravity since
    the message before, "trail!" all of them: [x, y of either in the world [m], t [s]] of every
    sample.

    Props: show {name: bool} (see LAYERS), loads (those that are drawn, as the vocabulary has them),
    bodies [{name, link, along, across, size}] (see scene.distribution.BodyOutline), ties [{link,
    share, x, y}] (see scene.anchors.SupportPoint), bed [[x, y], [x, y]] of a foundation, view
    ("fixed", "centre": the centre of gravity stays where it is, "axes": and the principal axes as
    well), support ("none", "wall", "pin"), clampAngle [rad], tool (one of TOOLS), perMetre
    (of a kick, [N s] for a metre dragged), hold (what pulls stays where it is let go), times (by
    which displacements from the straight rod are drawn larger), mode (a mode shape to draw, see
    page/mode_panel.py), label (for screen readers), rod (any number: another one fits the picture
    anew and clears the scales; another number of links does so too).
    Events: "kick" {link, share, dx, dy}: what was dragged from a link, at `share` (0 start, 1 end),
    in metres; "pull" {link, share, x, y}: it was taken hold of, and the pointer is at that place of
    the world [m]; "move" {x, y}: it is elsewhere; "release": it lets go.
    Methods in the page: fit(), png(name).
    """

    def __init__(self, view: View = "fixed") -> None:
        super().__init__()
        self._props.update(show=dict(SHOWN), loads=arrows_of(LOADS), view=view, tool=PULL)
        self._props.update(
            bodies=[], ties=[], bed=[], clampAngle=0.0, perMetre=0.0, times=1, mode=None
        )
        self._props.update(hold=False)

    def set_props(self, **props: Any) -> None:
        """Set props by name: bodies, ties, bed, view, tool, perMetre, hold, times, mode,
        clampAngle."""
        self._props.update(props)

    def show(self, **shown: bool) -> None:
        """Switch layers on or off: show(trail=False)."""
        self.set_props(show={**self._props["show"], **shown})

    def show_rod(self, number: int, support: str, label: str, loads: Iterable[str]) -> None:
        """Show another rod, with loads of these names; `number` is other than that of the one
        before."""
        self.set_props(rod=number, support=support, label=label, loads=arrows_of(loads))

    def fit(self) -> None:
        self.run_method("fit")

    def png(self, name: str = "rod.png") -> None:
        """Have the browser download the picture."""
        self.run_method("png", name)

    def on_kick(self, handler: Handler) -> None:
        """Call handler({"link": int, "share": float, "dx": m, "dy": m}) after a drag."""
        _listen(self, "kick", ["link", "share", "dx", "dy"], handler)

    def on_pull(self, handler: Handler, moved: Handler, released: Handler) -> None:
        """Call handler({"link": int, "share": float, "x": m, "y": m}) when a link is taken hold of,
        moved({"x": m, "y": m}) as the pointer moves, and released({}) when it lets go."""
        _listen(self, "pull", ["link", "share", "x", "y"], handler)
        _listen(self, "move", ["x", "y"], moved)
        _listen(self, "release", [], released)


class Plots(Element, component=STATIC / "plots.js"):
    """Plots in a grid of one to three columns, each with buttons: pause, reset zoom, PNG, CSV,
    remove; and dragged by its head. The page keeps at most 20000 rows of
    each.

    A plot is zoomed by dragging over it, by the wheel with Ctrl or once it was clicked, by + - and
    arrows; double click or 0 resets. While paused, and while zoomed after a run has begun anew,
    rows are kept and not shown.

    Props: specs, a list of plots as JSON, in the order shown: {"id", "kind" ("time", "phase",
    "profile", "spectrum", "poincare", "sweep"), "title", "x": {"label", "unit", "log", "least",
    "period", "turn"}, "y": {"label", "unit", "log", "least"}, "series": [{"name", "label", "unit",
    "period", "turn"}], "window": s, "wrapped"}; log: whether the axis is logarithmic; least: of
    what moves by less, the scale is that of this; period: by what a quantity jumps; turn: the whole
    turn of an angle, 0 if it has none; wrapped: whole turns are not shown.
    dashed: whether a curve of a sweep is. Events: "removed" {id}, "picked" {id, row} (of a sweep, a
    click on a row), "moved" {ids} (all, in the new order), "wrapped" {id, wrapped}. They are
    taken up in specs before a handler is called.
    Rows that come before their plot are kept for it.
    """

    def __init__(self) -> None:
        super().__init__()
        self.set_specs([])
        _listen(self, "removed", ["id"], lambda e: self.drop(str(e["id"])))
        _listen(self, "moved", ["ids"], lambda e: self._arrange(e["ids"]))
        _listen(self, "wrapped", ["id", "wrapped"], lambda e: self._wrap(e["id"], e["wrapped"]))

    @property
    def specs(self) -> list[dict[str, Any]]:
        return list(self._props["specs"])

    def set_specs(self, specs: list[dict[str, Any]]) -> None:
        """Show these plots, in their order."""
        self._props["specs"] = specs
        self.update()

    def draw(self, plot: str, rows: list[float | None], marks: list[float]) -> None:
        """Draw the rows of a sweep, and lines at some values."""
        self.run_method("sweep", plot, rows, marks)

    def drop(self, plot: str) -> None:
        """Remove the plot of this id, if it is there."""
        self.set_specs([spec for spec in self.specs if spec["id"] != plot])

    def _arrange(self, ids: Any) -> None:
        place = {plot: k for k, plot in enumerate(ids)} if isinstance(ids, list) else {}
        self.set_specs(sorted(self.specs, key=lambda spec: place.get(spec["id"], len(place))))

    def _wrap(self, plot: Any, wrapped: Any) -> None:
        one = {"wrapped": bool(wrapped)}
        self.set_specs([spec | one if spec["id"] == plot else spec for spec in self.specs])

    def on_remove(self, handler: Callable[[str], None]) -> None:
        _listen(self, "removed", ["id"], lambda e: handler(str(e["id"])))

    def on_pick(self, handler: Callable[[str, int], None]) -> None:
        _listen(self, "picked", ["id", "row"], lambda e: handler(str(e["id"]), int(e["row"])))

    def on_move(self, handler: Callable[[list[str]], None]) -> None:
        _listen(self, "moved", ["ids"], lambda e: handler([str(plot) for plot in e["ids"]]))

    def on_wrap(self, handler: Callable[[str, bool], None]) -> None:
        _listen(
            self, "wrapped", ["id", "wrapped"], lambda e: handler(str(e["id"]), bool(e["wrapped"]))
        )


def _as_css(palette: Colours) -> str:
    """Declarations of custom properties, --rg-NAME: colours with commas between."""
    return " ".join(f"--rg-{name}: {', '.join(colours_of(name, palette))};" for name in palette)
