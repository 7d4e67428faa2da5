"""The components of the page: connection, picture of the rod, plots (static/).

Which arrays a message carries: frames.py. In the page, window.rodgenLive tells what was drawn:
{fps, frames, t, state, connected, milliseconds (of script a frame), plots: {id: {rows, draws}}}.
Every element of the page with data-text="key" shows the text of that key; the connection itself
writes the key "connection", empty while it stands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal

import nicegui.elements.echart  # noqa: F401  ECharts into the import map of the page
from nicegui.element import Element
from nicegui.events import GenericEventArguments

View = Literal["fixed", "centre", "axes"]
Moment = Literal["signed", "absolute"]

# What the picture can show, and whether it does at first.
SHOWN = {
    "moment": True,
    "joints": True,
    "cg": True,
    "axes": False,
    "follower": True,
    "tip": True,
    "gravity": True,
    "damping": False,
    "trail": True,
    "grid": True,
}

Handler = Callable[[dict[str, Any]], None]


def _listen(element: Element, event: str, keys: list[str], handler: Handler) -> None:
    def handle(arguments: GenericEventArguments) -> None:
        handler({key: arguments.args.get(key) for key in keys})

    element.on(event, handle, keys)


class Channel(Element, component="static/channel.js", esm={"rodgen-live": "static"}):
    """The WebSocket of the page at `address`, relative to the page's own host ("/live?id=..."),
    opened again after 1 s to 5 s where it is lost. It shows nothing. One a page.

    Props: address. Events: "connection" {connected}.
    """

    def __init__(self, address: str) -> None:
        super().__init__()
        self._props["address"] = address

    def on_connection(self, handler: Callable[[bool], None]) -> None:
        _listen(self, "connection", ["connected"], lambda e: handler(bool(e["connected"])))


class RodCanvas(Element, component="static/rod.js"):
    """The rod as the newest state has it; fills the box that it is given (a height is needed).

    Arrays of a state: "joints", "moment", "forces:<term>" (follower, tip_load, external_damping),
    and "point": [x, y of the centre of gravity from the origin [m], angle of a principal axis
    [rad], gravity [m/s^2] (left out, or 0, where there is none)]. An array without numbers takes
    its drawing away.

    Props: show {name: bool} (see SHOWN), view ("fixed", "centre": the centre of gravity stays
    where it is, "axes": and the principal axes as well), moment ("signed", "absolute"), support
    (the scene's boundary), clampAngle [rad], kick (dragging from a link draws a kick), label (for
    screen readers), rod (any text: another one fits the picture anew and clears trail and scales;
    another number of links does so too).
    Events: "link" {link, share, x, y}: a link was clicked, at `share` (0 start, 1 end), in metres;
    "kick" {link, share, dx, dy}: what was dragged from there, in metres.
    Methods in the page: fit(), reset_scale(), clear_trail(), png(name).
    """

    def __init__(
        self,
        *,
        support: str = "free",
        clamp_angle: float = 0.0,
        view: View = "fixed",
        moment: Moment = "signed",
        show: Mapping[str, bool] | None = None,
        label: str = "The rod, drawn live",
        rod: str = "",
    ) -> None:
        super().__init__()
        self._props["show"] = SHOWN | dict(show or {})
        self._props["kick"] = False
        self.set(view=view, moment=moment, label=label)
        self.rod(rod, support, clamp_angle)

    def set(self, **props: Any) -> None:
        """Props by name: view, moment, kick, label."""
        self._props.update(props)
        self.update()

    def show(self, **shown: bool) -> None:
        """Switches what is drawn: show(trail=False)."""
        self.set(show={**self._props["show"], **shown})

    def rod(self, identity: str, support: str, clamp_angle: float = 0.0) -> None:
        """Another rod: `identity` is any text that the one before did not have."""
        self.set(rod=identity, support=support, **{"clamp-angle": clamp_angle})

    def fit(self) -> None:
        self.run_method("fit")

    def reset_scale(self) -> None:
        """Colours and arrows from the present state on, not from what came before."""
        self.run_method("reset_scale")

    def clear_trail(self) -> None:
        self.run_method("clear_trail")

    def png(self, name: str = "rod.png") -> None:
        """The browser downloads the picture."""
        self.run_method("png", name)

    def on_link(self, handler: Handler) -> None:
        """handler({"link": int, "share": float, "x": m, "y": m})"""
        _listen(self, "link", ["link", "share", "x", "y"], handler)

    def on_kick(self, handler: Handler) -> None:
        """handler({"link": int, "share": float, "dx": m, "dy": m})"""
        _listen(self, "kick", ["link", "share", "dx", "dy"], handler)


class Plots(Element, component="static/plots.js"):
    """Plots in a grid of one to three columns, each with buttons: pause, reset zoom, PNG, CSV,
    move left, move right, remove; and dragged by its head. The page keeps at most 20000 rows of
    each.

    A plot is zoomed by dragging over it, by the wheel with Ctrl or once it was clicked, by + - and
    arrows; double click or 0 resets. While zoomed or paused, rows are kept and not shown.

    Props: specs, a list of plots as JSON, in the order shown: {"id", "kind" ("time", "phase",
    "profile", "spectrum", "poincare"), "title", "x": {"label", "unit"}, "y": {"label", "unit"},
    "series": [{"name", "label"}], "window": s}.
    Events: "removed" {id}, "moved" {ids} (all, in the new order), "paused" {id, paused}. Removing
    and moving is taken up in specs before a handler is called.
    Rows that come before their plot are kept for it.
    """

    def __init__(self, specs: Iterable[Mapping[str, Any]] = ()) -> None:
        super().__init__()
        self.put([dict(spec) for spec in specs])
        _listen(self, "removed", ["id"], lambda e: self.drop(str(e["id"])))
        _listen(self, "moved", ["ids"], lambda e: self._arrange(e["ids"]))

    @property
    def specs(self) -> list[dict[str, Any]]:
        return list(self._props["specs"])

    def put(self, specs: list[dict[str, Any]]) -> None:
        """All plots, in their order."""
        self._props["specs"] = specs
        self.update()

    def add(self, spec: Mapping[str, Any]) -> None:
        """Adds a plot; one of the same id makes room for it."""
        self.put([*(old for old in self.specs if old["id"] != spec["id"]), dict(spec)])

    def drop(self, plot: str) -> None:
        """Removes the plot of this id, if it is there."""
        self.put([spec for spec in self.specs if spec["id"] != plot])

    def _arrange(self, ids: Any) -> None:
        place = {plot: k for k, plot in enumerate(ids)} if isinstance(ids, list) else {}
        self.put(sorted(self.specs, key=lambda spec: place.get(spec["id"], len(place))))

    def on_removed(self, handler: Callable[[str], None]) -> None:
        _listen(self, "removed", ["id"], lambda e: handler(str(e["id"])))

    def on_moved(self, handler: Callable[[list[str]], None]) -> None:
        _listen(self, "moved", ["ids"], lambda e: handler([str(plot) for plot in e["ids"]]))

    def on_paused(self, handler: Callable[[str, bool], None]) -> None:
        keys = ["id", "paused"]
        _listen(self, "paused", keys, lambda e: handler(str(e["id"]), bool(e["paused"])))
