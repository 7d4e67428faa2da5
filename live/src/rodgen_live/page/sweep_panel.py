"""Sweep of a number over a range beside its slider: stability of the rod, and its equilibria, as
plots of the page."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from nicegui import ui

from rodgen.analyse.modes import Modes
from rodgen.errors import InputError
from rodgen_live.page.fields import Entry, format_number, parse_number
from rodgen_live.page.page_run import PageRun
from rodgen_live.page.sweep_diagram import Diagram, SweepPoint
from rodgen_live.run.run_thread import from_threads
from rodgen_live.run.scene_edits import SceneField
from rodgen_live.run.worker_process import ASIDE, Answer, PendingRequest

(GROWTH,) = (row for row in Modes.ROWS if row.name == "largest_growth")
KINDS = {"hopf": "flutter begins", "branch": "branch point", "fold": "fold"}


class SweepPanel:
    """The range, which is swept as soon as it is chosen, with its diagrams among the plots; a click
    on a point of the stability map takes its value, on one of the equilibria its state as well."""

    def __init__(
        self,
        page: PageRun,
        field: SceneField,
        ends: tuple[float, float],
        changed: Callable[[], object],
    ):
        """Build the sweep; ends: first range; changed: called when the critical value has."""
        self.page, self.field, self._ends, self._changed = page, field, ends, changed
        self._errand: PendingRequest | None = None
        self._box = ui.element("div").classes("rg-swept")
        with self._box.props(f'role="group" aria-label="sweep of {field.label}"'):
            with ui.element("div").classes("rg-ends"):
                for at, name in enumerate(("from", "to")):
                    shown = format_number(ends[at])
                    Entry(name, shown, partial(self._set_end, at), unit=field.unit)
            self._note = ui.label().classes("rg-hint").props('role="status"')
        page.client.on_delete(self._cancel)
        self._start()

    @property
    def critical(self) -> float | None:
        """Value at which stability changes, if the sweep has found one."""
        found: float | None = self._found.get("critical")
        return found

    def close(self) -> None:
        """Remove the sweep from the page."""
        self._cancel()
        self._changed()
        self._box.delete()
        for one in (self._map, self._equilibria):
            self.page.diagrams.pop(one.id, None)
        self.page.refresh()

    def _cancel(self) -> None:
        if self._errand is not None:
            self._errand.cancel()

    def refresh(self, field: SceneField) -> None:
        """Show the value that the scene has now."""
        if field.value != self.field.value:
            self.field = field
            self._set_marks()

    async def _set_end(self, at: int, text: str) -> None:
        value = parse_number(text, self.field.key)
        low, high = (value, self._ends[1]) if at == 0 else (self._ends[0], value)
        if not low < high:
            raise InputError(self.field.key, text, "ends of a range, the first below the second")
        self._ends = low, high
        self._start()

    def _start(self) -> None:
        self._cancel()
        key, over = self.field.key, (self.field.label, self.field.unit)
        up = {"growth": (GROWTH.words, GROWTH.unit), "tip": ("deflection of the tip", "m")}
        self._map, self._equilibria = (
            Diagram(f"{key}/{name}", label, over, self._apply_point) for name, label in up.items()
        )
        self._found: dict[str, Any] = {}
        self._changed()
        self._note.set_text("computing")
        receive = from_threads(partial(self._receive, self._map))
        scene, now = self.page.scene, self.page.run.live.t
        start, end = scene.integrate.span
        self._t = now if now > start else end  # loads may begin with nothing
        low, high = self._ends
        self._errand = ASIDE.submit("sweep", scene, receive, key=key, low=low, high=high, t=self._t)

    def _receive(self, of: Diagram, answer: Answer) -> None:
        if of is not self._map or self._note.is_deleted:
            return
        part: dict[str, Any] = answer.value or {}
        self._found |= {"note": answer.refused} if answer.refused else part
        for value, growth, stable in part.get("rows", ()):
            if growth is not None:
                self._map.points.append(SweepPoint(value, growth, stable))
        if "critical" in part:
            self._changed()
        if branch := part.get("branch"):
            columns = (branch[key] for key in ("value", "away", "unstable", "state"))
            self._equilibria.points = [
                SweepPoint(value, away, unstable == 0 if unstable >= 0 else None, state)
                for value, away, unstable, state in zip(*columns, strict=True)
                if away is not None
            ]
        self._note.set_text(self._summary() if answer.last else "computing")
        self._set_marks()
        for one in (self._map, self._equilibria):
            if one.points:
                self.page.diagrams[one.id] = one
        self.page.refresh()

    def _summary(self) -> str:
        note, critical = self._found.get("note", ""), self.critical
        if not self._map.points:
            return note or "nothing could be computed"
        words = "stable" if self._map.points[0].stable else "unstable"
        change = "all over the range"
        if critical is not None:
            change = f"up to {critical:.4g} {self.field.unit}".rstrip()
            change += f", where {self._found['change']}"
        when = f", loads as at t = {self._t:.3g} s" if self.page.scene.time_dependent_loads else ""
        special = self._found.get("special", ())
        points = (f"{KINDS.get(kind, kind)} at {value:.5g}" for value, kind in special)
        return "; ".join(filter(None, (f"{words} {change}{when}", *points, note)))

    def _set_marks(self) -> None:
        marks = (self.field.value, "now"), (self.critical, self._found.get("change", ""))
        for one in (self._map, self._equilibria):
            one.marks = [(value, words) for value, words in marks if value is not None]

    async def _apply_point(self, point: SweepPoint) -> None:
        """Take the value of a point, and its state, if it has one. Raises InputError."""
        at = f"{self.field.key} = {format_number(point.value)}"
        what, state = (f"equilibrium at {at}", list(point.state)) if point.state else (at, None)
        await self.page.change(self.field.changes(point.value), what, state)
