"""Links to a run: a scene, its plots and a view, packed into an address."""

from __future__ import annotations

import base64
import binascii
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import tomli_w

from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen.scene.plain_tables import parse_toml
from rodgen_live.run.scene_edits import LARGEST

if TYPE_CHECKING:
    from rodgen_live.run.live_run import LiveRun

PAGE = "page"  # the table beside those of the scene


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
        page: dict[str, Any] = {"plots": list(self.plots), "view": self.view}
        if self.file is not None:
            page["file"] = self.file.to_dict()
        text = self.scene.to_toml() + "\n" + tomli_w.dumps({PAGE: page})
        if len(text.encode()) > LARGEST:
            allowed = f"of at most {LARGEST} bytes in a link: save it as a file"
            raise InputError("scene", f"{len(text.encode())} bytes", allowed)
        return base64.urlsafe_b64encode(zlib.compress(text.encode(), 9)).decode().rstrip("=")

    @classmethod
    def unpack(cls, text: str) -> Link:
        """Read a link from a text that `pack` made. Raises InputError for anything else."""
        try:
            data = base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))
            content = zlib.decompressobj().decompress(data, LARGEST + 1)
        except (binascii.Error, zlib.error, ValueError):
            raise _refusal("scene", text[:40]) from None
        if len(content) > LARGEST:
            raise InputError("scene", f"{len(content)} bytes", f"at most {LARGEST} bytes")
        table = parse_toml(content, "this address")
        page = table.pop(PAGE, {})
        scene = Scene.from_dict(table)
        if not isinstance(page, dict):
            raise _refusal(PAGE, page)
        plots, view = page.get("plots", []), page.get("view", "")
        file = Scene.from_dict(page["file"]) if "file" in page else None
        if not (isinstance(plots, list) and all(isinstance(one, dict) for one in plots)):
            raise _refusal("page.plots", plots)
        if not isinstance(view, str):
            raise _refusal("page.view", view)
        return cls(scene, tuple(plots), view, file)


def _refusal(field: str, value: Any) -> InputError:
    return InputError(field, value, "as the link button gives it")


def make_link(run: LiveRun, view: str) -> Link:
    """Make a link to a run: its scene and that of its file, its plots, and a view. To be called in
    the thread of the run."""
    plots = [plot.spec.to_dict() for plot in run.plots.values()]
    choices = ({key: plot[key] for key in plot if key != "id"} for plot in plots)
    scene, file = run.live.scene, run.undo.file
    return Link(scene, tuple(choices), view, None if file == scene else file)


def apply_link(run: LiveRun, link: Link) -> None:
    """Give a run of a link's scene its plots, and the file's scene. To be called in the thread of
    the run. Raises InputError for what cannot be had."""
    run.undo.file = link.file or link.scene
    for choice in link.plots:
        run.add_plot(choice)
