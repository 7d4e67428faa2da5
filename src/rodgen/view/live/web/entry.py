"""A field for a value: what is refused is said beside it, and the run keeps what it had."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable

from nicegui import ui

from rodgen.scene import SceneError

Put = Callable[[str], Awaitable[None]]


class Entry:
    """A text field; `put` is given its text when it is left or Enter is pressed, and may raise
    SceneError."""

    def __init__(self, label: str, text: str, put: Put, *, unit: str = ""):
        self._put, self._taken = put, text
        self._asked: str | None = None  # what is being put: Enter is followed by leaving the field
        self.field = ui.input(label, value=text).props("dense outlined no-error-icon")
        self.field.classes("rg-entry")
        if unit:
            self.field.props(f'suffix="{unit}"')
        self.field.on("keydown.enter", self._leave)
        self.field.on("blur", self._leave)

    async def _leave(self) -> None:
        text = str(self.field.value or "").strip()
        if text == self._asked:
            return
        if text == self._taken:
            self.said("")
            return
        self._asked = text
        try:
            await self._put(text)
        except SceneError as error:
            self.said(f"must be {error.allowed}")
        else:
            self._taken = text
            self.said("")
        finally:
            self._asked = None

    def said(self, refusal: str) -> None:
        """Show why a text is refused; nothing: it is fine."""
        self.field.error = refusal or None

    def shows(self, text: str) -> bool:
        """Whether that is the value that was taken last."""
        return text == self._taken

    def show(self, text: str) -> None:
        """Another value, that came from elsewhere; what is being typed is left alone."""
        if text == self._taken:
            return
        self._taken = text
        self.said("")
        self.field.set_value(text)


def number(text: str, field: str) -> float:
    """A finite number from a text. Raises SceneError."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SceneError(field, text, "a number, such as 0.25 or 1e-3")
    return value


def plain(value: float | None) -> str:
    """A number as it is typed."""
    return "" if value is None else f"{value:.10g}"
