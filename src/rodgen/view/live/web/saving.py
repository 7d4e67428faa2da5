"""What can be taken away: the scene, the run, an animation, a link."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from nicegui import ui

from rodgen.integrate.solution import Solution
from rodgen.scene import SceneError
from rodgen.view.live.scenes import packed, to_toml

if TYPE_CHECKING:
    from rodgen.view.live.web.page import Page

Progress = Callable[[float], None]  # told the share that is done
Make = Callable[[Solution, Path, Progress], object]


class Saving:
    """Buttons; what takes long is made in a thread while the run goes on."""

    def __init__(self, page: Page):
        self.page = page
        ui.label("Save").classes("rg-title").props("role=heading aria-level=2")
        with ui.element("div").classes("rg-save"):
            for text, icon, clicked in (
                ("Scene as TOML", "description", self._scene),
                ("Run as NetCDF", "save", self._run),
                ("Animation as MP4", "movie", lambda: self._animation("mp4")),
                ("Animation as GIF", "gif_box", lambda: self._animation("gif")),
                ("Link to this scene", "link", self._link),
            ):
                ui.button(text, icon=icon, on_click=clicked).props("flat no-caps align=left")
        self.progress = ui.linear_progress(0.0, show_value=False).props("instant-feedback")
        self.progress.set_visibility(False)
        self.said = ui.label().classes("rg-hint").props('role="status"')
        self.link = ui.input("link").props("dense outlined readonly").classes("rg-wide")
        self.link.set_visibility(False)
        self._busy = False

    def refresh(self) -> None:
        """Nothing here changes with the scene but the link."""
        self.link.set_visibility(False)

    def _scene(self) -> None:
        scene = self.page.scene
        ui.download.content(to_toml(scene).encode(), f"{scene.name}.toml", "application/toml")

    async def _link(self) -> None:
        place = await ui.run_javascript("window.location.origin")
        self.link.set_value(f"{place}/?scene={packed(self.page.scene)}")
        self.link.set_visibility(True)
        ui.clipboard.write(str(self.link.value))
        self.said.set_text("The link reproduces the scene with its present parameters.")

    async def _run(self) -> None:
        await self._made("nc", lambda solution, path, _: solution.save(path))

    async def _animation(self, ending: str) -> None:
        from rodgen.view.animation import animate

        def made(solution: Solution, path: Path, progress: Progress) -> None:
            start, end = float(solution.t[0]), float(solution.t[-1])
            animate(solution, path, progress=lambda t: progress((t - start) / (end - start)))

        await self._made(ending, made)

    async def _made(self, ending: str, make: Make) -> None:
        """A file from all samples so far, made in a thread, then downloaded."""
        if self._busy:
            return
        self._busy = True
        self.progress.set_value(0.0)
        self.progress.set_visibility(True)
        self.said.set_text("writing")
        loop = asyncio.get_running_loop()

        def progress(share: float) -> None:
            loop.call_soon_threadsafe(self.progress.set_value, share)

        try:
            solution = await self.page.do(self.page.run.solution)
            with tempfile.TemporaryDirectory(prefix="rodgen-") as folder:
                path = Path(folder, f"{solution.scene.name}.{ending}")
                await asyncio.to_thread(make, solution, path, progress)
                content = await asyncio.to_thread(path.read_bytes)
            ui.download.content(content, path.name)
            span = f"t = {solution.t[0]:.6g} s to {solution.t[-1]:.6g} s"
            self.said.set_text(f"{path.name}: {len(solution.t)} samples, {span}")
        except SceneError as error:
            self.said.set_text(str(error))
        finally:
            self._busy = False
            self.progress.set_visibility(False)
