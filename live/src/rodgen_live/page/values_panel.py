"""Numbers of the run on the page: a panel that shows them, sliders and fields that change them."""

from __future__ import annotations

import math
from functools import partial
from html import escape

from nicegui import ui
from nicegui.events import GenericEventArguments

from rodgen.errors import InputError
from rodgen.model.methods import FIXED_STEP, METHODS
from rodgen.scene.integration import AUTO
from rodgen_live.page.fields import (
    Entry,
    IconButton,
    format_number,
    heading,
    parse_number,
    show_refusal,
)
from rodgen_live.page.page_run import PageRun
from rodgen_live.page.sweep_panel import SweepPanel
from rodgen_live.panel_rows import TextRow
from rodgen_live.run.scene_edits import SceneField, fields_of, slider_scale

THROTTLE = 0.04  # seconds between two values of a slider that is dragged
STEPS = 1000  # of a slider
MARKS = "marker-labels"  # prop of it
SETTINGS = {"step": "s", "rtol": "", "atol": "", "output_every": "s"}


class ValuesPanel:
    """Panel of values: a table for each group of rows, built anew for a scene with other rows."""

    def __init__(self, page: PageRun):
        self.page = page
        self._box = ui.html(sanitize=False).classes("rg-values")

    def refresh(self) -> None:
        """Show the rows that the scene has now."""
        tables = "".join(
            f"<table><caption>{title}</caption>{''.join(map(_row_html, rows))}</table>"
            for title, rows in self.page.run.page.groups.items()
        )
        if tables != self._box.content:
            self._box.set_content(tables)


def _row_html(row: TextRow) -> str:
    key, label, unit = map(escape, row[:3])
    if not label:
        return f'<tr><td data-text="{key}" colspan="3" class="rg-words"></td></tr>'
    cells = f'<td data-text="{key}"></td><td class="rg-unit">{unit}</td>'
    return f'<tr><th scope="row">{label}</th>{cells}</tr>'


def field_text(field: SceneField) -> str:
    """Format a value as its field shows it."""
    return field.text if field.value is None else format_number(field.value)


class Knob:
    """Slider and field of a number of the scene."""

    def __init__(self, page: PageRun, field: SceneField):
        self.page, self.field, self._scale = page, field, slider_scale(field)
        self._waiting: float | None = None  # where the slider is by now
        self._critical: float | None = None  # of the run
        self.sweep: SweepPanel | None = None
        text, value = field_text(field), field.value
        slides = value is not None and not field.of.fixed
        with ui.element("div").classes("rg-knob") as self._box:
            with ui.element("div").classes("rg-head"):
                self.entry = Entry(
                    field.label, text, self._put, unit=field.unit, long=value is None
                )
                if slides and not field.whole:
                    IconButton("show_chart", f"Sweep of {field.label}", self._toggle_sweep)
            self.slider = ui.slider(min=0, max=STEPS, step=1, value=self._position(value or 0.0))
            self.slider.props(f'dense aria-label="{field.label}" aria-valuetext="{self._said}"')
            self.slider.on("update:model-value", self._on_slide, throttle=THROTTLE)
            self.slider.on("change", self._on_release).set_visibility(slides)

    @property
    def _said(self) -> str:
        """Value of the slider for screen readers, which know its position."""
        return f"{format_number(self.field.value)} {self.field.unit}"

    @property
    def _range(self) -> tuple[float, float]:
        return self.field.slider_range(self._scale)

    def _toggle_sweep(self) -> None:
        before, self.sweep = self.sweep, None
        if before is not None:
            before.close()
            return
        with self._box:
            self.sweep = SweepPanel(self.page, self.field, self._range, self._mark)

    def _mark(self) -> None:
        """Mark the value on the slider at which stability changes, if it is in its range: the one
        that a sweep has found, else that of the run."""
        swept = self.sweep.critical if self.sweep else None
        critical = self._critical if swept is None else swept
        low, high = self._range
        marks = []
        if critical is not None and low <= critical <= high:
            marks = [{"value": self._position(critical), "label": f"critical {critical:.4g}"}]
        if self.slider.props.get(MARKS, []) != marks:
            self.slider.props[MARKS] = marks

    def _position(self, value: float) -> float:
        low, high = self._range
        if self.field.is_logarithmic:
            share = math.log(max(value, low) / low) / math.log(high / low)
        else:
            share = (value - low) / (high - low)
        return round(STEPS * min(1.0, max(0.0, share)))

    def _value_at(self, place: float) -> float:
        """Value at a position of the slider, rounded to what a step of it resolves."""
        low, high = self._range
        share = place / STEPS
        if self.field.is_logarithmic:
            return min(high, max(low, float(f"{low * (high / low) ** share:.4g}")))
        value = float(f"{low + share * (high - low):.4g}")
        return min(high, max(low, value)) if abs(value) > 1e-9 * self._scale else 0.0

    async def _on_slide(self, event: GenericEventArguments) -> None:
        """Apply the value at a position; of those that come meanwhile, the last counts."""
        busy, self._waiting = self._waiting is not None, float(event.args)
        if busy:
            return
        try:
            while self._waiting is not None:
                place = self._waiting
                text = format_number(self._value_at(place))
                self.entry.show(text)
                await self._put(text)
                if self._waiting == place:
                    self._waiting = None
        except InputError as error:
            show_refusal(self.entry.field, f"must be {error.allowed}")
        finally:
            self._waiting = None

    def _on_release(self, event: GenericEventArguments) -> None:
        """Extend the range of a slider that was pushed to its end."""
        value = self._value_at(float(event.args))
        if float(event.args) in (0, STEPS) and value and not self.field.of.is_angle:
            self._scale = abs(value)
            self.slider.set_value(self._position(value))
            self._mark()

    async def _put(self, text: str) -> None:
        """Change the number to that of a text, or to an expression. Raises InputError."""
        try:
            value: float | str = parse_number(text, self.field.key)
        except InputError:
            value = text  # where the scene may have one there
        await self.page.change(self.field.changes(value), f"{self.field.key} = {text}")

    def refresh(self, field: SceneField, filed: SceneField | None, critical: float | None) -> None:
        """Show the value that the scene has now; filed: that of its file, which may have none;
        critical: the value at which the rod becomes unstable, if it is known."""
        before, self.field, text = self.field, field, field_text(field)
        self._critical = critical
        if field.label != before.label:  # of a number in an expression, which is written in it
            self.entry.field.props["label"] = self.slider.props["aria-label"] = field.label
        if self.sweep is not None:
            self.sweep.refresh(field)
        self.entry.show_file_value(text, field_text(filed) if filed else None)
        self.entry.show(text)
        if field.value is None:
            return
        low, high = self._range
        if not low <= field.value <= high:
            self._scale = slider_scale(field)
        self._mark()
        if field.value != before.value:
            self.slider.props["aria-valuetext"] = self._said
        place = self._position(field.value)
        if self._waiting is None and self.slider.value != place:
            self.slider.set_value(place)


class ParametersPanel:
    """Panel of all knobs and the settings of the integration; built anew for another structure."""

    def __init__(self, page: PageRun):
        self.page = page
        self._kinds: object = None
        self._knobs: dict[str, Knob] = {}
        heading("Parameters")
        self._box = ui.element("div").classes("rg-knobs")
        heading("Integration")
        with ui.element("div").classes("rg-knobs"):
            self.method = ui.select([AUTO, *METHODS], label="method", on_change=self._set_method)
            self._settings = {
                name: Entry(name.replace("_", " "), "", partial(self._set_number, name), unit=unit)
                for name, unit in SETTINGS.items()
            }
        self.looking = ui.switch("method and tolerance for looking", on_change=self._switch_looking)
        self.warned = ui.label().classes("rg-warned")

    async def _set_number(self, name: str, text: str) -> None:
        value = parse_number(text, f"integrate.{name}")
        await self.page.change({f"integrate.{name}": value}, f"{name} = {text}")

    async def _set_method(self) -> None:
        """Change the method; one of fixed steps gets a step that is stable here."""
        live, method = self.page.run.live, self.method.value
        if method == self.page.scene.integrate.method:
            return
        try:
            fixed = method in FIXED_STEP
            step = await self.page.call(live.step_for, method) if fixed else None
            changes = {"integrate.method": method, "integrate.step": step}
            await self.page.change(changes, f"method {method}")
        except InputError as error:
            self.page.notify(str(error))
            self.refresh()

    def _switch_looking(self) -> None:
        run, on = self.page.run, bool(self.looking.value)
        if on != bool(run.live.rough):
            self.page.submit(run.roughen, on)

    def refresh(self) -> None:
        """Show the values that the scene has now."""
        scene = self.page.scene
        fields = {field.key: field for field in fields_of(scene)}
        kinds = [(key, field.value is None) for key, field in fields.items()]
        if kinds != self._kinds:
            self._kinds = kinds
            self.page.diagrams.clear()  # of sweeps, which go with their knobs
            self._box.clear()
            with self._box:
                self._knobs = {key: Knob(self.page, field) for key, field in fields.items()}
        filed = {field.key: field for field in fields_of(self.page.run.undo.file)}
        key_of_load, critical = self.page.run.critical.mark or ("", 0.0)
        for key, field in fields.items():
            mark = critical if key == key_of_load else None
            self._knobs[key].refresh(field, filed.get(key), mark)
        settings, before = scene.integrate, self.page.run.undo.file.integrate
        if self.method.value != settings.method:
            self.method.set_value(settings.method)
        for name, entry in self._settings.items():
            shown, was = (format_number(getattr(one, name)) for one in (settings, before))
            entry.show(shown)
            entry.show_file_value(shown, was)
        self._settings["step"].field.set_visibility(settings.has_fixed_step)
        for name in ("rtol", "atol"):
            self._settings[name].field.set_visibility(not settings.has_fixed_step)
        self.looking.set_value(bool(self.page.run.live.rough))
        self.warned.set_text("; ".join(self.page.run.warnings))
