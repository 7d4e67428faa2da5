"""The module of a scene, made in a process of its own while the page stays responsive."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress

from nicegui import ui

from rodgen.errors import InputError
from rodgen.scene import Scene, Structure
from rodgen_live.page.build_process import dump

MOST_LINKS = 2000  # of a live run: beyond, nothing of it is live
ENDING = 2.0  # seconds
PLACES = 2  # on a server at a time: the runs need processors too
PATIENCE = 0.3  # seconds without a word

Stage = Callable[[str], None]


class ModuleBuilder:
    """Maker of modules that are not in the cache, until the server ends."""

    def __init__(self) -> None:
        self._places, self._closed = asyncio.Semaphore(PLACES), False

    def close(self) -> None:
        """Refuse to make any other module, as the server ends. Signal handlers may call it."""
        self._closed = True

    async def build(self, structure: Structure, stage: Stage) -> None:
        """Make a module and put it into the cache; stage: told what is being done. Ends the process
        if it is cancelled. Raises InputError where it cannot be made."""
        if structure.n_links > MOST_LINKS:
            raise InputError(
                "rod.links", structure.n_links, f"at most {MOST_LINKS} in the live view"
            )
        stage("waiting for others")
        async with self._places:
            if self._closed:
                raise InputError(
                    "module", f"n = {structure.n_links}", "made before the server ends"
                )
            await _build(structure, stage)


async def _build(structure: Structure, stage: Stage) -> None:
    """Make a module in a process of its own.

    It is started by subprocess, which forks without Python. uvloop, the loop of the server, would
    run Python's hooks of a fork in the child, where the threads of the runs are gone.
    """
    loop = asyncio.get_running_loop()
    with tempfile.TemporaryFile() as read, tempfile.TemporaryFile() as errors:
        read.write(dump(structure).encode())
        read.seek(0)
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "rodgen_live.page.build_process"],
            stdin=read,
            stdout=subprocess.PIPE,
            stderr=errors,
        )
        stage("preparing")
        watching = asyncio.create_task(
            asyncio.to_thread(
                _forward_lines, process, lambda line: loop.call_soon_threadsafe(stage, line)
            )
        )
        try:
            await asyncio.shield(watching)
        finally:
            if process.returncode is None:
                await asyncio.to_thread(_end, process)
        errors.seek(0)
        lines = errors.read().decode(errors="replace").strip().splitlines()
    if process.returncode:
        why = lines[-1] if lines else f"the process ended with {process.returncode}"
        raise InputError("module", f"n = {structure.n_links}", f"one that can be made ({why})")


def _forward_lines(process: subprocess.Popen[bytes], say: Callable[[str], object]) -> None:
    """Pass on the lines that a process prints, until it has ended."""
    with process, suppress(RuntimeError):  # the server has ended meanwhile
        assert process.stdout is not None
        for line in process.stdout:
            say(line.decode(errors="replace").strip())


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process, and with it its compiler."""
    process.terminate()
    try:
        process.wait(ENDING)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class BuildProgress:
    """Display of the module that is being made and for how long, with a button to cancel; the rest
    of the page stays responsive."""

    def __init__(self, modules: ModuleBuilder) -> None:
        self._modules = modules
        with ui.element("div").classes("rg-making").props('role="status"') as self._box:
            ui.spinner(size="1.2em")
            self._text = ui.label()
            ui.button("Cancel", on_click=self._cancel).props("flat dense no-caps")
        self._box.set_visibility(False)
        self._what = self._stage = ""
        self._cancelled = self._closed = False
        self._since = 0.0
        self._task: asyncio.Task[None] | None = None
        self._clock = ui.timer(0.25, self._tick, active=False)

    async def build(self, scene: Scene) -> None:
        """Make the module of a scene and put it into the cache. Raises InputError where it cannot
        be made, or was cancelled."""
        links = scene.rod.links
        self._what = f"{scene.name}, {links} link{'s' if links > 1 else ''}"
        if self._closed:
            raise self._refusal()
        self._stage, self._since, self._cancelled = "preparing", time.monotonic(), False
        self._clock.activate()
        self._task = asyncio.create_task(self._modules.build(scene.structure, self._set_stage))
        try:
            await self._task
        except asyncio.CancelledError:
            if not self._cancelled:  # it is the server that ends
                raise
            raise self._refusal() from None
        finally:
            self._clock.deactivate()
            if not self._closed:
                self._box.set_visibility(False)

    def _refusal(self) -> InputError:
        return InputError("module", self._what, "compiled first, which was cancelled")

    def close(self) -> None:
        """Cancel, and make nothing any more, as the page is gone."""
        self._closed = True
        self._cancel()

    def _cancel(self) -> None:
        if self._task is not None:
            self._cancelled = True
            self._task.cancel()

    def _set_stage(self, stage: str) -> None:
        self._stage = stage

    def _tick(self) -> None:
        took = time.monotonic() - self._since
        self._text.set_text(f"{self._what}: {self._stage}, {took:.0f} s")
        self._box.set_visibility(took > PATIENCE)
