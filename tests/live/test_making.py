"""Modules made in a process of their own: a compiler that would not end stands for a slow one."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

import pytest

from rodgen.scene import Scene, SceneError, Structure
from rodgen.view.live.web.making import make

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the compiler here is a shell script")

T = TypeVar("T")


def finished(work: Coroutine[Any, Any, T]) -> T:
    """What comes of it, in a thread of its own: a browser may have the loop of this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, work).result()


def structure(links: int) -> Structure:
    rod = {"links": links, "length": 1.0, "bending_stiffness": 1.0, "mass": 1.0}
    table = {"name": "rod", "rod": rod, "integrate": {"span": [0.0, 1.0]}}
    return Scene.from_dict(table).structure


@pytest.fixture
def compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a file for each compiler that was started, by the id of its process."""
    script = tmp_path / "cc"
    started = tmp_path / "started"
    started.mkdir()
    script.write_text(f"#!/bin/sh\ntouch {started}/$$\nexec sleep 600\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))
    return started


def runs(process: int) -> bool:
    """Whether a process is there, and not only its entry."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


async def until(true: Callable[[], bool]) -> None:
    async with asyncio.timeout(60.0):
        while not true():
            await asyncio.sleep(0.05)


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are seen in /proc")
def test_cancelled_making_ends_its_compiler(compiler: Path) -> None:
    async def cancelled() -> int:
        stages: list[str] = []
        making = asyncio.create_task(make(structure(2), stages.append))
        await until(lambda: any(compiler.iterdir()))
        (process,) = (int(file.name) for file in compiler.iterdir())
        assert runs(process)
        assert stages[-1] == "compiling"
        making.cancel()
        with pytest.raises(asyncio.CancelledError):
            await making
        return process

    assert not runs(finished(cancelled()))


def test_two_at_a_time(compiler: Path) -> None:
    """The third begins when one of the others is given up."""

    async def three() -> None:
        making = [asyncio.create_task(make(structure(n), lambda _: None)) for n in (2, 3, 4)]
        await until(lambda: len(list(compiler.iterdir())) == 2)
        await asyncio.sleep(1.0)
        assert len(list(compiler.iterdir())) == 2
        making[0].cancel()
        await until(lambda: len(list(compiler.iterdir())) == 3)
        for task in making[1:]:
            task.cancel()
        await asyncio.gather(*making, return_exceptions=True)

    finished(three())


def test_too_many_links_are_refused_at_once() -> None:
    with pytest.raises(SceneError, match="at most 2000"):
        finished(make(structure(2001), lambda _: None))
