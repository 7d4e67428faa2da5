"""A field for a value: what is refused is said beside it, and the run keeps what it had."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from rodgen.scene import SceneError

Put = Callable[[str], Awaitable[None]]


class Entry:
    """A text field; `put` is given its text when it is left or Enter is pressed, and may raise
    SceneError."""

    def __init__(self, label: str, text: str, put: Put, *, unit: str = "", key: str = ""):
        self._put, self._taken = put, text
        self.field = ui.input(label, value=text).props("dense outlined no-error-icon")
        self.field.classes("rg-entry")
        if unit:
            self.field.props(f'suffix="{unit}"')
        self.field.on("keydown.enter", self._leave)
        self.field.on("blur", self._leave)

    async def _leave(self) -> None:
        text = str(self.field.value or "").strip()
        if text == self._taken:
            self.said("")
            return
        try:
            await self._put(text)
        except SceneError as error:
            self.said(f"must be {error.allowed}" if error.allowed else str(error))
        else:
            self._taken = text
            self.said("")

    def said(self, refusal: str) -> None:
        """Show why a text is refused; nothing: it is fine."""
        self.field.error = refusal or None

    def show(self, text: str) -> None:
        """Another value, that came from elsewhere; what is being typed is left alone."""
        if text == self._taken:
            return
        self._taken = text
        self.said("")
        self.field.set_value(text)


def number(text: str, field: str) -> float:
    """A number from a text. Raises SceneError."""
    try:
        return float(text.replace(",", "."))
    except ValueError:
        raise SceneError(field, text, "a number") from None


def plain(value: float | None) -> str:
    """A number as it is typed."""
    return "" if value is None else f"{value:.10g}"
