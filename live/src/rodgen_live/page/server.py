"""The server of the live view: its address, its page, and the WebSocket of each run."""

from __future__ import annotations

import asyncio
import errno
import mimetypes
import secrets
import socket
import sys
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

import nicegui
import uvicorn
from fastapi import FastAPI, Response, WebSocket, WebSocketDisconnect
from fastapi.middleware.gzip import GZipMiddleware
from nicegui import app, background_tasks, ui

from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen_live.page.access import OWN, TOKEN, AccessGuard
from rodgen_live.page.answers import act_on_answer
from rodgen_live.page.elements import STATIC
from rodgen_live.page.module_builder import ModuleBuilder
from rodgen_live.page.nicegui_assets import replacements
from rodgen_live.page.page import ADDRESS, Page
from rodgen_live.page.sessions import Sessions
from rodgen_live.page.sketch import sketch
from rodgen_live.page.toolbar import SKETCH
from rodgen_live.page.unreadable_messages import UnreadableFilter
from rodgen_live.run.live_run import LiveRun
from rodgen_live.run.scene_text import SceneFolder

LOOPBACK = "127.0.0.1"
EVERYWHERE = {"0.0.0.0", "::"}
ELSEWHERE = ("192.0.2.1", 9)  # of RFC 5737: nobody has it
SWEEP = 0.5  # seconds
# Seconds that NiceGUI's own connection of a page may be gone; it is looked at by answers within two
# fifths of that, which a busy machine needs.
RECONNECT = 30.0
PORT_ERRORS = (errno.EADDRINUSE, errno.EACCES)
MOST_WAITING = 1024  # connections that wait to be taken up: more are cut off without a word
GONE = 4404  # code of a WebSocket: there is no such run


@dataclass(frozen=True)
class ServerSettings:
    """Settings of the server. scene: shown first; folder: scenes to choose from; text: that the
    scene was read from, if it was; host, port: where
    the server listens, port 0: at any that is free; opens: whether a browser is started; moves:
    whether a page begins with a run that moves, over the span of its scene and over again; said:
    told the address, that for other machines where they are let in."""

    scene: Scene
    folder: Path
    text: str = ""
    host: str = LOOPBACK
    port: int = 0
    opens: bool = True
    moves: bool = True
    said: Callable[[str], None] = print


def serve(settings: ServerSettings) -> None:
    """Serve until Ctrl-C. Raises InputError for a port that is taken or a host that is not here."""
    with _listen(settings.host, settings.port) as listening:
        token = None if settings.host in OWN else secrets.token_urlsafe(16)
        port = listening.getsockname()[1]
        modules = ModuleBuilder()
        site = _build_site(settings, modules, *_addresses(settings.host, port, token))
        config = uvicorn.Config(
            AccessGuard(site, token, port),
            log_level="warning",
            ws_per_message_deflate=False,
            timeout_graceful_shutdown=2,
        )
        misunderstood = UnreadableFilter()
        misunderstood.attach()
        with suppress(KeyboardInterrupt):  # Ctrl-C: it has ended by then
            LiveServer(config, modules).run(sockets=[listening])
        if misunderstood.count:
            print(f"rodgen: {misunderstood.count} messages could not be read", file=sys.stderr)


class LiveServer(uvicorn.Server):
    """Server that begins no module once it was told to end."""

    def __init__(self, config: uvicorn.Config, modules: ModuleBuilder):
        super().__init__(config)
        self._modules = modules

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        self._modules.close()
        super().handle_exit(sig, frame)


def _build_site(
    settings: ServerSettings, modules: ModuleBuilder, told: str, opened: str
) -> FastAPI:
    """Build the site; told, opened: addresses that are told, and opened, once it is there."""
    site, sessions, folder = FastAPI(openapi_url=None), Sessions(), SceneFolder(settings.folder)

    @site.websocket(ADDRESS + "{name}")
    async def _(ws: WebSocket, name: str) -> None:
        await serve_channel(ws, name, sessions)

    @ui.page("/", title="rodgen", response_timeout=20)
    async def _(scene: str = "") -> None:
        first = settings.scene, settings.text
        await Page(sessions, modules, folder, *first, settings.moves).show(scene)

    @site.get(SKETCH + "{name}")
    def _(name: str) -> Response:
        try:
            return Response(sketch(folder.scene(name)), media_type="image/svg+xml")
        except InputError as error:
            return Response(str(error), 404, media_type="text/plain")

    for place, content in replacements().items():
        _replace(site, place, content)

    async def begin() -> None:
        settings.said(told)
        background_tasks.create(_close_idle(sessions))
        if settings.opens:
            await asyncio.to_thread(webbrowser.open, opened)

    app.on_startup(begin)
    app.on_shutdown(sessions.close_all)
    ui.run_with(
        site,
        title="rodgen",
        favicon=(STATIC / "icon.svg").read_text("utf-8"),
        dark=None,
        language="en-US",
        tailwind=False,
        reconnect_timeout=RECONNECT,
        binding_refresh_interval=None,
        show_welcome_message=False,
        gzip_middleware_factory=None,
    )
    site.add_middleware(GZipMiddleware)
    return site


def _replace(site: FastAPI, place: str, content: bytes) -> None:
    """Serve other content in place of a file of NiceGUI."""
    kind, _ = mimetypes.guess_type(place)

    @site.get(f"/_nicegui/{nicegui.__version__}/static/{place}")
    def answer() -> Response:
        # Asked for again: another rodgen may have less left out.
        return Response(content, headers={"Cache-Control": "no-cache"}, media_type=kind)


async def _close_idle(sessions: Sessions) -> None:
    while True:
        await asyncio.sleep(SWEEP)
        sessions.close_idle()


def _addresses(host: str, port: int, token: str | None) -> tuple[str, str]:
    """Addresses for a browser, elsewhere where that is possible, and on this machine."""
    everywhere = host in EVERYWHERE
    here = "localhost" if everywhere or host in OWN else host
    elsewhere = _network_name() if everywhere else here

    def address(name: str) -> str:
        place = f"[{name}]" if ":" in name else name
        return f"http://{place}:{port}/" + (f"?{TOKEN}={token}" if token else "")

    return address(elsewhere), address(here)


def _network_name() -> str:
    """Name of this machine for others in its network: the address from which it would send (nothing
    is sent), else its host name."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as outward:
        try:
            outward.connect(ELSEWHERE)
        except OSError:
            return socket.gethostname()
        return str(outward.getsockname()[0])


def _listen(host: str, port: int) -> socket.socket:
    """Open a socket that holds the address from now on."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    found = socket.socket(family, socket.SOCK_STREAM)
    found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        found.bind((host, port))
        found.listen(MOST_WAITING)  # so that the address answers as soon as it is told
    except OSError as error:
        found.close()
        reason = getattr(error, "strerror", None) or str(error)
        named, given = ("--port", port) if error.errno in PORT_ERRORS else ("--host", host)
        raise InputError(named, given, f"one that can be listened on ({reason})") from None
    return found


async def serve_channel(socket: WebSocket, name: str, sessions: Sessions) -> None:
    """Send frames to the page and take its answers, until it goes away."""
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
        await _take_answers(socket, run)
    finally:
        run.page.detach(send)
        sending.cancel()


async def _forward(socket: WebSocket, waiting: asyncio.Queue[bytes]) -> None:
    with suppress(WebSocketDisconnect, RuntimeError):  # the page has gone meanwhile
        while True:
            await socket.send_bytes(await waiting.get())


async def _take_answers(socket: WebSocket, run: LiveRun) -> None:
    # A RuntimeError: sending has found out first that the page is gone.
    with suppress(WebSocketDisconnect, RuntimeError):
        while True:
            if not act_on_answer(run, await socket.receive_text()):
                await socket.close(1008, "not an answer")
                return
