"""Kicks and pulls in numbers, and pulls by the pointer, which holds the far end of a spring."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Mapping
from functools import partial

from nicegui import ui
from nicegui.events import GenericEventArguments

from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen_live.page.elements import RodCanvas
from rodgen_live.page.fields import Entry, ask, format_number, parse_integer, parse_number
from rodgen_live.page.page_run import PageRun
from rodgen_live.pull import Pull
from rodgen_live.run.message import trail_points

SWING = 2.0  # seconds in which the rod would swing on the spring, were it rigid
DAMPED = 0.2  # of what would not let it swing
DIGITS = 3
SPRING = {"stiffness": "spring [N/m]", "damping": "damper [N s/m]"}


class PullControls:
    """Controls of pulls: of its spring, and what the pointer does to it over the picture."""

    def __init__(self, page: PageRun, canvas: RodCanvas):
        self.page = page
        self._to: tuple[float, float] | None = None  # where the pointer holds the far end
        self.spring = dict.fromkeys(SPRING, 0.0)
        self._entries = {
            name: Entry(label, "", partial(self._set_spring, name))
            for name, label in SPRING.items()
        }
        stays = ui.switch("stay where let go")
        stays.on_value_change(lambda event: canvas.props.update(hold=event.value))
        with stays:
            ui.tooltip("As Shift does: the spring's far end stays until Let go, or Esc")
        ui.button("Pull in numbers…", on_click=self._ask).props("flat dense")
        canvas.on("pull", self._grasp).on("move", self._move).on("release", self.release)

    def set_scene(self, scene: Scene) -> None:
        """Set the spring to a size that suits another scene."""
        self.spring = dict(zip(SPRING, usual_spring(scene), strict=True))
        for name, entry in self._entries.items():
            entry.show(format_number(self.spring[name]))

    def _ask(self) -> None:
        run, size = self.page.run, self.page.scene.rod.length / 10
        x, y, *_ = trail_points(run.model, run.shown)[-1]  # of the tail
        far = {"far end, x [m]": round(x, DIGITS), "y [m]": round(y + size, DIGITS)}
        ask_point(self.page, "Pull", far, self._pull)

    def _grasp(self, event: GenericEventArguments) -> None:
        self._move(event)
        link, share = int(event.args["link"]), float(event.args["share"])

        def pull() -> None:
            if (to := self._to) is not None:  # where it is by now, if it has not let go
                self.page.run.pull(Pull(link, share, to, **self.spring))

        async def begin() -> None:
            await self.page.allow_pulls()
            await self.page.call(pull)

        self.page.start_task(begin())

    def _move(self, event: GenericEventArguments) -> None:
        self._to = to = float(event.args["x"]), float(event.args["y"])
        self.page.submit(lambda: self.page.run.move_pull(to))

    def release(self) -> None:
        """Let go of the rod."""
        self._to = None
        self.page.submit(self.page.run.release_pull)

    async def _pull(self, link: int, share: float, to: tuple[float, float]) -> None:
        await self.page.allow_pulls()
        pull = Pull(link, share, to, **self.spring)
        await self.page.call(lambda: self.page.run.pull(pull))

    async def _set_spring(self, name: str, text: str) -> None:
        """Set a number of the spring, of the present pull too, if there is one."""
        value = parse_number(text, f"pull.{name}")
        if value < 0:
            raise InputError(f"pull.{name}", text, "not negative")
        self.spring[name] = value

        def work() -> None:
            if (now := self.page.run.live.pulling) is not None:
                self.page.run.pull(Pull(now.link, now.share, now.to, **self.spring))

        await self.page.call(work)


def ask_point(
    page: PageRun,
    verb: str,
    components: Mapping[str, float],
    act: Callable[[int, float, tuple[float, float]], Awaitable[None]],
) -> None:
    """Open a dialog for a point of a link, at first the tail, and two components, by their labels
    with what stands there at first; `act` is given them."""
    last = page.scene.rod.links - 1
    (x, at_x), (y, at_y) = components.items()

    async def take(given: Mapping[str, str]) -> None:
        link = parse_integer(given["link"], "link")
        share, *both = (parse_number(given[name], name) for name in ("share", "x", "y"))
        await act(link, share, (both[0], both[1]))

    texts = {
        "link": (f"link, 0 to {last}", str(last)),
        "share": ("place on it, 0 (start) to 1 (end)", "1"),
        "x": (x, format_number(at_x)),
        "y": (y, format_number(at_y)),
    }
    with page.root:
        ask(verb, verb, texts, take)


def usual_spring(scene: Scene) -> tuple[float, float]:
    """Stiffness [N/m] and damping [N s/m] of a spring that moves a rod visibly and does not throw
    it: the rod swings in about two seconds on it; where it is clamped, the spring is at least as
    stiff as the rod. A rod that flies is not damped."""
    boundary, stiffness = scene.boundary_condition, scene.mass * (2 * math.pi / SWING) ** 2
    if boundary.is_clamped:
        bending = scene.distribution.mean_stiffness / scene.rod.length**3
        stiffness = max(stiffness, 3 * bending)
    damping = 0.0 if boundary.translates else DAMPED * 2 * math.sqrt(stiffness * scene.mass)
    return float(f"{stiffness:.2g}"), float(f"{damping:.2g}")
