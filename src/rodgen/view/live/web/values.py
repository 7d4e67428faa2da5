"""The panel of values: texts that the channel keeps up to date."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nicegui import ui

from rodgen.view.live.quantities.texts import Row, groups

if TYPE_CHECKING:
    from rodgen.view.live.web.page import Page


class Values:
    """A table for each group of rows; built anew where the scene has other rows."""

    def __init__(self, page: Page):
        self.page = page
        self._rows: object = None
        self._box = ui.element("div").classes("rg-values")

    def refresh(self) -> None:
        """As the scene is now."""
        rows = groups(self.page.scene)
        if rows == self._rows:
            return
        self._rows = rows
        self._box.clear()
        with self._box:
            for title, group in rows.items():
                with ui.element("table"):
                    with ui.element("caption"):
                        ui.label(title)
                    for row in group:
                        with ui.element("tr"):
                            _cells(row)
        self.page.soon(self.page.run.page.structure_changed)
        self.page.soon(self.page.run.page.touched)


def _cells(row: Row) -> None:
    """Of a row: label, value and unit, or a text over all of their columns."""
    if not row.label:
        ui.element("td").props(f'data-text="{row.key}" colspan=3').classes("rg-words")
        return
    with ui.element("th").props('scope="row"'):
        ui.label(row.label)
    ui.element("td").props(f'data-text="{row.key}"')
    with ui.element("td").classes("rg-unit"):
        ui.label(row.unit)
