"""A range of a number beside its slider: how stable the rod is over it, and its equilibria."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from rodgen.errors import InputError
from rodgen.live.page.fields import Entry, number, plain
from rodgen.live.page.runs import PageRun
from rodgen.live.page.sweep_picture import HEIGHT, WIDTH, Diagram, Point, picture
from rodgen.live.run.aside import ASIDE, Answer, Errand
from rodgen.live.run.scenes import SceneField
from rodgen.system import System

STEPS = 200  # of the slider for the range
CLICKED = """(event) => {
    const box = event.currentTarget.querySelector("svg")?.getBoundingClientRect();
    if (box) emit((event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height);
}"""


class Sweep:
    """The range, which is swept as soon as it is chosen, and the diagrams; a click on a point of
    the stability map takes its value, on one of the equilibria its state as well."""

    def __init__(
        self,
        page: PageRun,
        field: SceneField,
        reach: tuple[float, float],
        mark: Callable[[float | None], object],
    ):
        """reach: the first range; mark: called with the critical value, or None."""
        self.page, self.field, self._reach, self._mark = page, field, reach, mark
        self._errand: Errand | None = None
        self._loop = asyncio.get_running_loop()
        self.low, self.high = reach
        self._box = ui.element("div").classes("rg-swept")
        with self._box.props(f'role="group" aria-label="{self.name}"'):
            self._range = ui.range(
                min=0, max=STEPS, value={"min": 0, "max": STEPS}, on_change=self._dragged
            ).props(f'dense throttle=200 aria-label="{self.name} from|{self.name} to"')
            with ui.element("div").classes("rg-ends"):
                self._ends = [
                    Entry(end, plain(value), self._typed(at), unit=field.unit)
                    for at, (end, value) in enumerate(zip(("from", "to"), reach, strict=True))
                ]
            self._note = ui.label().classes("rg-hint").props('role="status"')
            self._picture = ui.html("", sanitize=False)
            self._picture.on("click", self._clicked, js_handler=CLICKED)
        page.client.on_delete(self._drop)
        self._clear()
        self._start()

    @property
    def name(self) -> str:
        """What it is called."""
        return f"sweep of {self.field.label}"

    def close(self) -> None:
        """Take it from the page."""
        self._drop()
        self._mark(None)
        self._box.delete()

    def _drop(self) -> None:
        """Compute no further."""
        if self._errand is not None:
            self._errand.drop()
            self._errand = None

    def refresh(self, field: SceneField) -> None:
        """Show the value that the scene has now."""
        if field.value != self.field.value:
            self.field = field
            self._draw()

    # The range ---------------------------------------------------------------------------------

    def _places(self) -> dict[str, float]:
        """Where on the slider the ends are."""
        low, high = self._reach
        ends = {"min": self.low, "max": self.high}
        return {name: round(STEPS * (end - low) / (high - low)) for name, end in ends.items()}

    def _dragged(self) -> None:
        low, high = self._reach
        places = self._range.value
        if places == self._places() or not places["min"] < places["max"]:
            return
        ends = [float(f"{low + places[end] / STEPS * (high - low):.4g}") for end in ("min", "max")]
        if ends[0] < ends[1]:
            self.low, self.high = ends
            for entry, value in zip(self._ends, ends, strict=True):
                entry.show(plain(value))
            self._start()

    def _typed(self, at: int) -> Any:
        async def put(text: str) -> None:
            ends = [self.low, self.high]
            ends[at] = number(text, self.field.key)
            if not ends[0] < ends[1]:
                raise InputError(
                    self.field.key, text, "ends of a range, the first below the second"
                )
            self.low, self.high = ends
            self._reach = min(self._reach[0], ends[0]), max(self._reach[1], ends[1])
            self._range.set_value(self._places())
            self._start()

        return put

    # What is computed --------------------------------------------------------------------------

    def _clear(self) -> None:
        label = f"{self.field.label} [{self.field.unit}]" if self.field.unit else self.field.label
        over = f"over {label}"
        self._map = Diagram(f"largest growth rate [1/s] {over}", self.low, self.high)
        self._equilibria = Diagram(f"deflection of the tip [m] {over}", self.low, self.high)
        self._critical: float | None = None
        self._special: list[Any] = []
        self._said = ""

    def _start(self) -> None:
        self._drop()
        self._clear()
        self._mark(None)
        ends = (f"{plain(end)} {self.field.unit}".strip() for end in (self.low, self.high))
        self._range.props["aria-valuetext"] = "|".join(ends)
        self._range.update()
        self._note.set_text("computing")

        def told(answer: Answer) -> None:
            with suppress(RuntimeError):  # the server is ending
                self._loop.call_soon_threadsafe(self._take, answer, request)

        self._waits = request = object()
        scene, now = self.page.scene, self.page.run.live.t
        start, end = scene.integrate.span
        self._t = now if now > start else end  # loads may begin with nothing
        self._errand = ASIDE.ask(
            "sweep", scene, told, key=self.field.key, low=self.low, high=self.high, t=self._t
        )

    def _take(self, answer: Answer, request: object) -> None:
        """Take up a part of what was asked for last."""
        if request is not self._waits or self._picture.is_deleted:
            return
        part: dict[str, Any] = answer.value or {}
        for value, growth, _, stable in part.get("rows", ()):
            if growth is not None:
                self._map.points.append(Point(value, growth, stable))
        if "critical" in part:
            self._critical = part["critical"]
            self._mark(self._critical)
        self._special = part.get("special", self._special)
        if branch := part.get("branch"):
            columns = (branch[key] for key in ("value", "away", "unstable", "state"))
            self._equilibria.points = [
                Point(value, away, unstable == 0 if unstable >= 0 else None, state)
                for value, away, unstable, state in zip(*columns, strict=True)
                if away is not None
            ]
        self._said = answer.refused or part.get("note", self._said)
        self._note.set_text(self._told() if answer.last else "computing")
        self._draw()

    def _told(self) -> str:
        """What came out, in words."""
        if not self._map.points:
            return self._said or "nothing could be computed"
        first = self._map.points[0].stable
        words = "stable" if first else "unstable"
        change = "all over the range"
        if self._critical is not None:
            change = f"up to {self._critical:.4g} {self.field.unit}".rstrip()
        when = f", loads as at t = {self._t:.3g} s" if self.page.scene.timed else ""
        return "; ".join(filter(None, (f"straight{when}: {words} {change}", self._said)))

    def _draw(self) -> None:
        shown = [one for one in (self._map, self._equilibria) if one.points]
        at = self.field.value, self._critical, self._special
        self._picture.set_content(picture(shown, self.name, *at) if shown else "")

    # What is clicked ---------------------------------------------------------------------------

    async def _clicked(self, event: GenericEventArguments) -> None:
        shown = [one for one in (self._map, self._equilibria) if one.points]
        x, y = (float(share) for share in event.args)
        number, down = divmod(y * len(shown) * HEIGHT, HEIGHT)
        if not shown or not 0 <= number < len(shown):
            return
        point = shown[int(number)].nearest(x * WIDTH, down)
        if point is not None:
            await self._load(point)

    async def _load(self, point: Point) -> None:
        changes = self.field.changes(point.value)
        run, at = self.page.run, f"{self.field.key} = {plain(point.value)}"

        def there(system: System) -> System:
            return system.at(changes, y0=list(point.state))

        try:
            if point.state:
                what = f"equilibrium at {at}"
                await self.page.alter(
                    there, run.restart, lambda before: run.undo.note(before, what, anew=True)
                )
            else:
                await self.page.change(changes, at)
        except InputError as error:
            self.page.say(str(error))
