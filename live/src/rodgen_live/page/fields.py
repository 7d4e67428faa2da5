"""Building blocks of panels: headings, icons, dialogs, and fields that say why they refuse."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import contextmanager

from nicegui import ui

from rodgen.errors import InputError

Put = Callable[[str], Awaitable[None]]
Field = ui.input | ui.select

# The style of all fields, switches and buttons of the page, those of the classes below included.
ui.input.default_props("dense outlined")
ui.input.default_classes("rg-wide")
ui.select.default_props("dense outlined options-dense")
ui.switch.default_props("dense")
ui.button.default_props("no-caps")


def heading(text: str, level: int = 2) -> ui.label:
    """The title of the page (level 1), or of a part of a panel."""
    return ui.label(text).classes("rg-title").props(f"role=heading aria-level={level}")


class IconButton(ui.button):
    """A round button with an icon, and its label as a hint and for screen readers."""

    def __init__(self, icon: str, label: str, clicked: Callable[[], object] | None = None):
        super().__init__(icon=icon, on_click=clicked)
        self.props("flat round dense")
        with self:
            self._hint = ui.tooltip("")
        self.rename(label, icon)

    def rename(self, label: str, icon: str) -> None:
        """Give the button another label and icon."""
        if (icon, label) != (self.props.get("icon"), self._hint.text):
            self.props.update({"icon": icon, "aria-label": label})
            self._hint.set_text(label)


@contextmanager
def dialog(
    title: str, verb: str = "", act: Callable[[], object] | None = None
) -> Iterator[ui.dialog]:
    """Open a dialog with what is built in this context, above buttons to act and to cancel, or one
    to close it."""
    with ui.dialog().props(f'aria-label="{title}"') as made, ui.card().classes("rg-dialog"):
        heading(title)
        yield made
        with ui.row():
            if verb:
                ui.button(verb, on_click=act)
            ui.button("Cancel" if verb else "Close", on_click=made.close).props("flat")
    made.on("hide", made.delete)
    made.open()


def ask(
    title: str,
    verb: str,
    texts: Mapping[str, tuple[str, str]],
    take: Callable[[dict[str, str]], Awaitable[None]],
) -> None:
    """Open a dialog of text fields; texts: their labels and what stands there at first, by names.
    `take` is given the texts by names, and may raise InputError: that is shown beside the field
    that it names, or the last one."""

    async def submit() -> None:
        show_refusals(fields, {})
        try:
            await take({name: text_of(field) for name, field in fields.items()})
        except InputError as error:
            named = error.field.rpartition(".")[2]
            shown = named if named in fields else [*fields][-1]
            show_refusals(fields, {shown: f"must be {error.allowed}"})
        else:
            made.close()

    with dialog(title, verb, submit) as made:
        fields: dict[str, Field] = {
            name: ui.input(label, value=text) for name, (label, text) in texts.items()
        }
        for field in fields.values():
            field.props("hide-bottom-space").on("keydown.enter", submit)
        fields[next(iter(fields))].props("autofocus")


def text_of(field: Field) -> str:
    """Text in a field, without blanks around it."""
    return str(field.value or "").strip()


def show_refusal(field: Field, refusal: str) -> None:
    """Show beside a field, and to screen readers, why it is refused; empty: it is fine."""
    field.error = refusal or None
    field.props(**{"add" if refusal else "remove": "aria-invalid=true"})


def show_refusals(fields: Mapping[str, Field], refusals: Mapping[str, str]) -> str:
    """Show beside each field why it is refused, beside the others nothing; returns the refusals of
    names that have no field."""
    for name, field in fields.items():
        show_refusal(field, refusals.get(name, ""))
    return "; ".join(f"{name} {text}" for name, text in refusals.items() if name not in fields)


class Entry:
    """A text field; `put` is given its text when it is left or Enter is pressed, and may raise
    InputError: that is shown beside it, and the run keeps what it had."""

    def __init__(self, label: str, text: str, put: Put, *, unit: str = "", long: bool = False):
        """Build the field; long: in as many lines as the text takes."""
        self._put, self._taken = put, text
        self._asked: str | None = None  # what is being put: Enter is followed by leaving the field
        self.field = ui.input(label, value=text).props("no-error-icon")
        self.field.classes("rg-entry")
        if unit:
            self.field.props(f'suffix="{unit}"')
        if long:
            self.field.props("autogrow")
        self.field.on("keydown.enter.prevent", self._leave)
        self.field.on("blur", self._leave)

    async def _leave(self) -> None:
        text, refusal = text_of(self.field), ""
        if text == self._asked:
            return
        if text != self._taken:
            self._asked = text
            try:
                await self._put(text)
                self._taken = text
            except InputError as error:
                refusal = f"must be {error.allowed}"
            finally:
                self._asked = None
        show_refusal(self.field, refusal)

    def show_file_value(self, text: str, filed: str | None) -> None:
        """Show the value of the scene's file, where it is another; None: that has none."""
        said = "" if filed in (None, text) else f"in the file: {filed or 'none'}"
        if said != self.field.props.get("title", ""):
            self.field.props["title"] = said  # a line more would move what is below
            self.field.classes(**{"add" if said else "remove": "rg-differs"})

    def show(self, text: str) -> None:
        """Show a value that came from elsewhere; what is being typed is left alone."""
        if text != self._taken:
            self._taken = text
            show_refusal(self.field, "")
            self.field.set_value(text)


def parse_number(text: str, field: str) -> float:
    """Parse a finite number. Raises InputError."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(field, text, "a number, such as 0.25 or 1e-3")
    return value


def parse_integer(text: str, field: str) -> int:
    """Parse a whole number. Raises InputError."""
    try:
        return int(text)
    except ValueError:
        raise InputError(field, text, "a whole number") from None


def format_number(value: float | None) -> str:
    """Format a number as it is typed; None is empty."""
    return "" if value is None else f"{value:.10g}"
