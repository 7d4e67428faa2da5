"""Upload of a scene's file that is chosen in the browser."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from rodgen_live.page.elements import STATIC
from rodgen_live.page.fields import IconButton
from rodgen_live.run.scene_edits import LARGEST

ENDING = ".toml"


class SceneFile(Element, component=STATIC / "scene_file.js"):
    """A button that opens a dialog for files; chosen: given the text of one; refused: called for
    what is longer than a scene, or no text.

    NiceGUI's own upload has a route for every element, which FastAPI keeps with all of its page.
    """

    def __init__(
        self, chosen: Callable[[str], Awaitable[None]], refused: Callable[[], object]
    ) -> None:
        super().__init__()
        self._chosen, self._pieces = chosen, list[str]()
        self._props |= {"ending": ENDING, "most": LARGEST}
        self.on("piece", self._add_piece)
        self.on("refused", refused)
        pick = f'() => runMethod({self.id}, "pick", [])'
        button = IconButton("folder_open", "Open a file").on("click", js_handler=pick)
        button.classes("rg-open")

    async def _add_piece(self, event: GenericEventArguments) -> None:
        self._pieces.append(str(event.args["text"]))
        if sum(map(len, self._pieces)) > LARGEST:  # no browser of ours sends that
            self._pieces.clear()
        elif event.args["last"]:
            text = "".join(self._pieces)
            self._pieces.clear()
            await self._chosen(text)
