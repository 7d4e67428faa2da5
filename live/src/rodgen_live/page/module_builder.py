"""The module of a scene, made in a process of its own while the page stays responsive."""

from __future__ import annotations

import asyncio
import pickle
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress

from nicegui import ui

from rodgen.errors import InputError
from rodgen.loading import build_fastest, is_derived
from rodgen.scene import Scene, Structure
from rodgen_live.page.build_process import PARTS
from rodgen_live.run.run_thread import from_threads
from rodgen_live.run.worker_process import end_process

MOST_LINKS = 2000  # of a live run: beyond, nothing of it is live
PLACES = 2  # on a server at a time: the runs need processors too
PATIENCE = 0.3  # seconds without a word

Stage = Callable[[str], None]


class ModuleBuilder:
    """Maker of modules that are not in the cache; none is begun once the server `ends`."""

    def __init__(self, ends: Callable[[], bool] = lambda: False) -> None:
        self._places, self._ends = asyncio.Semaphore(PLACES), ends

    async def load(self, structure: Structure) -> bool:
        """Load a module that needs no derivation, beside all else; returns whether it is one."""
        return await asyncio.to_thread(_load, structure)

    async def build(self, structure: Structure, stage: Stage) -> None:
        """Make a module and put it into the cache; stage: told what is being done. Ends the process
        if it is cancelled. Raises InputError where it cannot be made."""
        if structure.n_links > MOST_LINKS:
            raise InputError(
                "rod.links", structure.n_links, f"at most {MOST_LINKS} in the live view"
            )
        if await self.load(structure):
            return
        stage("waiting for others")
        async with self._places:
            if self._ends():
                raise InputError(
                    "module", f"n = {structure.n_links}", "made before the server ends"
                )
            await _build(structure, stage)


def _load(structure: Structure) -> bool:
    """Load a module and SciPy's part by which its forces are computed, unless it is to be
    derived."""
    if derived := is_derived(structure, PARTS):
        import scipy.linalg  # noqa: F401  here, lest the page wait for it at its first forces

        build_fastest(structure, PARTS)
    return derived


async def _build(structure: Structure, stage: Stage) -> None:
    """Make a module in a process of its own.

    It is started by subprocess, which forks without Python. uvloop, the loop of the server, would
    run Python's hooks of a fork in the child, where the threads of the runs are gone.
    """
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "rodgen_live.page.build_process"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    stage("preparing")
    watch = asyncio.to_thread(_watch, process, structure, from_threads(stage))
    watching = asyncio.create_task(watch)
    try:
        last = await asyncio.shield(watching)
    finally:
        if process.returncode is None:
            await asyncio.to_thread(end_process, process)  # and with it its compiler
    if process.returncode:
        why = last or f"the process ended with {process.returncode}"
        raise InputError("module", f"n = {structure.n_links}", f"one that can be made ({why})")


def _watch(process: subprocess.Popen[bytes], structure: Structure, say: Stage) -> str:
    """Give a process its structure, and pass on the lines that it prints, until it has ended;
    returns the last one, which is an error where there was one."""
    line = ""
    with process:
        assert process.stdin is not None
        assert process.stdout is not None
        with suppress(BrokenPipeError), process.stdin:  # it may have ended already
            pickle.dump(structure, process.stdin)
        for read in process.stdout:
            say(line := read.decode(errors="replace").strip())
    return line


class BuildProgress:
    """Display of the module that is being made and for how long, with a button to cancel; the rest
    of the page stays responsive."""

    def __init__(self, modules: ModuleBuilder) -> None:
        self._modules = modules
        with ui.element("div").classes("rg-making").props('role="status"') as self._box:
            ui.spinner(size="1.2em")
            self._text = ui.label()
            ui.button("Cancel", on_click=self.cancel).props("flat dense")
        self._box.set_visibility(False)
        self._what = self._stage = ""
        self._since = 0.0
        self._task: asyncio.Task[None] | None = None
        self._clock = ui.timer(0.25, self._tick, active=False)

    async def build(self, scene: Scene) -> None:
        """Make the module of a scene and put it into the cache. Raises InputError where it cannot
        be made, or was cancelled."""
        links = scene.rod.links
        self._what = f"{scene.name}, {links} link{'s' if links > 1 else ''}"
        refusal = InputError("module", self._what, "compiled first, which was cancelled")
        if self._box.is_deleted:  # with its page
            raise refusal
        self._stage, self._since = "preparing", time.monotonic()
        self._clock.activate()
        self._task = asyncio.create_task(self._modules.build(scene.structure, self._set_stage))
        try:
            await self._task
        except asyncio.CancelledError:
            if self._task is not None:  # it is the server that ends
                raise
            raise refusal from None
        finally:
            self._clock.deactivate()
            if not self._box.is_deleted:
                self._box.set_visibility(False)

    def cancel(self) -> None:
        """Cancel what is being made, if anything is."""
        if self._task is not None:
            self._task.cancel()
            self._task = None

    def _set_stage(self, stage: str) -> None:
        self._stage = stage

    def _tick(self) -> None:
        took = time.monotonic() - self._since
        self._text.set_text(f"{self._what}: {self._stage}, {took:.0f} s")
        self._box.set_visibility(took > PATIENCE)
