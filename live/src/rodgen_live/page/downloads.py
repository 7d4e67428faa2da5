"""Downloads from the page: the scene, the run, a film, a page without a server, a link."""

from __future__ import annotations

import asyncio
import shutil
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from nicegui import app, ui

from rodgen.errors import InputError
from rodgen.integrate.solution import Solution
from rodgen.scene import Scene
from rodgen_live.page.fields import ask, heading, parse_number
from rodgen_live.page.page_run import VIEW, PageRun
from rodgen_live.replay import LEAST
from rodgen_live.run.link import make_link

HALF = 5e-6  # of the last of six digits, by which a time in a field may be off
WHAT = {"mp4": "film", "zip": "page"}  # a file of which a part of the run is asked, by its ending
Progress = Callable[[float], None]  # told the share that is done
Make = Callable[[Solution, Path, Progress], object]


class DownloadsPanel:
    """Buttons to save; a file that takes long is made in a thread while the run goes on."""

    def __init__(self, page: PageRun, export: Callable[[Solution, Path], object]):
        """Build the panel; export: writes a solution as a page, a folder."""
        self.page, self._export = page, export
        heading("Save")
        with ui.element("div").classes("rg-save"):
            for text, icon, clicked in (
                ("Scene as TOML", "description", self._save_scene),
                ("Run as NetCDF", "save", self._save_run),
                ("Film as MP4", "movie", lambda: self._ask_span("mp4", _make_film)),
                ("Page without a server", "web", lambda: self._ask_span("zip", self._make_page)),
                ("Link to what is shown", "link", lambda: page.start_task(self._make_link())),
            ):
                ui.button(text, icon=icon, on_click=clicked).props("flat align=left")
        self.progress = ui.linear_progress(0.0, show_value=False).props("instant-feedback")
        self.progress.set_visibility(False)
        self.said = ui.label().classes("rg-hint").props('role="status"')
        self.link = ui.input("link").props("readonly")
        self.link.set_visibility(False)
        self._linked: Scene | None = None
        self._folder = tempfile.TemporaryDirectory(prefix="rodgen-", ignore_cleanup_errors=True)
        page.client.on_delete(self._folder.cleanup)  # kept until then, as downloads may be slow

    def refresh(self) -> None:
        """Hide a link to another scene than the present one."""
        if self.page.scene is not self._linked:
            self.link.set_visibility(False)

    def _save_scene(self) -> None:
        scene = self.page.scene
        ui.download.content(self.page.text.encode(), f"{scene.name}.toml", "application/toml")

    async def _make_link(self) -> None:
        view = str(self.page.tab.get(VIEW, ""))
        link = await self.page.call(make_link, self.page.run, view)
        self.link.set_value(f"{self.page.client.request.base_url}?scene={link.pack()}")
        self._linked = link.scene
        self.link.set_visibility(True)
        ui.clipboard.write(str(self.link.value))
        self.said.set_text("The link holds the scene as it is, plots and view.")

    def _make_page(self, solution: Solution, path: Path, _: Progress) -> None:
        self._export(solution, path.with_suffix(""))
        shutil.make_archive(str(path.with_suffix("")), "zip", path.parent, path.stem)

    async def _save_run(self) -> None:
        solution = await self.page.call(self.page.run.solution)
        await self._download(solution, "nc", lambda run, path, _: run.save(path))

    async def _ask_span(self, ending: str, make: Make) -> None:
        """Open a dialog for the part of the run, as it is at this click, that goes into a file."""
        solution = await self.page.call(self.page.run.solution)
        t = solution.t

        async def take(given: Mapping[str, str]) -> None:
            start, end = (parse_number(given[name], name) for name in ("from", "to"))
            part = slice(*np.searchsorted(t, [start - HALF * t[-1], end + HALF * t[-1]]))
            if len(t[part]) < LEAST:
                raise InputError("to", end, f"late enough for {LEAST} samples or more")
            self.page.start_task(self._download(solution.isel(part), ending, make))

        ends = {"from": ("from [s]", f"{t[0]:.6g}"), "to": ("to [s]", f"{t[-1]:.6g}")}
        with self.page.root:
            ask(f"Part of the run for the {WHAT[ending]}", "Make", ends, take)

    async def _download(self, solution: Solution, ending: str, make: Make) -> None:
        if self.progress.visible:  # another one is being made
            return
        loop = asyncio.get_running_loop()
        path = Path(self._folder.name, f"{solution.scene.name}.{ending}")
        path.unlink(missing_ok=True)

        def progress(share: float) -> None:
            if self.page.client.is_deleted or not app.is_started:
                raise InterruptedError  # to nobody: the page is gone
            loop.call_soon_threadsafe(self.progress.set_value, share)

        self.progress.set_value(0.0)
        self.progress.set_visibility(True)
        self.said.set_text("writing")
        said = ""
        try:
            await asyncio.to_thread(make, solution, path, progress)
            progress(1.0)
            ui.download.file(path, path.name)
            span = f"t = {solution.t[0]:.6g} s to {solution.t[-1]:.6g} s"
            said = f"{path.name}: {len(solution.t)} samples, {span}"
        except (InputError, OSError) as error:
            said = str(error)
        finally:
            if self.page.client.is_deleted:
                self._folder.cleanup()  # of what was written since
            else:
                self.progress.set_visibility(False)
                self.said.set_text(said)


def _make_film(solution: Solution, path: Path, progress: Progress) -> None:
    from rodgen.show.animation.film import animate

    start, span = float(solution.t[0]), float(np.ptp(solution.t))
    animate(solution, path, progress=lambda t: progress((t - start) / span))
