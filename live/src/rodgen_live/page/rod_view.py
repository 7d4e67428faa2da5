"""The picture of the rod, what it shows, and kicks and pulls by dragging or in numbers."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments, ValueChangeEventArguments

from rodgen.scene import Scene
from rodgen.scene.model_contents import describe_loads
from rodgen_live.page.elements import FIRST, LAYERS, PULL, TOOLS, RodCanvas, TimeLine, arrows_of
from rodgen_live.page.fields import Entry, IconButton, format_number, parse_number
from rodgen_live.page.mode_panel import ModePanel
from rodgen_live.page.page_run import VIEW, PageRun
from rodgen_live.page.pulls import PullControls, ask_point

SHOWN = "What is shown"
MENU = 'auto-close=false role=dialog aria-label="%s"'
TUNED = "Kicks and pulls: strength, spring, in numbers"
ENLARGED = {1: "as they are", 10: "× 10", 100: "× 100", 1000: "× 1000", 10_000: "× 10 000"}
VIEWS = {"fixed": "fixed", "centre": "follows the centre of gravity", "axes": "turns with the axes"}


class RodPanel:
    """Panel of the rod: the canvas with its tools, and the time line below it."""

    def __init__(self, page: PageRun):
        self.page = page
        self._first, self._drawn = first_view(page.scene), scene_props(page.scene)
        with ui.element("section").classes("rg-rod").props('aria-label="The rod"'):
            tools = ui.element("div").classes("rg-tools")
            view = page.tab.get(VIEW, self._first)
            self.canvas = RodCanvas(**FIRST | self._drawn | {"view": view})
            self.canvas.classes("rg-canvas").on("kick", self._on_drag)
            with tools:
                self._build_tools(view)
        self.line = TimeLine(speed=1.0)

    def _build_tools(self, view: str) -> None:
        page, change, have = self.page, self.canvas.props.update, self.canvas.run_method
        self.view = ui.select(VIEWS, value=view, label="View", on_change=self._set_view)
        self.view.classes("rg-view")
        times = ui.select(ENLARGED, value=1, label="Displacements").classes("rg-times")
        times.on_value_change(lambda event: change(times=event.value))
        with IconButton("layers", SHOWN), ui.menu().props(MENU % SHOWN):
            self.switches = {
                name: ui.switch(layer.label, value=layer.shown, on_change=self._show_layers)
                for name, layer in LAYERS.items()
            }
            for switch in self.switches.values():
                switch.classes("rg-switch")
        self.modes = ModePanel(page, lambda mode: change(mode=mode))
        IconButton("fit_screen", "Fit the rod into the picture", lambda: have("fit"))
        take = "Save the picture as PNG"
        IconButton("photo_camera", take, lambda: have("png", f"{page.scene.name}.png"))
        tool = ui.toggle(list(TOOLS), value=PULL).props('dense no-caps unelevated role="group"')
        tool.props('aria-label="What dragging from a link does"').classes("rg-tool")
        tool.props("toggle-color=none toggle-text-color=none")  # as other buttons that are pressed
        tool.on_value_change(lambda event: change(tool=event.value))
        with IconButton("tune", TUNED), ui.menu().props(MENU % TUNED).classes("rg-tuned"):
            self.per_metre = Entry("kick [N s] per metre dragged", "", self._put_strength)
            ui.button("Kick in numbers…", on_click=self._ask).props("flat dense")
            self.pulls = PullControls(page, self.canvas)
        self.free = ui.button("Let go", on_click=self.pulls.release).props("flat dense")

    def refresh(self) -> None:
        """Show the scene as it is now. The time line plays at the speed of the run, or in real time
        where that runs as fast as it goes."""
        run, scene = self.page.run, self.page.scene
        drawn = {**scene_props(scene), "rod": run.taken}
        if drawn["rod"] != self._drawn.get("rod"):
            self._set_scene(scene)
        if drawn != self._drawn:
            self._drawn = drawn
            self.canvas.props.update(drawn)
        speed = run.pace.speed if math.isfinite(run.pace.speed) else 1.0
        if speed != self.line.props["speed"]:
            self.line.props["speed"] = speed
        self.free.set_enabled(run.live.pulling is not None)

    def _set_scene(self, scene: Scene) -> None:
        self.modes.hide()
        view = first_view(scene)
        if view != self._first:  # what was chosen for a rod that flies is not for one that is held
            self._first = view
            self.view.set_value(view)
        for name, switch in self.switches.items():
            term = LAYERS[name].term
            switch.set_visibility(term is None or term in scene.loads.terms)
        self.canvas.props["perMetre"] = scene.mass
        self.per_metre.show(format_number(scene.mass))
        self.pulls.set_scene(scene)

    def _set_view(self, event: ValueChangeEventArguments[Any]) -> None:
        self.page.tab[VIEW] = self.canvas.props["view"] = event.value

    def _show_layers(self) -> None:
        shown = {name: switch.value for name, switch in self.switches.items()}
        self.canvas.props["show"] = shown

    async def _put_strength(self, text: str) -> None:
        self.canvas.props["perMetre"] = parse_number(text, "kick strength")

    def _on_drag(self, event: GenericEventArguments) -> None:
        link, share, *metres = (float(event.args[key]) for key in ("link", "share", "dx", "dy"))
        x, y = (self.canvas.props["perMetre"] * one for one in metres)
        self.page.start_task(self._kick(int(link), share, (x, y)))

    async def _kick(self, link: int, share: float, impulse: tuple[float, float]) -> None:
        await self.page.call(lambda: self.page.run.kick(link, share, impulse))

    def _ask(self) -> None:
        size = self.canvas.props["perMetre"] / 10
        components = {"impulse along x [N s]": 0.0, "impulse along y [N s]": size}
        ask_point(self.page, "Kick", components, self._kick)


def scene_props(scene: Scene) -> dict[str, Any]:
    """Props of the picture that follow from a scene."""
    return {
        "bodies": [asdict(mark) for mark in scene.distribution.body_outlines],
        "ties": [asdict(tie) for tie in scene.anchors.support_points],
        "bed": scene.anchors.foundation_line.tolist(),
        "obstacles": [line.tolist() for line in scene.obstacles],
        "restShape": scene.distribution.rest_shape.tolist(),
        "support": scene.boundary_condition.start_drawing,
        "loads": arrows_of(scene.loads.terms),
        "label": description(scene),
    }


def first_view(scene: Scene) -> str:
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
