"""The WebSocket over which a page is told of its run."""

from __future__ import annotations

import asyncio
import json
from contextlib import suppress

from fastapi import WebSocket, WebSocketDisconnect

from rodgen.view.live.run import LiveRun
from rodgen.view.live.web.sessions import Sessions

ADDRESS = "/live/channel/"
LONGEST = 200  # bytes of an acknowledgement
GONE = 4404  # there is no such run


async def channel(socket: WebSocket, name: str, sessions: Sessions) -> None:
    """Frames to the page, acknowledgements from it, until it goes away."""
    await socket.accept()
    run = sessions.get(name)
    if run is None:
        await socket.close(GONE, "this run has ended")
        return
    loop, waiting = asyncio.get_running_loop(), asyncio.Queue[bytes]()

    def send(message: bytes) -> None:
        with suppress(RuntimeError):  # the server is ending
            loop.call_soon_threadsafe(waiting.put_nowait, message)

    run.page.attach(send)
    run.wake_up()
    sending = asyncio.create_task(_forward(socket, waiting))
    try:
        await _listen(socket, run)
    finally:
        run.page.detach(send)
        sending.cancel()


async def _forward(socket: WebSocket, waiting: asyncio.Queue[bytes]) -> None:
    with suppress(WebSocketDisconnect, RuntimeError):  # the page has gone meanwhile
        while True:
            await socket.send_bytes(await waiting.get())


async def _listen(socket: WebSocket, run: LiveRun) -> None:
    # A RuntimeError: sending has found out first that the page is gone.
    with suppress(WebSocketDisconnect, RuntimeError):
        while True:
            text = await socket.receive_text()
            frame = _frame(text)
            if frame is None:
                await socket.close(1008, "not an acknowledgement")
                return
            run.page.acknowledge(frame)


def _frame(text: str) -> int | None:
    """The number of the frame that is acknowledged."""
    try:
        found = json.loads(text)["ack"] if len(text) <= LONGEST else None
    except (ValueError, TypeError, KeyError, RecursionError):
        return None
    return found if isinstance(found, int) else None
