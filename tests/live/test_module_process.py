"""Modules made in a process of their own: a compiler that would not end stands for a slow one."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from rodgen.live.page import module_process
from rodgen.live.page.module_process import Modules
from rodgen.loading.ahead import dump, parse
from rodgen.scene import Scene, SceneError, Structure
from tests.live.conftest import ROD, SCENES, finished, runs
from tests.live.view import PATIENT

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the compiler here is a shell script")


def quiet(_: str) -> None:
    """Of no use is what is being done."""


def structure(links: int) -> Structure:
    rod = {"links": links, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}
    table = {"name": "rod", "rod": rod, "integrate": {"span": [0.0, 1.0]}}
    return Scene.from_dict(table).structure


@pytest.fixture
def compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a file for each compiler that was started, by the id of its process, with that
    of the process that it works for."""
    script = tmp_path / "cc"
    started = tmp_path / "started"
    started.mkdir()
    script.write_text(f"#!/bin/sh\necho $PPID > {started}/$$\nexec sleep 600\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))
    return started


async def until(true: Callable[[], bool]) -> None:
    async with asyncio.timeout(PATIENT):
        while not true():
            await asyncio.sleep(0.05)


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are seen in /proc")
def test_cancelled_making_ends_its_compiler(compiler: Path) -> None:
    async def cancelled() -> None:
        stages: list[str] = []
        task = asyncio.create_task(Modules().make(structure(2), stages.append))
        await until(lambda: any(map(runs, started())))
        assert stages
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    def started() -> list[int]:
        return [int(file.name) for file in compiler.iterdir()]

    finished(cancelled())
    assert started()
    assert not any(map(runs, started()))


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_structure_comes_to_the_process_as_it_is(path: Path) -> None:
    one = Scene.from_toml(path).structure
    assert parse(dump(one)) == one
    assert hash(parse(dump(one))) == hash(one)


def test_two_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """The third begins when one of the others is given up."""
    begun: list[int] = []

    async def endless(structure: Structure, _: object) -> None:
        begun.append(structure.links)
        await asyncio.Event().wait()

    async def three() -> None:
        modules = Modules()
        tasks = [asyncio.create_task(modules.make(structure(n), quiet)) for n in (2, 3, 4)]
        await until(lambda: len(begun) == 2)
        await asyncio.sleep(0.1)
        assert begun == [2, 3]
        tasks[0].cancel()
        await until(lambda: len(begun) == 3)
        for task in tasks[1:]:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    monkeypatch.setattr(module_process, "_make", endless)
    finished(three())


def test_too_many_links_are_refused_at_once() -> None:
    with pytest.raises(SceneError, match="at most 2000"):
        finished(Modules().make(structure(2001), quiet))


def test_nothing_is_begun_while_the_server_ends(compiler: Path) -> None:
    modules = Modules()
    modules.close()
    with pytest.raises(SceneError, match="module"):
        finished(modules.make(structure(2), quiet))
    assert list(compiler.iterdir()) == []


def test_no_hook_of_a_fork_runs_in_the_process(tmp_path: Path) -> None:
    """Threads of the server are gone there, and Python's own hooks fail at times. With the loop
    that the server has."""
    uvloop = pytest.importorskip("uvloop", reason="the extra view is not installed")
    seen = tmp_path / "seen"
    listening = [True]  # a hook stays for good
    os.register_at_fork(after_in_child=lambda: listening and seen.touch())
    try:
        finished(Modules().make(Scene.from_dict(ROD).structure, quiet), uvloop.new_event_loop)
    finally:
        listening.clear()
    assert not seen.exists()
