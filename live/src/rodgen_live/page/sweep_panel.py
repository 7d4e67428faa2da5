"""Sweep of a number over a range beside its slider: stability of the rod, and its equilibria, as
plots of the page."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from nicegui import ui

from rodgen.errors import InputError
from rodgen.system import System
from rodgen_live.page.fields import Entry, format_number, parse_number
from rodgen_live.page.page_run import PageRun
from rodgen_live.page.sweep_diagram import Diagram, SweepPoint
from rodgen_live.run.scene_edits import SceneField
from rodgen_live.run.worker_process import ASIDE, Answer, PendingRequest

STEPS = 200  # of the slider for the range
KINDS = {"hopf": "flutter begins", "branch": "branch point", "fold": "fold"}


class SweepPanel:
    """The range, which is swept as soon as it is chosen, with its diagrams among the plots; a click
    on a point of the stability map takes its value, on one of the equilibria its state as well."""

    def __init__(
        self,
        page: PageRun,
        field: SceneField,
        reach: tuple[float, float],
        mark: Callable[[float | None], object],
    ):
        """Build the sweep; reach: first range; mark: called with the critical value, or None."""
        self.page, self.field, self._reach, self._mark = page, field, reach, mark
        self._errand: PendingRequest | None = None
        self._loop = asyncio.get_running_loop()
        self.low, self.high = reach
        self._box = ui.element("div").classes("rg-swept")
        with self._box.props(f'role="group" aria-label="{self.name}"'):
            self._range = ui.range(
                min=0, max=STEPS, value={"min": 0, "max": STEPS}, on_change=self._on_drag
            ).props(f'dense throttle=200 aria-label="{self.name} from|{self.name} to"')
            with ui.element("div").classes("rg-ends"):
                self._ends = [
                    Entry(end, format_number(value), self._end_setter(at), unit=field.unit)
                    for at, (end, value) in enumerate(zip(("from", "to"), reach, strict=True))
                ]
            self._note = ui.label().classes("rg-hint").props('role="status"')
        page.client.on_delete(self._cancel)
        self._clear()
        self._start()

    @property
    def name(self) -> str:
        """Name of the sweep."""
        return f"sweep of {self.field.label}"

    def close(self) -> None:
        """Remove the sweep from the page."""
        self._cancel()
        self._mark(None)
        self._box.delete()
        for one in (self._map, self._equilibria):
            self.page.diagrams.pop(one.id, None)
        self.page.refresh()

    def _cancel(self) -> None:
        """Cancel the computation."""
        if self._errand is not None:
            self._errand.cancel()
            self._errand = None

    def refresh(self, field: SceneField) -> None:
        """Show the value that the scene has now."""
        if field.value != self.field.value:
            self.field = field
            self._set_marks()

    # The range ---------------------------------------------------------------------------------

    def _slider_positions(self) -> dict[str, float]:
        """Positions of the ends on the slider."""
        low, high = self._reach
        ends = {"min": self.low, "max": self.high}
        return {name: round(STEPS * (end - low) / (high - low)) for name, end in ends.items()}

    def _on_drag(self) -> None:
        low, high = self._reach
        places = self._range.value
        if places == self._slider_positions() or not places["min"] < places["max"]:
            return
        ends = [float(f"{low + places[end] / STEPS * (high - low):.4g}") for end in ("min", "max")]
        if ends[0] < ends[1]:
            self.low, self.high = ends
            for entry, value in zip(self._ends, ends, strict=True):
                entry.show(format_number(value))
            self._start()

    def _end_setter(self, at: int) -> Any:
        async def put(text: str) -> None:
            ends = [self.low, self.high]
            ends[at] = parse_number(text, self.field.key)
            if not ends[0] < ends[1]:
                raise InputError(
                    self.field.key, text, "ends of a range, the first below the second"
                )
            self.low, self.high = ends
            self._reach = min(self._reach[0], ends[0]), max(self._reach[1], ends[1])
            self._range.set_value(self._slider_positions())
            self._start()

        return put

    # What is computed --------------------------------------------------------------------------

    def _clear(self) -> None:
        key, over = self.field.key, (self.field.label, self.field.unit)
        up = {"growth": ("largest growth rate", "1/s"), "tip": ("deflection of the tip", "m")}
        self._map, self._equilibria = (
            Diagram(f"{key}/{name}", label, over, self._apply_point) for name, label in up.items()
        )
        self._critical: float | None = None
        self._special: list[Any] = []
        self._said = ""

    def _start(self) -> None:
        self._cancel()
        self._clear()
        self._mark(None)
        ends = (f"{format_number(end)} {self.field.unit}".strip() for end in (self.low, self.high))
        self._range.props["aria-valuetext"] = "|".join(ends)
        self._range.update()
        self._note.set_text("computing")

        def receive(answer: Answer) -> None:
            with suppress(RuntimeError):  # the server is ending
                self._loop.call_soon_threadsafe(self._receive, answer, request)

        self._waits = request = object()
        scene, now = self.page.scene, self.page.run.live.t
        start, end = scene.integrate.span
        self._t = now if now > start else end  # loads may begin with nothing
        self._errand = ASIDE.submit(
            "sweep", scene, receive, key=self.field.key, low=self.low, high=self.high, t=self._t
        )

    def _receive(self, answer: Answer, request: object) -> None:
        """Take up a part of the answer to the last request."""
        if request is not self._waits or self._note.is_deleted:
            return
        part: dict[str, Any] = answer.value or {}
        for value, growth, _, stable in part.get("rows", ()):
            if growth is not None:
                self._map.points.append(SweepPoint(value, growth, stable))
        if "critical" in part:
            self._critical = part["critical"]
            self._mark(self._critical)
        self._special = part.get("special", self._special)
        if branch := part.get("branch"):
            columns = (branch[key] for key in ("value", "away", "unstable", "state"))
            self._equilibria.points = [
                SweepPoint(value, away, unstable == 0 if unstable >= 0 else None, state)
                for value, away, unstable, state in zip(*columns, strict=True)
                if away is not None
            ]
        self._said = answer.refused or part.get("note", self._said)
        self._note.set_text(self._summary() if answer.last else "computing")
        self._draw()

    def _summary(self) -> str:
        """Summary of the sweep in words."""
        if not self._map.points:
            return self._said or "nothing could be computed"
        first = self._map.points[0].stable
        words = "stable" if first else "unstable"
        change = "all over the range"
        if self._critical is not None:
            change = f"up to {self._critical:.4g} {self.field.unit}".rstrip()
        when = f", loads as at t = {self._t:.3g} s" if self.page.scene.time_dependent_loads else ""
        special = (f"{KINDS.get(kind, kind)} at {value:.5g}" for value, kind in self._special)
        said = f"straight{when}: {words} {change}", *special, self._said
        return "; ".join(filter(None, said))

    def _draw(self) -> None:
        """Show the diagrams that have points among the plots."""
        self._set_marks()
        for one in (self._map, self._equilibria):
            if one.points:
                self.page.diagrams[one.id] = one
        self.page.refresh()

    def _set_marks(self) -> None:
        """Mark the present value and the critical one."""
        values = [self.field.value, self._critical]
        for one in (self._map, self._equilibria):
            one.marks = [value for value in values if value is not None]

    async def _apply_point(self, point: SweepPoint) -> None:
        changes = self.field.changes(point.value)
        run, at = self.page.run, f"{self.field.key} = {format_number(point.value)}"

        def at_equilibrium(system: System) -> System:
            return system.at(changes, y0=list(point.state))

        try:
            if point.state:
                what = f"equilibrium at {at}"
                await self.page.change_system(
                    at_equilibrium,
                    run.restart,
                    lambda before: run.undo.note(before, what, anew=True),
                )
            else:
                await self.page.change(changes, at)
        except InputError as error:
            self.page.notify(str(error))
