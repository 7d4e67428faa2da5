"""The picture of the rod, what it shows, and kicks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from rodgen.scene import Scene, SceneError
from rodgen.view.live.web.elements import SHOWN, RodCanvas
from rodgen.view.live.web.entry import Entry, number, plain

if TYPE_CHECKING:
    from rodgen.view.live.web.page import Page

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
        self.strength = page.scene.rod.mass  # N s for a metre that is dragged
        with ui.element("section").classes("rg-rod").props('aria-label="The rod"'):
            with ui.element("div").classes("rg-tools"):
                self._tools()
            self.canvas = RodCanvas(label="The rod, drawn live", view=self.view.value)
            self.canvas.classes("rg-canvas")
        self.canvas.on_kick(self._kicked)
        self.canvas.on_link(self._link)
        self._identity: object = None

    def _tools(self) -> None:
        first = "centre" if self.page.scene.hold.translates else "fixed"  # else it flies out
        self.view = ui.select(VIEWS, value=first, label="View", on_change=self._view)
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
        self.kick = ui.switch("kick", on_change=self._kicking).props("dense")
        with self.kick:
            ui.tooltip("Drag from a link to kick it, or click it to type the impulse")
        self.per_metre = Entry(
            "N s per metre dragged", plain(self.strength), self._strength, key="kick strength"
        )
        self.per_metre.field.classes("rg-strength")
        self.per_metre.field.set_visibility(False)

    def refresh(self) -> None:
        """As the scene is now."""
        scene = self.page.scene
        identity = (id(self.page.run.model), scene.rod.boundary, scene.rod.clamp_angle)
        if identity != self._identity:
            self._identity = identity
            self.canvas.rod(str(hash(identity)), scene.rod.boundary, scene.rod.clamp_angle or 0.0)
            for name, term in TERMS.items():
                self.switches[name].set_visibility(term in scene.structure.terms)
            self.per_metre.show(plain(scene.rod.mass))
            self.strength = scene.rod.mass
            self.canvas.set(label=_described(scene))

    def _view(self, event: ValueChangeEventArguments[Any]) -> None:
        self.canvas.set(view=event.value)

    def _shows(self, name: str) -> Any:
        return lambda event: self.canvas.show(**{name: bool(event.value)})

    def _kicking(self, event: ValueChangeEventArguments[Any]) -> None:
        self.canvas.set(kick=bool(event.value))
        self.per_metre.field.set_visibility(bool(event.value))

    async def _strength(self, text: str) -> None:
        self.strength = number(text, "kick strength")

    def _kicked(self, event: dict[str, Any]) -> None:
        impulse = (float(event["dx"]) * self.strength, float(event["dy"]) * self.strength)
        self._kick(int(event["link"]), float(event["share"]), impulse)

    def _kick(self, link: int, share: float, impulse: tuple[float, float]) -> None:
        self.page.soon(lambda: self.page.run.kick(link, share, impulse))

    def _link(self, event: dict[str, Any]) -> None:
        """A link was clicked: in kick mode, its impulse can be typed."""
        link, share = int(event["link"]), float(event["share"])
        if not self.kick.value:
            self.page.say(f"Link {link}, at {100 * share:.0f} % of its length", "info")
            return
        with self.page.root, ui.dialog() as dialog, ui.card():
            ui.label(f"Kick link {link} at {100 * share:.0f} % of its length").classes("rg-title")
            x = ui.input("impulse along x [N s]", value="0").props("dense outlined autofocus")
            y = ui.input("impulse along y [N s]", value=plain(self.strength / 10))
            y.props("dense outlined")

            def kick() -> None:
                for field in (x, y):
                    field.error = None
                try:
                    impulse = (number(x.value, "x"), number(y.value, "y"))
                except SceneError as error:
                    (x if error.field == "x" else y).error = "must be a number"
                    return
                dialog.close()
                self._kick(link, share, impulse)

            with ui.row():
                ui.button("Kick", on_click=kick)
                ui.button("Cancel", on_click=dialog.close).props("flat")
        dialog.on("hide", dialog.delete)
        dialog.open()


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
