"""The picture of the rod, what it shows, and kicks and pulls by dragging or in numbers."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from rodgen.scene import Scene
from rodgen.scene.model_contents import describe_loads
from rodgen_live.page.elements import LAYERS, PULL, TOOLS, RodCanvas, View
from rodgen_live.page.fields import Entry, IconButton, format_number, parse_number
from rodgen_live.page.mode_panel import ModePanel
from rodgen_live.page.page_run import VIEW, PageRun
from rodgen_live.page.point_dialog import PointDialog
from rodgen_live.page.pulls import PullControls

SHOWN = "What is shown"
MENU = 'auto-close=false role=dialog aria-label="%s"'
TUNED = "Kicks and pulls: strength, spring, in numbers"
ENLARGED = {1: "as they are", 10: "× 10", 100: "× 100", 1000: "× 1000", 10_000: "× 10 000"}
VIEWS = {"fixed": "fixed", "centre": "follows the centre of gravity", "axes": "turns with the axes"}


class RodPanel:
    """Panel of the rod: the canvas with its tools."""

    def __init__(self, page: PageRun):
        self.page = page
        self._taken = 0  # of the run's scenes
        self._drawn: dict[str, Any] = {}
        with ui.element("section").classes("rg-rod").props('aria-label="The rod"'):
            tools = ui.element("div").classes("rg-tools")
            self._first = first_view(self.page.scene)
            self.canvas = RodCanvas(page.tab.get(VIEW, self._first))
            self.canvas.classes("rg-canvas")
            with tools:
                self._build_tools()
        self.canvas.on_kick(self._on_drag)

    def _build_tools(self) -> None:
        self.view = ui.select(VIEWS, value=self.page.tab.get(VIEW, self._first), label="View")
        self.view.on_value_change(self._set_view)
        self.view.props("dense outlined options-dense").classes("rg-view")
        self.times = ui.select(ENLARGED, value=1, label="Displacements")
        self.times.on_value_change(lambda event: self.canvas.set_props(times=event.value))
        self.times.props("dense outlined options-dense").classes("rg-times")
        with IconButton("layers", SHOWN), ui.menu().props(MENU % SHOWN):
            self.switches = {
                name: ui.switch(layer.label, value=layer.shown, on_change=self._layer_handler(name))
                for name, layer in LAYERS.items()
            }
            for switch in self.switches.values():
                switch.props("dense").classes("rg-switch")
        self.modes = ModePanel(self.page, lambda mode: self.canvas.set_props(mode=mode))
        IconButton("fit_screen", "Fit the rod into the picture", lambda: self.canvas.fit())
        IconButton(
            "photo_camera",
            "Save the picture as PNG",
            lambda: self.canvas.png(f"{self.page.scene.name}.png"),
        )
        tool = ui.toggle(list(TOOLS), value=PULL).props('dense no-caps unelevated role="group"')
        tool.props('aria-label="What dragging from a link does"').classes("rg-tool")
        tool.props("toggle-color=none toggle-text-color=none")  # as other buttons that are pressed
        tool.on_value_change(lambda event: self.canvas.set_props(tool=event.value))
        with IconButton("tune", TUNED), ui.menu().props(MENU % TUNED).classes("rg-tuned"):
            self.per_metre = Entry("kick [N s] per metre dragged", "", self._put_strength)
            ui.button("Kick in numbers…", on_click=self._ask).props("flat dense no-caps")
            self.pulls = PullControls(self.page, self.canvas)
        self.free = ui.button("Let go", on_click=self.pulls.release).props("flat dense no-caps")

    def refresh(self) -> None:
        """Show the scene as it is now."""
        run, scene = self.page.run, self.page.scene
        drawn = scene_props(scene)
        if drawn != self._drawn:
            self._drawn = drawn
            self.canvas.set_props(**drawn)
        if run.taken != self._taken:
            self._taken = run.taken
            self._set_scene(scene)
        self.free.set_enabled(run.live.pulling is not None)

    def _set_scene(self, scene: Scene) -> None:
        """Show another scene."""
        self.modes.hide()
        view = first_view(scene)
        if view != self._first:  # what was chosen for a rod that flies is not for one that is held
            self._first = view
            self.view.set_value(view)
        support, terms = scene.boundary_condition.start_drawing, scene.loads.terms
        self.canvas.show_rod(self._taken, support, description(scene), terms)
        for name, switch in self.switches.items():
            term = LAYERS[name].term
            switch.set_visibility(term is None or term in scene.loads.terms)
        self._set_strength(scene.mass)
        self.per_metre.show(format_number(self.strength))
        self.pulls.set_scene(scene)

    def _set_view(self, event: ValueChangeEventArguments[Any]) -> None:
        self.page.tab[VIEW] = event.value
        self.canvas.set_props(view=event.value)

    def _layer_handler(self, name: str) -> Any:
        return lambda event: self.canvas.show(**{name: bool(event.value)})

    async def _put_strength(self, text: str) -> None:
        self._set_strength(parse_number(text, "kick strength"))

    def _set_strength(self, strength: float) -> None:
        """Set the impulse of kicks for a metre that is dragged [N s]."""
        self.strength = strength
        self.canvas.set_props(perMetre=strength)

    def _on_drag(self, event: dict[str, Any]) -> None:
        link, share = int(event["link"]), float(event["share"])
        impulse = (float(event["dx"]) * self.strength, float(event["dy"]) * self.strength)
        self.page.submit(lambda: self.page.run.kick(link, share, impulse))

    async def _kick(self, link: int, share: float, impulse: tuple[float, float]) -> None:
        await self.page.call(lambda: self.page.run.kick(link, share, impulse))

    def _ask(self) -> None:
        """Open a dialog for a kick in numbers, at first of the tail."""
        links = self.page.scene.rod.links
        components = {"impulse along x [N s]": 0.0, "impulse along y [N s]": self.strength / 10}
        with self.page.root:
            PointDialog("Kick", links, (links - 1, 1.0), components, self._kick)


def scene_props(scene: Scene) -> dict[str, Any]:
    """Props of the picture that follow from a scene, and may change with its values."""
    return {
        "bodies": [asdict(mark) for mark in scene.distribution.body_outlines],
        "ties": [asdict(tie) for tie in scene.anchors.support_points],
        "bed": scene.anchors.foundation_line.tolist(),
        "clampAngle": scene.rod.clamp_angle or 0.0,
    }


def first_view(scene: Scene) -> View:
    """View in which a rod stays in the picture."""
    return "centre" if scene.boundary_condition.translates else "fixed"


def description(scene: Scene) -> str:
    """Description of the picture for screen readers."""
    carried = [f"carrying {body.name}" for body in scene.bodies]
    terms = describe_loads(scene) or ["no loads"]
    what = ", ".join((scene.rod.boundary, *carried, *terms))
    return (
        f"{scene.name}: rod of {scene.rod.links} links, {what}, drawn live; "
        "its numbers are in the panel of values. Arrows move, + and - zoom, 0 fits."
    )
