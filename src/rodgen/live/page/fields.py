"""What panels are built of: headings, icons, dialogs, and fields that say why they refuse."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import contextmanager

from nicegui import ui

from rodgen.errors import InputError

Put = Callable[[str], Awaitable[None]]
Field = ui.input | ui.select


def heading(text: str, level: int = 2) -> ui.label:
    """The title of the page (level 1), or of a part of a panel."""
    return ui.label(text).classes("rg-title").props(f"role=heading aria-level={level}")


class IconButton(ui.button):
    """A round button with an icon, and its label for who does not see it."""

    def __init__(self, icon: str, label: str, clicked: Callable[[], object] | None = None):
        super().__init__(icon=icon, on_click=clicked)
        self.props("flat round dense")
        with self:
            self._hint = ui.tooltip("")
        self.rename(label, icon)

    def rename(self, label: str, icon: str) -> None:
        """Give it another label and icon."""
        self.props.update({"icon": icon, "aria-label": label})
        self._hint.set_text(label)


@contextmanager
def dialog(
    title: str, verb: str = "", act: Callable[[], object] | None = None
) -> Iterator[ui.dialog]:
    """A dialog that opens with what is built meanwhile, above buttons to act and to cancel, or one
    to close it."""
    with ui.dialog().props(f'aria-label="{title}"') as made, ui.card().classes("rg-dialog"):
        heading(title)
        yield made
        with ui.row():
            if verb:
                ui.button(verb, on_click=act).props("no-caps")
            ui.button("Cancel" if verb else "Close", on_click=made.close).props("flat no-caps")
    made.on("hide", made.delete)
    made.open()


def tell(field: Field, refusal: str | None) -> None:
    """Say beside a field, and to who does not see it, why it is refused; None: it is fine."""
    field.error = refusal
    field.props(**{"add" if refusal else "remove": "aria-invalid=true"})


def refuse(fields: Mapping[str, Field], refusals: Mapping[str, str]) -> str:
    """Say beside each field why it is refused, beside the others nothing; returns what is to be
    said of names that have no field."""
    for name, field in fields.items():
        tell(field, refusals.get(name))
    return "; ".join(f"{name} {text}" for name, text in refusals.items() if name not in fields)


class Entry:
    """A text field; `put` is given its text when it is left or Enter is pressed, and may raise
    InputError: that is said beside it, and the run keeps what it had."""

    def __init__(self, label: str, text: str, put: Put, *, unit: str = "", long: bool = False):
        """long: in as many lines as the text takes."""
        self._put, self._taken = put, text
        self._asked: str | None = None  # what is being put: Enter is followed by leaving the field
        self.field = ui.input(label, value=text).props("dense outlined no-error-icon")
        self.field.classes("rg-entry")
        if unit:
            self.field.props(f'suffix="{unit}"')
        if long:
            self.field.props("autogrow")
        self.field.on("keydown.enter.prevent", self._leave)
        self.field.on("blur", self._leave)

    async def _leave(self) -> None:
        text = str(self.field.value or "").strip()
        if text == self._asked:
            return
        if text == self._taken:
            self.say("")
            return
        self._asked = text
        try:
            await self._put(text)
        except InputError as error:
            self.say(f"must be {error.allowed}")
        else:
            self._taken = text
            self.say("")
        finally:
            self._asked = None

    def say(self, refusal: str) -> None:
        """Show why a text is refused; nothing: it is fine."""
        tell(self.field, refusal or None)

    def shows(self, text: str) -> bool:
        """Whether that is the value that was taken last."""
        return text == self._taken

    def compare(self, text: str, filed: str | None) -> None:
        """Say what the scene's file has, where that is another value; None: it has none."""
        said = None if filed in (None, text) else f"in the file: {filed or 'none'}"
        if said == self.field.props.get("hint"):
            return
        self.field.props.pop("hint", None)
        if said:
            self.field.props["hint"] = said
        self.field.classes(**{"add" if said else "remove": "rg-differs"})
        self.field.update()

    def show(self, text: str) -> None:
        """Another value, that came from elsewhere; what is being typed is left alone."""
        if text == self._taken:
            return
        self._taken = text
        self.say("")
        self.field.set_value(text)


def number(text: str, field: str) -> float:
    """A finite number from a text. Raises InputError."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(field, text, "a number, such as 0.25 or 1e-3")
    return value


def whole_number(text: str, field: str) -> int:
    """A whole number from a text. Raises InputError."""
    try:
        return int(text)
    except ValueError:
        raise InputError(field, text, "a whole number") from None


def plain(value: float | None) -> str:
    """A number as it is typed."""
    return "" if value is None else f"{value:.10g}"
