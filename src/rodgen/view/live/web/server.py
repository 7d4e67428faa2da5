"""The server of the live view."""

from __future__ import annotations

import asyncio
import errno
import secrets
import socket
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import uvicorn
from fastapi import FastAPI, WebSocket
from nicegui import app, background_tasks, ui

from rodgen.scene import Scene, SceneError
from rodgen.view.live.scenes import Folder
from rodgen.view.live.web.channel import ADDRESS, channel
from rodgen.view.live.web.guard import OWN, TOKEN, Guard
from rodgen.view.live.web.page import Page
from rodgen.view.live.web.sessions import Sessions

LOOPBACK = "127.0.0.1"
SWEEP = 0.5  # seconds
PORT_ERRORS = (errno.EADDRINUSE, errno.EACCES)


@dataclass(frozen=True)
class Settings:
    """scene: shown first; folder: scenes to choose from; host, port: where the server listens,
    port 0: at any that is free; opens: whether a browser is started; said: told the address."""

    scene: Scene
    folder: Path
    host: str = LOOPBACK
    port: int = 0
    opens: bool = True
    said: Callable[[str], None] = print


def serve(settings: Settings) -> None:
    """Serve until Ctrl-C. Raises SceneError for a port that is taken or a host that is not here."""
    with _listen(settings.host, settings.port) as listening:
        token = None if settings.host in OWN else secrets.token_urlsafe(16)
        server = uvicorn.Server(
            uvicorn.Config(
                Guard(_site(settings, _address(settings, listening, token)), token),
                log_level="warning",
                ws_per_message_deflate=False,
                timeout_graceful_shutdown=2,
            )
        )
        with suppress(KeyboardInterrupt):  # Ctrl-C: it has ended by then
            server.run(sockets=[listening])


def _site(settings: Settings, address: str) -> FastAPI:
    """Page and channel; the address is told once they are there."""
    site, sessions, folder = FastAPI(openapi_url=None), Sessions(), Folder(settings.folder)

    @site.websocket(ADDRESS + "{name}")
    async def _(ws: WebSocket, name: str) -> None:
        await channel(ws, name, sessions)

    @ui.page("/", title="rodgen", response_timeout=20)
    async def _(scene: str = "") -> None:
        await Page(sessions, folder, settings.scene).show(scene)

    async def begin() -> None:
        settings.said(address)
        background_tasks.create(_sweep(sessions))
        if settings.opens:
            await asyncio.to_thread(webbrowser.open, address)

    app.on_startup(begin)
    app.on_shutdown(sessions.close_all)
    ui.run_with(
        site,
        title="rodgen",
        dark=None,
        tailwind=False,
        reconnect_timeout=5.0,
        binding_refresh_interval=None,
        show_welcome_message=False,
    )
    return site


async def _sweep(sessions: Sessions) -> None:
    while True:
        await asyncio.sleep(SWEEP)
        sessions.sweep()


def _address(settings: Settings, listening: socket.socket, token: str | None) -> str:
    """What to type into a browser."""
    name = "localhost" if settings.host in OWN else settings.host
    port = listening.getsockname()[1]
    place = f"[{name}]" if ":" in name else name
    return f"http://{place}:{port}/" + (f"?{TOKEN}={token}" if token else "")


def _listen(host: str, port: int) -> socket.socket:
    """A socket that holds the address from now on."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    found = socket.socket(family, socket.SOCK_STREAM)
    found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        found.bind((host, port))
        found.listen(128)  # so that the address answers as soon as it is told
    except OSError as error:
        found.close()
        reason = getattr(error, "strerror", None) or str(error)
        named, given = ("--port", port) if error.errno in PORT_ERRORS else ("--host", host)
        raise SceneError(named, given, f"one that can be listened on ({reason})") from None
    return found
