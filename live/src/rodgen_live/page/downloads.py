"""Downloads from the page: the scene, the run, a film, a page without a server, a link."""

from __future__ import annotations

import asyncio
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from nicegui import app, ui

from rodgen.errors import InputError
from rodgen.integrate.solution import Solution
from rodgen.scene import Scene
from rodgen_live.page.fields import Field, dialog, heading, parse_number, show_refusals
from rodgen_live.page.page_run import VIEW, PageRun
from rodgen_live.replay import LEAST
from rodgen_live.run.link import make_link

HALF = 5e-6  # of the last of six digits, by which a time in a field may be off
Progress = Callable[[float], None]  # told the share that is done
Make = Callable[[Solution, Path, Progress], object]


class PageGoneError(Exception):
    """The page that a file is made for is gone."""


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
                ("Link to what is shown", "link", self._make_link),
            ):
                ui.button(text, icon=icon, on_click=clicked).props("flat no-caps align=left")
        self.progress = ui.linear_progress(0.0, show_value=False).props("instant-feedback")
        self.progress.set_visibility(False)
        self.said = ui.label().classes("rg-hint").props('role="status"')
        self.link = ui.input("link").props("dense outlined readonly").classes("rg-wide")
        self.link.set_visibility(False)
        self._linked: Scene | None = None
        self._busy = False
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        page.client.on_delete(self._clear_after_page)

    def refresh(self) -> None:
        """Hide a link to another scene than the present one."""
        if self.page.scene is not self._linked:
            self.link.set_visibility(False)

    def _save_scene(self) -> None:
        scene = self.page.scene
        ui.download.content(self.page.text.encode(), f"{scene.name}.toml", "application/toml")

    async def _make_link(self) -> None:
        view = str(self.page.tab.get(VIEW, ""))
        link = await self.page.call(lambda: make_link(self.page.run, view))
        try:
            packed = link.pack()
        except InputError as error:
            self.said.set_text(str(error))
            return
        self._linked = link.scene
        self.link.set_value(f"{self.page.client.request.base_url}?scene={packed}")
        self.link.set_visibility(True)
        ui.clipboard.write(str(self.link.value))
        self.said.set_text("The link holds the scene as it is, plots and view.")

    async def _samples(self) -> Solution:
        """Samples of the run up to now; what comes later does not change them."""
        return await self.page.call(self.page.run.solution)

    def _make_page(self, solution: Solution, path: Path, _: Progress) -> None:
        self._export(solution, path.with_suffix(""))
        shutil.make_archive(str(path.with_suffix("")), "zip", path.parent, path.stem)

    async def _save_run(self) -> None:
        await self._download(await self._samples(), "nc", lambda run, path, _: run.save(path))

    async def _ask_span(self, ending: str, make: Make) -> None:
        """Open a dialog for the part of the run, as it is at this click, that goes into a file."""
        solution = await self._samples()
        with self.page.root:
            SpanDialog(
                solution, lambda part: self.page.start_task(self._download(part, ending, make))
            )

    async def _download(self, solution: Solution, ending: str, make: Make) -> None:
        """Make a file from a solution, and have it downloaded."""
        if self._busy:
            return
        self._busy = True
        self.progress.set_value(0.0)
        self.progress.set_visibility(True)
        self.said.set_text("writing")
        said = ""
        try:
            said = await self._make_file(solution, ending, make)
        except (InputError, OSError) as error:
            said = str(error)
        except PageGoneError:
            pass
        finally:
            self._busy = False
            if self.page.client.is_deleted:
                self._clear_after_page()
            else:
                self.progress.set_visibility(False)
                self.said.set_text(said)

    async def _make_file(self, solution: Solution, ending: str, make: Make) -> str:
        """Make a file in a thread; it is kept until the next one, as downloads may be slow."""
        self._clear()
        self._folder = tempfile.TemporaryDirectory(prefix="rodgen-", ignore_cleanup_errors=True)
        path = Path(self._folder.name, f"{solution.scene.name}.{ending}")
        progress = self._progress_callback()
        await asyncio.to_thread(make, solution, path, progress)
        progress(1.0)
        ui.download.file(path, path.name)
        span = f"t = {solution.t[0]:.6g} s to {solution.t[-1]:.6g} s"
        return f"{path.name}: {len(solution.t)} samples, {span}"

    def _clear_after_page(self) -> None:
        """Clear up after a page that is gone; what is being written ends by itself."""
        if not self._busy:
            self._clear()

    def _clear(self) -> None:
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    def _progress_callback(self) -> Progress:
        """Make a function that tells the page progress; it raises PageGoneError without a page."""
        loop = asyncio.get_running_loop()

        def progress(share: float) -> None:
            if self.page.client.is_deleted or not app.is_started:
                raise PageGoneError
            loop.call_soon_threadsafe(self.progress.set_value, share)

        return progress


class SpanDialog:
    """Dialog that asks from when to when; `take` is given that part of a solution."""

    def __init__(self, solution: Solution, take: Callable[[Solution], object]):
        self._solution, self._take = solution, take
        with dialog("Part of the run", "Make", self._make) as self._dialog:
            ends = zip(("from", "to"), solution.t[[0, -1]], strict=True)
            self.fields: dict[str, Field] = {
                name: ui.input(name, value=f"{t:.6g}").props("dense outlined suffix=s")
                for name, t in ends
            }
            for field in self.fields.values():
                field.on("keydown.enter", self._make)

    def _make(self) -> None:
        try:
            ends = [parse_number(str(one.value), name) for name, one in self.fields.items()]
            t = self._solution.t
            part = slice(*np.searchsorted(t, [ends[0] - HALF * t[-1], ends[1] + HALF * t[-1]]))
            if len(t[part]) < LEAST:
                raise InputError("to", ends[1], f"so that there are {LEAST} samples or more")
        except InputError as error:
            show_refusals(self.fields, {error.field: f"must be {error.allowed}"})
            return
        self._dialog.close()
        self._take(self._solution.isel(part))


def _make_film(solution: Solution, path: Path, progress: Progress) -> None:
    from rodgen.show.animation.film import animate

    start, span = float(solution.t[0]), float(np.ptp(solution.t))
    animate(solution, path, progress=lambda t: progress((t - start) / span))
