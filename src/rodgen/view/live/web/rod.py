"""The picture of the rod, what it shows, and kicks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import app, ui
from nicegui.events import ValueChangeEventArguments

from rodgen.scene import Scene
from rodgen.view.live.web.elements import SHOWN, RodCanvas, View
from rodgen.view.live.web.entry import Entry, number, plain
from rodgen.view.live.web.kick_dialog import KickDialog

if TYPE_CHECKING:
    from rodgen.view.live.web.page import Page

VIEW = "view"  # chosen by the tab of a browser, which keeps it over a reload
VIEWS = {"fixed": "fixed", "centre": "follows the centre of gravity", "axes": "turns with the axes"}
NAMES = {
    "moment": "bending moment, as colour",
    "joints": "joints",
    "cg": "centre of gravity",
    "axes": "principal axes of inertia",
    "follower": "follower force",
    "tip": "tip load",
    "gravity": "gravity",
    "damping": "damping forces",
    "trail": "trail of tail and centre of gravity",
    "grid": "grid",
}
TERMS = {
    "follower": "follower",
    "tip": "tip_load",
    "gravity": "gravity",
    "damping": "external_damping",
}


class RodPanel:
    """The canvas with its tools."""

    def __init__(self, page: Page):
        self.page = page
        self._taken, self._angle = 0, 0.0  # of the run's scenes, and how the rod is clamped [rad]
        with ui.element("section").classes("rg-rod").props('aria-label="The rod"'):
            with ui.element("div").classes("rg-tools"):
                self._tools()
            self.canvas = RodCanvas(self.view.value)
            self.canvas.classes("rg-canvas")
        self.canvas.on_kick(self._dragged)
        self.canvas.on_link(lambda event: self._ask(int(event["link"]), float(event["share"])))

    def _tools(self) -> None:
        self._first = _first_view(self.page.scene)
        self.view = ui.select(VIEWS, value=app.storage.tab.get(VIEW, self._first), label="View")
        self.view.on_value_change(self._view)
        self.view.props("dense outlined options-dense").classes("rg-view")
        with _tool("layers", "What is shown"), ui.menu().props("auto-close=false"):
            self.switches = {
                name: ui.switch(text, value=SHOWN[name], on_change=self._shows(name)).props("dense")
                for name, text in NAMES.items()
            }
            for switch in self.switches.values():
                switch.classes("rg-switch")
        _tool("fit_screen", "Fit the rod into the picture").on_click(lambda: self.canvas.fit())
        _tool("palette", "Scale colours anew").on_click(lambda: self.canvas.reset_scale())
        _tool("photo_camera", "Save the picture as PNG").on_click(
            lambda: self.canvas.png(f"{self.page.scene.name}.png")
        )
        kick = ui.switch("kick by dragging", on_change=self._kicking).props("dense")
        with kick:
            ui.tooltip("Drag from a link to kick it, or click it to type the impulse")
        self.per_metre = Entry("N s per metre dragged", "", self._strength)
        self.per_metre.field.classes("rg-strength")
        self.per_metre.field.set_visibility(False)
        ui.button("Kick…", on_click=self._ask_tail).props("flat dense no-caps")

    def refresh(self) -> None:
        """As the scene is now."""
        run, scene = self.page.run, self.page.scene
        angle = scene.rod.clamp_angle or 0.0
        if angle != self._angle:
            self._angle = angle
            self.canvas.set(clampAngle=angle)
        if run.taken != self._taken:
            self._taken = run.taken
            self._another(scene)

    def _another(self, scene: Scene) -> None:
        """Another scene."""
        view = _first_view(scene)
        if view != self._first:  # what was chosen for a rod that flies is not for one that is held
            self._first = view
            self.view.set_value(view)
        self.canvas.rod(self._taken, scene.rod.boundary, _described(scene))
        for name, term in TERMS.items():
            self.switches[name].set_visibility(term in scene.structure.terms)
        self._set_strength(scene.rod.mass)
        self.per_metre.show(plain(self.strength))

    def _view(self, event: ValueChangeEventArguments[Any]) -> None:
        app.storage.tab[VIEW] = event.value
        self.canvas.set(view=event.value)

    def _shows(self, name: str) -> Any:
        return lambda event: self.canvas.show(**{name: bool(event.value)})

    def _kicking(self, event: ValueChangeEventArguments[Any]) -> None:
        self.canvas.set(kick=bool(event.value))
        self.per_metre.field.set_visibility(bool(event.value))

    async def _strength(self, text: str) -> None:
        self._set_strength(number(text, "kick strength"))

    def _set_strength(self, strength: float) -> None:
        """N s for a metre that is dragged."""
        self.strength = strength
        self.canvas.set(perMetre=strength)

    def _dragged(self, event: dict[str, Any]) -> None:
        link, share = int(event["link"]), float(event["share"])
        impulse = (float(event["dx"]) * self.strength, float(event["dy"]) * self.strength)
        self.page.soon(lambda: self.page.run.kick(link, share, impulse))

    async def _kick(self, link: int, share: float, impulse: tuple[float, float]) -> None:
        await self.page.do(lambda: self.page.run.kick(link, share, impulse))

    def _ask(self, link: int, share: float) -> None:
        """For a kick in numbers; link, share: where it is, if nothing else is typed."""
        links, strength = self.page.scene.rod.links, self.strength / 10
        with self.page.root:
            KickDialog(links, link, share, strength, self._kick)

    def _ask_tail(self) -> None:
        self._ask(self.page.scene.rod.links - 1, 1.0)


def _first_view(scene: Scene) -> View:
    """The one in which a rod stays in the picture."""
    return "centre" if scene.hold.translates else "fixed"


def _tool(icon: str, label: str) -> ui.button:
    button = ui.button(icon=icon).props(f'flat round dense aria-label="{label}"')
    with button:
        ui.tooltip(label)
    return button


def _described(scene: Scene) -> str:
    """For who does not see the picture."""
    terms = ", ".join(term.replace("_", " ") for term in scene.structure.terms) or "no loads"
    return (
        f"{scene.name}: rod of {scene.rod.links} links, {scene.rod.boundary}, {terms}, drawn "
        "live; its numbers are in the panel of values. Arrows move, + and - zoom, 0 fits."
    )
