"""Pulls from the page: by the pointer, which holds the far end of a spring, or in numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen_live.page.elements import RodCanvas
from rodgen_live.page.fields import Entry, format_number, parse_number
from rodgen_live.page.page_run import PageRun
from rodgen_live.page.point_dialog import PointDialog
from rodgen_live.pull import Pull

SWING = 2.0  # seconds in which the rod would swing on the spring, were it rigid
DAMPED = 0.2  # of what would not let it swing
DIGITS = 3


class PullControls:
    """Controls of pulls; only: called when dragging from a link is switched to pulling."""

    def __init__(self, page: PageRun, only: Callable[[], object]):
        self.page, self._only = page, only
        self._held, self._to = False, (0.0, 0.0)  # by the pointer
        self.switch = ui.switch("pull by dragging", on_change=self._switch_pulling).props("dense")
        with self.switch:
            ui.tooltip("Drag from a link to pull it by a spring, or click it to type where to")
        self._stiffness = Entry("spring [N/m]", "", self._set_stiffness)
        self._damping = Entry("damper [N s/m]", "", self._set_damping)
        self.stays = ui.switch("stay where let go", on_change=self._switch_staying).props("dense")
        with self.stays:
            ui.tooltip("As Shift does: the spring's far end stays until Let go, or Esc")
        self._free = ui.button("Let go", on_click=self._release).props("flat dense no-caps")
        ui.button("Pull…", on_click=self._ask_tail).props("flat dense no-caps")
        for entry in (self._stiffness, self._damping):
            entry.field.classes("rg-spring")
        self._show_spring(False)

    def connect(self, canvas: RodCanvas) -> None:
        """Listen to what the pointer does over the picture."""
        self.canvas = canvas
        canvas.on_pull(self._grasp, self._move, lambda _: self._release())
        canvas.on_pulling(lambda _: self.switch.set_value(not self.switch.value))

    def refresh(self) -> None:
        """Show whether the rod is pulled."""
        pulled = self.page.run.live.pulling is not None
        self._free.set_enabled(pulled)
        self._free.set_visibility(pulled or bool(self.switch.value))

    def set_scene(self, scene: Scene) -> None:
        """Set the spring to a size that suits another scene."""
        self.stiffness, self.damping = usual_spring(scene)
        self._stiffness.show(format_number(self.stiffness))
        self._damping.show(format_number(self.damping))
        if self.switch.value:
            self.page.start_task(self.page.allow_pulls())

    def ask_pull(self, link: int, share: float) -> None:
        """Open a dialog for a pull in numbers."""
        run, links = self.page.run, self.page.scene.rod.links
        x, y = run.model.joints(run.shown.y[-1], run.shown.p)[link + (share >= 0.5)]
        size = self.page.scene.rod.length / 10
        with self.page.root:
            components = {"far end, x [m]": round(x, DIGITS), "y [m]": round(y + size, DIGITS)}
            PointDialog("Pull", links, (link, share), components, self._pull)

    def _ask_tail(self) -> None:
        self.ask_pull(self.page.scene.rod.links - 1, 1.0)

    def _switch_pulling(self, event: ValueChangeEventArguments[Any]) -> None:
        on = bool(event.value)
        self.canvas.set_props(pull=on)
        self._show_spring(on)
        if on:
            self._only()
            self.page.start_task(self.page.allow_pulls())

    def _show_spring(self, on: bool) -> None:
        for tool in (self._stiffness.field, self._damping.field, self.stays):
            tool.set_visibility(on)
        self.refresh()

    def _switch_staying(self, event: ValueChangeEventArguments[Any]) -> None:
        self.canvas.set_props(hold=bool(event.value))

    # What the pointer does ----------------------------------------------------------------------

    def _grasp(self, event: dict[str, Any]) -> None:
        self._held, self._to = True, (float(event["x"]), float(event["y"]))
        link, share = int(event["link"]), float(event["share"])

        async def begin() -> None:
            await self.page.allow_pulls()
            if self._held:  # it may have let go while the module was made
                await self._pull(link, share, self._to)

        self.page.start_task(begin())

    def _move(self, event: dict[str, Any]) -> None:
        self._to = to = float(event["x"]), float(event["y"])
        self.page.submit(lambda: self.page.run.move_pull(to))

    def _release(self) -> None:
        self._held = False
        self.page.submit(self.page.run.release_pull)

    async def _pull(self, link: int, share: float, to: tuple[float, float]) -> None:
        await self.page.allow_pulls()
        pull = Pull(link, share, to, self.stiffness, self.damping)
        await self.page.call(lambda: self.page.run.pull(pull))

    # The spring ---------------------------------------------------------------------------------

    async def _set_stiffness(self, text: str) -> None:
        self.stiffness = _parse_not_negative("stiffness", text)
        await self._apply_spring()

    async def _set_damping(self, text: str) -> None:
        self.damping = _parse_not_negative("damping", text)
        await self._apply_spring()

    async def _apply_spring(self) -> None:
        """Apply the spring to the present pull, if there is one."""

        def work() -> None:
            now, spring = self.page.run.live.pulling, (self.stiffness, self.damping)
            if now is not None:
                self.page.run.pull(replace(now, stiffness=spring[0], damping=spring[1]))

        await self.page.call(work)


def _parse_not_negative(name: str, text: str) -> float:
    """Parse a number of the spring that is not negative. Raises InputError."""
    value = parse_number(text, f"pull.{name}")
    if value < 0:
        raise InputError(f"pull.{name}", text, "not negative")
    return value


def usual_spring(scene: Scene) -> tuple[float, float]:
    """Stiffness [N/m] and damping [N s/m] of a spring that moves a rod visibly and does not throw
    it: the rod swings in about two seconds on it; where it is clamped, the spring is at least as
    stiff as the rod. A rod that flies is not damped."""
    rate, rod = 2 * math.pi / SWING, scene.rod
    bending = scene.distribution.mean_stiffness / rod.length**3
    stiffness = max(
        scene.mass * rate**2, 3 * bending if scene.boundary_condition.is_clamped else 0.0
    )
    damping = (
        0.0
        if scene.boundary_condition.translates
        else DAMPED * 2 * math.sqrt(stiffness * scene.mass)
    )
    return float(f"{stiffness:.2g}"), float(f"{damping:.2g}")
