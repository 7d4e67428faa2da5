"""The module of a scene, made in a process of its own while the page stays alive."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable

from rodgen.loading.ahead import dump
from rodgen.scene import SceneError, Structure

MOST_LINKS = 2000  # of a live run: beyond, nothing of it is live
ENDING = 2.0  # seconds
PLACES = asyncio.Semaphore(2)  # on a server at a time: the runs need processors too


async def make(structure: Structure, stage: Callable[[str], None]) -> None:
    """Have the module in the cache; stage: told what is being done. Ends the process if it is
    cancelled. Raises SceneError where it cannot be made."""
    if structure.links > MOST_LINKS:
        raise SceneError("rod.links", structure.links, f"at most {MOST_LINKS} in the live view")
    stage("waiting for others")
    async with PLACES:
        await _make(structure, stage)


async def _make(structure: Structure, stage: Callable[[str], None]) -> None:
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "rodgen.loading.ahead"),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    assert process.stderr is not None
    stage("preparing")
    errors = asyncio.create_task(process.stderr.read())
    try:
        process.stdin.write(dump(structure).encode())
        process.stdin.close()
        async for line in process.stdout:
            stage(line.decode().strip())
        await process.wait()
    finally:
        if process.returncode is None:
            await _end(process)
    if process.returncode:
        lines = (await errors).decode(errors="replace").strip().splitlines()
        why = lines[-1] if lines else f"the process ended with {process.returncode}"
        raise SceneError("module", f"n = {structure.links}", f"one that can be made ({why})")


async def _end(process: asyncio.subprocess.Process) -> None:
    """End it, and with it its compiler."""
    process.terminate()
    try:
        await asyncio.wait_for(process.wait(), ENDING)
    except TimeoutError:
        process.kill()
        await process.wait()
