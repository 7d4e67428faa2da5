"""The server of the live view: its page, and the WebSocket of each run."""

from __future__ import annotations

import asyncio
import json
import mimetypes
import socket
import sys
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
from rodgen_live.page.access import AccessGuard
from rodgen_live.page.address import Address
from rodgen_live.page.elements import ICONS, STATIC, icon_font
from rodgen_live.page.module_builder import ModuleBuilder
from rodgen_live.page.page import ADDRESS, Page
from rodgen_live.page.sessions import Sessions
from rodgen_live.page.toolbar import THUMBNAILS
from rodgen_live.page.unreadable_messages import UnreadableFilter
from rodgen_live.run.live_run import LiveRun
from rodgen_live.run.run_thread import from_threads
from rodgen_live.run.scene_text import SceneFolder

SWEEP = 0.5  # seconds
# Seconds that NiceGUI's own connection of a page may be gone; it is looked at by answers within two
# fifths of that, which a busy machine needs.
RECONNECT = 30.0
# Instead of DOMPurify: the page shows no HTML of others. What is asked for is shown as text.
PURIFIER = b"""export default new Proxy({}, { get: (_, name) =>
    name === "sanitize" ? html => new Option(html).innerHTML : () => {} });
"""
LONGEST = 200  # letters of an answer; what is longer is cut, and so is no JSON
GONE = 4404  # code of a WebSocket: there is no such run


@dataclass(frozen=True)
class ServerSettings:
    """Settings of the server. scene: shown first; folder: scenes to choose from; text: that the
    scene was read from, if it was; moves: whether a page begins with a run that moves, over the
    span of its scene and over again."""

    scene: Scene
    folder: Path
    text: str = ""
    moves: bool = True


def serve(settings: ServerSettings, listening: socket.socket, address: Address) -> None:
    """Serve at an address until Ctrl-C."""
    modules = ModuleBuilder(lambda: server.should_exit)
    site = _build_site(settings, modules)
    config = uvicorn.Config(
        AccessGuard(site, address.token, address.port),
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


def _build_site(settings: ServerSettings, modules: ModuleBuilder) -> FastAPI:
    site, sessions, folder = FastAPI(openapi_url=None), Sessions(), SceneFolder(settings.folder)

    @site.websocket(ADDRESS + "{name}")
    async def _(ws: WebSocket, name: str) -> None:
        await serve_channel(ws, name, sessions)

    @ui.page("/", title="rodgen", response_timeout=20)
    async def _(scene: str = "") -> None:
        first = settings.scene, settings.text
        await Page(sessions, modules, folder, *first, settings.moves).show(scene)

    @site.get(THUMBNAILS + "{name}")
    def _(name: str) -> Response:
        from rodgen_live.page.thumbnail import thumbnail  # and matplotlib, once a list is open

        try:
            return Response(thumbnail(folder.scene(name)), media_type="image/svg+xml")
        except InputError as error:
            return Response(str(error), 404, media_type="text/plain")

    _replace(site, "dompurify.mjs", PURIFIER)
    if (font := icon_font()) is not None:
        _replace(site, font, ICONS.read_bytes())

    app.on_startup(lambda: modules.load(settings.scene.structure))  # until a page has come
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
    site.add_middleware(GZipMiddleware, compresslevel=1)  # on one machine, more takes longer
    return site


def _replace(site: FastAPI, place: str, content: bytes) -> None:
    """Serve other content in place of a file of NiceGUI."""
    kind, _ = mimetypes.guess_type(place)

    @site.get(f"/_nicegui/{nicegui.__version__}/static/{place}")
    def answer() -> Response:
        # Asked for again: another rodgen may have less left out.
        return Response(content, headers={"Cache-Control": "no-cache"}, media_type=kind)


async def serve_channel(socket: WebSocket, name: str, sessions: Sessions) -> None:
    """Send frames to the page and take its answers, until it goes away."""
    await socket.accept()
    run = sessions.get(name)
    if run is None:
        await socket.close(GONE, "this run has ended")
        return
    waiting = asyncio.Queue[bytes]()
    send = from_threads(waiting.put_nowait)
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
