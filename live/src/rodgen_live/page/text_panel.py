"""Panel of the text of a scene, in which anything can be changed."""

from __future__ import annotations

from nicegui import ui

from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen_live.page.fields import heading
from rodgen_live.page.page_run import PANEL, PageRun
from rodgen_live.run.scene_text import refused_line

# Selects a line of a text area, and brings it into view.
SELECT = """
    const area = document.querySelector(".rg-text textarea"), lines = area.value.split("\\n");
    const from = lines.slice(0, %d).join("\\n").length + 1;
    area.focus();
    area.setSelectionRange(from, from + lines[%d].length);
    area.scrollTo(0, %d * area.scrollHeight / lines.length - area.clientHeight / 2);
"""


class TextPanel:
    """Panel of the scene in TOML: made when it is looked at, and for another scene only where
    nothing was typed."""

    def __init__(self, page: PageRun):
        self.page = page
        self._scene: Scene | None = None
        self._shown = ""
        heading("The scene in TOML")
        self.field = ui.textarea().props('outlined dense aria-label="Text of the scene"')
        self.field.props("spellcheck=false").classes("rg-wide rg-text")
        self.refused = ui.label().classes("rg-failed").props('role="alert"')
        with ui.row():
            ui.button("Apply and restart", icon="restart_alt", on_click=self._apply).props(
                "no-caps"
            )
            ui.button("Discard", on_click=self._show).props("flat no-caps")

    def refresh(self) -> None:
        """Show the scene as it is now, where the panel is in view and its text as it was shown."""
        scene = self.page.scene
        typed = self._scene is not None and self.field.value != self._shown
        if self.page.tab[PANEL] == "Text" and not typed and scene != self._scene:
            self._show()

    def _show(self) -> None:
        self._scene, self._shown = self.page.scene, self.page.text
        self.field.set_value(self._shown)
        self.refused.set_text("")

    async def _apply(self) -> None:
        text = str(self.field.value or "")
        self.refused.set_text("")
        try:
            await self.page.run_text(text)
        except InputError as error:
            line = refused_line(text, error)
            self.refused.set_text(f"Line {line}: {error}" if line else str(error))
            if line:
                ui.run_javascript(SELECT % (line - 1, line - 1, line))
        else:
            self._show()
