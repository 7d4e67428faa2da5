"""The server of the live view: its address, its page, and the WebSocket of each run."""

from __future__ import annotations

import asyncio
import errno
import json
import mimetypes
import secrets
import socket
import sys
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import NoneType
from typing import Any

import nicegui
import uvicorn
from fastapi import FastAPI, Response, WebSocket, WebSocketDisconnect
from fastapi.middleware.gzip import GZipMiddleware
from nicegui import app, ui

from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen_live.page.access import OWN, TOKEN, AccessGuard
from rodgen_live.page.elements import ICONS, STATIC, icon_font
from rodgen_live.page.module_builder import ModuleBuilder
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
# Instead of DOMPurify: the page shows no HTML of others. What is asked for is shown as text.
PURIFIER = b"""export default new Proxy({}, { get: (_, name) =>
    name === "sanitize" ? html => new Option(html).innerHTML : () => {} });
"""
LONGEST = 200  # letters of an answer; what is longer is cut, and so is no JSON
GONE = 4404  # code of a WebSocket: there is no such run


@dataclass(frozen=True)
class ServerSettings:
    """Settings of the server. scene: shown first; folder: scenes to choose from; text: that the
    scene was read from, if it was; host, port: where the server listens, port 0: at any that is
    free; opens: whether a browser is started; moves: whether a page begins with a run that moves,
    over the span of its scene and over again; said: told the address, that for other machines where
    they are let in."""

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
        modules = ModuleBuilder(lambda: server.should_exit)
        site = _build_site(settings, modules, *_addresses(settings.host, port, token))
        config = uvicorn.Config(
            AccessGuard(site, token, port),
            log_level="warning",
            ws_per_message_deflate=False,
            timeout_graceful_shutdown=2,
        )
        server, misunderstood = uvicorn.Server(config), UnreadableFilter()
        misunderstood.attach()
        with suppress(KeyboardInterrupt):  # Ctrl-C: it has ended by then
            server.run(sockets=[listening])
        if misunderstood.count:
            print(f"rodgen: {misunderstood.count} messages could not be read", file=sys.stderr)


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

    _replace(site, "dompurify.mjs", PURIFIER)
    if (font := icon_font()) is not None:
        _replace(site, font, ICONS.read_bytes())

    async def begin() -> None:
        settings.said(told)
        if settings.opens:
            await asyncio.to_thread(webbrowser.open, opened)

    app.on_startup(begin)
    app.timer(SWEEP, sessions.close_idle)
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
    both = ":" in host and socket.has_dualstack_ipv6()
    try:  # listening, so that the address answers as soon as it is told
        return socket.create_server(
            (host, port), family=family, backlog=MOST_WAITING, dualstack_ipv6=both
        )
    except OSError as error:
        named, given = ("--port", port) if error.errno in PORT_ERRORS else ("--host", host)
        reason = error.strerror or error
        raise InputError(named, given, f"one that can be listened on ({reason})") from None


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
        with suppress(RuntimeError):  # sending has found out first that the page is gone
            async for text in socket.iter_text():
                if not act_on_answer(run, text):
                    await socket.close(1008, "not an answer")
                    break
    finally:
        run.page.detach(send)
        sending.cancel()


async def _forward(socket: WebSocket, waiting: asyncio.Queue[bytes]) -> None:
    with suppress(WebSocketDisconnect, RuntimeError):  # the page has gone meanwhile
        while True:
            await socket.send_bytes(await waiting.get())


# By key of the answer: classes of its value, and what comes of it.
ANSWERS: dict[str, tuple[set[type], Callable[[LiveRun, Any], object]]] = {
    "ack": ({int}, lambda run, frame: run.page.acknowledge(frame)),
    "look": ({int, float, NoneType}, lambda run, t: run.submit(lambda: run.look_at(t))),
    "step": ({int}, lambda run, by: run.submit(lambda: run.step_view(by))),
    "keep": ({bool}, lambda run, keeps: run.submit(lambda: run.keep_runs(keeps))),
    "branch": ({NoneType}, lambda run, _: run.submit(run.branch)),
}


def act_on_answer(run: LiveRun, text: str) -> bool:
    """Act on an answer of a page: {"ack": number of a message} that it has drawn, {"look": t [s]}
    or null for the present, {"step": samples}, {"keep": whether runs are kept as ghosts},
    {"branch": null} for another run from here. Returns False for anything else."""
    try:
        # NaN and Infinity are no JSON.
        ((key, value),) = json.loads(text[:LONGEST], parse_constant=int).items()
        classes, act = ANSWERS[key]
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return False
    if type(value) not in classes:
        return False
    act(run, value)
    return True
