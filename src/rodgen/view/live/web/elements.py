"""The components of the page: keys, connection, picture of the rod, plots (static/).

Which arrays a message carries: frames.py. In the page, window.rodgenLive tells what was drawn:
{fps, frames, t, state, connected, milliseconds (of script a frame), plots: {id: {rows, draws}}}.
Every element of the page with data-text="key" shows the text of that key; the connection itself
writes the key "connection", empty while it stands.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal

import nicegui.elements.echart  # noqa: F401  ECharts into the import map of the page
from nicegui.element import Element
from nicegui.events import GenericEventArguments

View = Literal["fixed", "centre", "axes"]

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

Handler = Callable[[dict[str, Any]], object]


def _listen(element: Element, event: str, keys: list[str], handler: Handler) -> None:
    def handle(arguments: GenericEventArguments) -> None:
        handler({key: arguments.args.get(key) for key in keys})

    element.on(event, handle, keys)


class Keys(Element, component="static/keys.js"):
    """Keys of the whole page, by name as in KeyboardEvent.key, and what each of them does.
    Controls keep the keys that they use themselves, and the browser its shortcuts.

    Props: keys, and held: those that count again while they are held down.
    Events: "key" {key}.
    """

    def __init__(self, does: Mapping[str, Callable[[], object]], held: str = "") -> None:
        super().__init__()
        self._props.update(keys=list(does), held=list(held))
        _listen(self, "key", ["key"], lambda e: does[e["key"]]())


class Channel(Element, component="static/channel.js", esm={"rodgen-live": "static"}):
    """The WebSocket of the page at `address`, relative to the page's own host ("/live?id=..."),
    opened again after 1 s to 5 s where it is lost. It shows nothing. One a page.

    Props: address.
    """

    def __init__(self, address: str) -> None:
        super().__init__()
        self._props["address"] = address


class RodCanvas(Element, component="static/rod.js"):
    """The rod as the newest state has it; fills the box that it is given (a height is needed).

    Arrays of a state: "joints", "moment", "forces:<term>" (follower, tip_load, external_damping),
    and "point": [x, y of the centre of gravity from the origin [m], angle of a principal axis
    [rad], gravity [m/s^2] (left out, or 0, where there is none)]. What a state does not have is
    not drawn. "trail" are places of the tail and the centre of gravity since the message before,
    "trail!" all of them: [x, y of either in the world [m]] of every sample.

    Props: show {name: bool} (see SHOWN), view ("fixed", "centre": the centre of gravity stays
    where it is, "axes": and the principal axes as well), support (the scene's boundary),
    clampAngle [rad], kick (links can be kicked), perMetre (of a kick, [N s] for a metre dragged),
    label (for screen readers), rod (any number: another one fits the picture anew and clears the
    scales; another number of links does so too).
    Events, both while `kick` is on: "link" {link, share}: a link was clicked, at `share` (0 start,
    1 end); "kick" {link, share, dx, dy}: what was dragged from there, in metres.
    Methods in the page: fit(), reset_scale(), png(name).
    """

    def __init__(self, view: View = "fixed") -> None:
        super().__init__()
        self._props.update(show=dict(SHOWN), view=view, kick=False)

    def set(self, **props: Any) -> None:
        """Props by name: view, kick, perMetre, clampAngle."""
        self._props.update(props)

    def show(self, **shown: bool) -> None:
        """Switches what is drawn: show(trail=False)."""
        self.set(show={**self._props["show"], **shown})

    def rod(self, number: int, support: str, label: str) -> None:
        """Another rod: `number` is other than that of the one before."""
        self.set(rod=number, support=support, label=label)

    def fit(self) -> None:
        self.run_method("fit")

    def reset_scale(self) -> None:
        """Colours and arrows from the present state on, not from what came before."""
        self.run_method("reset_scale")

    def png(self, name: str = "rod.png") -> None:
        """The browser downloads the picture."""
        self.run_method("png", name)

    def on_link(self, handler: Handler) -> None:
        """handler({"link": int, "share": float})"""
        _listen(self, "link", ["link", "share"], handler)

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
    Events: "removed" {id}, "moved" {ids} (all, in the new order). Removing and moving is taken up
    in specs before a handler is called.
    Rows that come before their plot are kept for it.
    """

    def __init__(self) -> None:
        super().__init__()
        self.put([])
        _listen(self, "removed", ["id"], lambda e: self.drop(str(e["id"])))
        _listen(self, "moved", ["ids"], lambda e: self._arrange(e["ids"]))

    @property
    def specs(self) -> list[dict[str, Any]]:
        return list(self._props["specs"])

    def put(self, specs: list[dict[str, Any]]) -> None:
        """All plots, in their order."""
        self._props["specs"] = specs
        self.update()

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
