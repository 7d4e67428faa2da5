"""The dialog that asks for a kick in numbers."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from rodgen.scene import SceneError
from rodgen.view.live.web.entry import number, plain

Kick = Callable[[int, float, tuple[float, float]], Awaitable[None]]


class KickDialog:
    """Asks for link, place on it and impulse, and has `kick` give it; a refusal is said beside its
    field."""

    def __init__(self, links: int, link: int, share: float, strength: float, kick: Kick):
        """links: how many there are; link, share, strength [N s]: what stands there at first."""
        self._kick = kick
        with ui.dialog() as self.dialog, ui.card().classes("rg-dialog"):
            ui.label("Kick").classes("rg-title").props("role=heading aria-level=2")
            self.fields = {
                "link": ui.input(f"link, 0 to {links - 1}", value=str(link)),
                "share": ui.input("place on it, 0 (start) to 1 (end)", value=f"{share:.3g}"),
                "x": ui.input("impulse along x [N s]", value="0"),
                "y": ui.input("impulse along y [N s]", value=plain(strength)),
            }
            for field in self.fields.values():
                field.props("dense outlined hide-bottom-space").classes("rg-wide")
                field.on("keydown.enter", self._give)
            self.fields["link"].props("autofocus")
            with ui.row():
                ui.button("Kick", on_click=self._give).props("no-caps")
                ui.button("Cancel", on_click=self.dialog.close).props("flat no-caps")
        self.dialog.on("hide", self.dialog.delete)
        self.dialog.open()

    async def _give(self) -> None:
        for field in self.fields.values():
            field.error = None
        try:
            link = self._link()
            share, x, y = (number(self._text(name), name) for name in ("share", "x", "y"))
            await self._kick(link, share, (x, y))
        except SceneError as error:
            name = error.field.rpartition(".")[2]
            self.fields.get(name, self.fields["y"]).error = f"must be {error.allowed}"
        else:
            self.dialog.close()

    def _link(self) -> int:
        try:
            return int(self._text("link"))
        except ValueError:
            raise SceneError("link", self._text("link"), "a whole number") from None

    def _text(self, name: str) -> str:
        return str(self.fields[name].value or "")
