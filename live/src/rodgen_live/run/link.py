"""Links to a run: a scene, its plots and a view, packed into an address."""

from __future__ import annotations

import base64
import binascii
import json
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen_live.run.scene_edits import LARGEST

if TYPE_CHECKING:
    from rodgen_live.run.live_run import LiveRun


class LinkTables(BaseModel):
    """Tables in a link."""

    scene: dict[str, Any]
    plots: tuple[dict[str, Any], ...]
    view: str
    file: dict[str, Any] | None


@dataclass(frozen=True)
class Link:
    """Content of an address: a scene; plots, as PlotSpec.from_dict takes them; view of the rod;
    file: scene before any change, None if equal."""

    scene: Scene
    plots: tuple[dict[str, Any], ...] = ()
    view: str = ""
    file: Scene | None = None

    def pack(self) -> str:
        """Pack the link into letters, digits, - and _, for an address. Raises InputError for a
        scene that is too long for one."""
        file = None if self.file is None else self.file.to_dict()
        page = {"scene": self.scene.to_dict(), "plots": self.plots, "view": self.view, "file": file}
        content = json.dumps(page).encode()
        if len(content) > LARGEST:
            allowed = f"of at most {LARGEST} bytes in a link: save it as a file"
            raise InputError("scene", f"{len(content)} bytes", allowed)
        return base64.urlsafe_b64encode(zlib.compress(content, 9)).decode().rstrip("=")

    @classmethod
    def unpack(cls, text: str) -> Link:
        """Read a link from a text that `pack` made. Raises InputError for anything else."""
        try:
            data = base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))
            # What is cut off there is no JSON.
            page = LinkTables.model_validate_json(zlib.decompressobj().decompress(data, LARGEST))
        except (binascii.Error, zlib.error, ValueError):
            raise InputError("scene", text[:40], "as the link button gives it") from None
        file = None if page.file is None else Scene.from_dict(page.file)
        return cls(Scene.from_dict(page.scene), page.plots, page.view, file)


def make_link(run: LiveRun, view: str) -> Link:
    """Make a link to a run: its scene and that of its file, its plots, and a view. To be called in
    the thread of the run."""
    scene, file = run.live.scene, run.undo.file
    plots = [one.spec.model_dump(mode="json", exclude={"id"}) for one in run.plots.values()]
    return Link(scene, tuple(plots), view, None if file == scene else file)


def apply_link(run: LiveRun, link: Link) -> None:
    """Give a run of a link's scene its plots, and the file's scene. To be called in the thread of
    the run. Raises InputError for what cannot be had."""
    run.undo.file = link.file or link.scene
    for choice in link.plots:
        run.add_plot(choice)
