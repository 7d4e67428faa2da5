"""Pulls from the page: by the pointer, which holds the far end of a spring, or in numbers."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from nicegui import ui

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
    """Controls of pulls: of its spring, and what the pointer does to it over the picture."""

    def __init__(self, page: PageRun, canvas: RodCanvas):
        self.page = page
        self._held, self._to = False, (0.0, 0.0)  # by the pointer
        self._stiffness = Entry("spring [N/m]", "", self._set_stiffness)
        self._damping = Entry("damper [N s/m]", "", self._set_damping)
        stays = ui.switch("stay where let go").props("dense")
        stays.on_value_change(lambda event: canvas.set_props(hold=bool(event.value)))
        with stays:
            ui.tooltip("As Shift does: the spring's far end stays until Let go, or Esc")
        ui.button("Pull in numbers…", on_click=self._ask).props("flat dense no-caps")
        canvas.on_pull(self._grasp, self._move, lambda _: self.release())

    def set_scene(self, scene: Scene) -> None:
        """Set the spring to a size that suits another scene."""
        self.stiffness, self.damping = usual_spring(scene)
        self._stiffness.show(format_number(self.stiffness))
        self._damping.show(format_number(self.damping))

    def _ask(self) -> None:
        """Open a dialog for a pull in numbers, at first of the tail."""
        run, links = self.page.run, self.page.scene.rod.links
        x, y = run.model.joints(run.shown.y[-1], run.shown.p)[-1]
        size = self.page.scene.rod.length / 10
        with self.page.root:
            components = {"far end, x [m]": round(x, DIGITS), "y [m]": round(y + size, DIGITS)}
            PointDialog("Pull", links, (links - 1, 1.0), components, self._pull)

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

    def release(self) -> None:
        """Let go of the rod."""
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
