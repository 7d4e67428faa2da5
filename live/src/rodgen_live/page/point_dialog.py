"""A dialog that asks for a point of a link, and for numbers of what acts there."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping

from nicegui import ui

from rodgen.errors import InputError
from rodgen_live.page.fields import (
    Field,
    dialog,
    format_number,
    parse_integer,
    parse_number,
    show_refusals,
)

Give = Callable[[int, float, tuple[float, float]], Awaitable[None]]


class PointDialog:
    """Dialog for a link, the place on it and two components, passed on to `give`; a refusal is
    shown beside its field."""

    def __init__(
        self,
        title: str,
        links: int,
        point: tuple[int, float],
        components: Mapping[str, float],
        give: Give,
    ):
        """Open the dialog; links: how many there are; point: link and share of it that stand there
        at first; components: labels of x and y, and what stands there at first."""
        self._give_it = give
        (x, at_x), (y, at_y) = components.items()
        with dialog(title, title, self._submit) as self.dialog:
            self.fields: dict[str, Field] = {
                "link": ui.input(f"link, 0 to {links - 1}", value=str(point[0])),
                "share": ui.input("place on it, 0 (start) to 1 (end)", value=f"{point[1]:.3g}"),
                "x": ui.input(x, value=format_number(at_x)),
                "y": ui.input(y, value=format_number(at_y)),
            }
            for field in self.fields.values():
                field.props("dense outlined hide-bottom-space").classes("rg-wide")
                field.on("keydown.enter", self._submit)
            self.fields["link"].props("autofocus")

    async def _submit(self) -> None:
        show_refusals(self.fields, {})
        try:
            link = parse_integer(self._text("link"), "link")
            share, x, y = (parse_number(self._text(name), name) for name in ("share", "x", "y"))
            await self._give_it(link, share, (x, y))
        except InputError as error:
            name = error.field.rpartition(".")[2]
            shown = name if name in self.fields else "y"
            show_refusals(self.fields, {shown: f"must be {error.allowed}"})
        else:
            self.dialog.close()

    def _text(self, name: str) -> str:
        return str(self.fields[name].value or "")
