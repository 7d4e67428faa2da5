"""Who is let in, by requests as a server gets them; and the server as a process."""

from __future__ import annotations

import json
import logging
import signal
import socket
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from live.tests.conftest import SCENES, finished
from live.tests.view import PATIENT
from rodgen.scene import Scene
from rodgen_live.page.access import AccessGuard
from rodgen_live.page.unreadable_messages import UnreadableFilter
from tests.told import numbers

TOKEN, PORT = "s3cret-token", 8642
HTTP, SOCKET = "http", "websocket"
LET_IN, REFUSED = {HTTP: 200, SOCKET: 101}, {HTTP: 403, SOCKET: 1008}
MOST = 2 * 1024 * 1024  # bytes: a scene of 1 MiB and what is around it


def ask(
    token: str | None = None, query: str = "", kind: str = HTTP, port: int = PORT, **headers: str
) -> tuple[int, dict[str, str]]:
    """Status and headers of an answer; 101: the WebSocket is let through."""
    sent: list[Any] = []

    async def app(scope: Any, _: Any, send: Any) -> None:
        if scope["type"] == HTTP:
            await send({"type": "http.response.start", "status": 200, "headers": []})
        else:
            await send({"type": "websocket.accept"})

    async def send(message: Any) -> None:
        sent.append(message)

    async def receive() -> Any:
        return {"type": "http.request"}

    headers = {"host": "localhost:8642", **headers}
    scope = {
        "type": kind,
        "headers": [(name.encode(), value.encode()) for name, value in headers.items()],
        "query_string": query.encode(),
    }
    finished(AccessGuard(app, token, port)(scope, receive, send))
    if kind == SOCKET:
        return (101 if sent[0]["type"] == "websocket.accept" else sent[0]["code"]), {}
    return sent[0]["status"], {name.decode(): value.decode() for name, value in sent[0]["headers"]}


# A stranger's DNS may give this machine a name, and its page would be of our origin.
STRANGE = (
    *("evil.example:8642", "10.0.0.1", "", "localhost.evil", "[::1"),
    *(
        "evil.example@127.0.0.1",
        "a:b@localhost:8642",
        "localhost/",
        "localhost:8642?",
        "localhost:x",
    ),
    *(
        "localhost,evil.example",
        "localhost evil.example",
        "localhost\n",
        "127.0.0.1#",
        "localhost:",
    ),
)
ORIGINS = (
    *("http://evil.example", "null", "http://localhost:1", "x", "https://localhost:8642"),
    *(
        "ftp://localhost:8642",
        "http://localhost:8642/",
        "http://x@localhost:8642",
        "localhost:8642",
    ),
)


@pytest.mark.parametrize("kind", [HTTP, SOCKET])
def test_own_machine_is_let_in_and_nobody_else(kind: str) -> None:
    for host in ("localhost:8642", "127.0.0.1:8642", "[::1]:8642", "localhost"):
        assert ask(kind=kind, host=host, origin=f"http://{host}")[0] == LET_IN[kind]
    for host in STRANGE:
        assert ask(kind=kind, host=host)[0] == REFUSED[kind], host
    for origin in ORIGINS:
        assert ask(kind=kind, origin=origin)[0] == REFUSED[kind], origin
    assert ask(TOKEN, f"token={TOKEN}", kind=kind, origin=ORIGINS[0])[0] == REFUSED[kind]


def test_token_is_asked_for_and_kept() -> None:
    host = "192.168.0.7:8642"
    assert ask(TOKEN, host=host)[0] == 403
    assert ask(TOKEN, "token=wrong", host=host)[0] == 403
    status, headers = ask(TOKEN, f"token={TOKEN}", host=host)
    assert status == 200
    cookie = headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Lax" in cookie  # Strict ones are not sent by who follows a link in a mail
    kept = cookie.split(";")[0]
    for kind in (HTTP, SOCKET):
        assert ask(TOKEN, kind=kind, host=host, cookie=kept)[0] == LET_IN[kind]
        assert ask(TOKEN, kind=kind, host=host)[0] == REFUSED[kind]
    name = kept.split("=")[0]
    assert ask(TOKEN, host=host, cookie=name + "=\u00e9")[0] == 403
    # Cookies are those of a host: with one name for all ports, servers would take each other's.
    other = ask(TOKEN, f"token={TOKEN}", port=PORT + 1, host=f"lan:{PORT + 1}")[1]["set-cookie"]
    assert other.split("=")[0] != name


def test_pages_of_other_servers_may_link_and_no_more() -> None:
    """Navigations of frames say no origin, but where they are from and what for."""
    for site in ("cross-site", "same-site"):
        for kind in ("iframe", "frame", "embed", "object", "image", "script", "empty"):
            theirs = {"sec-fetch-site": site, "sec-fetch-dest": kind}
            assert ask(query="scene=x", **theirs)[0] == 403
            assert ask(query="scene=x", **theirs | {"sec-fetch-site": "same-origin"})[0] == 200
        link = {"sec-fetch-site": site, "sec-fetch-dest": "document"}
        assert ask(query="scene=x", **link)[0] == 200
    for token, query in ((None, ""), (TOKEN, f"token={TOKEN}")):
        headers = ask(token, query)[1]
        assert headers["x-frame-options"] == "DENY"
        assert headers["content-security-policy"] == "frame-ancestors 'none'"


def test_long_requests_are_refused() -> None:
    """Before anything is read."""
    assert ask(**{"content-length": str(MOST)})[0] == 200
    for length in (str(MOST + 1), "9" * 5000, "-1"):
        assert ask(**{"content-length": length})[0] == 403
    assert ask(**{"transfer-encoding": "chunked"})[0] == 403


def log_record(error: BaseException | None = None, text: str = "") -> logging.LogRecord:
    told = (type(error), error, error.__traceback__) if error else None
    return logging.LogRecord("asyncio", logging.ERROR, "", 0, text, (), told)


def raised(act: Callable[[], object]) -> BaseException:
    with pytest.raises(ValueError) as caught:  # noqa: PT011  what was raised
        act()
    return caught.value


def test_what_cannot_be_read_is_counted_and_errors_of_rodgen_are_told_once() -> None:
    """A line of uvicorn's is of what it could not read, too; all others are told."""
    log = UnreadableFilter()
    unreadable = [log_record(raised(lambda: json.loads("{"))) for _ in range(3)]
    unreadable.append(log_record(text="Invalid HTTP request received."))
    assert [log.filter(one) for one in unreadable] == [False] * 4
    assert log.count == 4
    own = [log_record(raised(lambda: Scene.from_dict({"name": 3}))) for _ in range(2)]
    own.append(log_record(raised(lambda: Scene.example("none"))))
    assert [log.filter(one) for one in own] == [True, False, True]
    assert log.filter(log_record(text="something else"))
    assert log.count == 5


def status(address: str, **headers: str) -> int:
    """Of a request for it."""
    request = urllib.request.Request(address, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=PATIENT) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        return error.code


def test_taken_port_is_named(rodgen: Callable[..., Any]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = rodgen("view", SCENES / "missile.toml", "--port", port, "--no-open")
    assert done.returncode == 2
    assert f"--port = {port}" in done.stderr


@pytest.mark.slow
def test_loopback_server_refuses_strangers_and_long_uploads(server: Any) -> None:
    """At most 2 MiB, whatever a browser lets through; unread."""
    assert status(server.address) == 200
    assert status(server.address, Host="evil.example") == 403
    assert status(server.address, Origin="http://evil.example") == 403
    for path in ("live/channel/x", "..%2f..%2fetc/passwd", "_nicegui/../../etc/passwd", "docs"):
        assert status(server.address + path) in (403, 404)
    told = urlsplit(server.address)
    with socket.create_connection((told.hostname, told.port), timeout=PATIENT) as asking:
        head = f"POST / HTTP/1.1\r\nHost: {told.netloc}\r\nContent-Length: {3 * 2**20}\r\n\r\n"
        asking.sendall(head.encode())
        assert asking.recv(100).startswith(b"HTTP/1.1 403")


@pytest.mark.slow
def test_token_opens_the_page_elsewhere(serve: Callable[..., Any], folder: Path) -> None:
    served = serve(folder / "dart.toml", "--host", "0.0.0.0")
    told = urlsplit(served.address)
    assert told.hostname != "0.0.0.0"  # no browser elsewhere gets there by it
    assert status(served.address) == 200
    place, token = f"http://127.0.0.1:{told.port}/", told.query.partition("=")[2]
    assert len(token) > 20
    assert status(place) == 403
    assert status(f"{place}?token=guess") == 403
    assert status(f"{place}?token={token}") == 200


@pytest.mark.slow
def test_malformed_messages_leave_a_line(serve: Callable[..., Any], folder: Path) -> None:
    """With their number."""
    from websockets.sync.client import connect

    served = serve(folder / "dart.toml")
    told = urlsplit(served.address)
    channel = f"ws://{told.netloc}/_nicegui_ws/socket.io/?EIO=4&transport=websocket"
    messages = ('42["event",{}]', '42["event",[1]]', '42["ack",null]', '42["log",1]', "42{", "49")
    with connect(channel, origin=served.address.rstrip("/")) as page:
        page.send("40")
        for message in messages:
            page.send(message)
        page.send('421["handshake",{"client_id":"nobody"}]')  # is answered after all of these
        while page.recv(PATIENT) != "431[false]":
            pass
    with socket.create_connection((told.hostname, told.port), timeout=PATIENT) as asking:
        asking.sendall(b"no request\r\n\r\n")
        assert asking.recv(100).startswith(b"HTTP/1.1 400")
    served.process.send_signal(signal.SIGINT)
    _, err = served.process.communicate(timeout=PATIENT)
    assert served.process.returncode == 0
    assert err.count("\n") == 1, err
    assert numbers(err) == [len(messages) + 1]


def test_server_begins_without_what_only_analyses_and_pictures_need() -> None:
    """To import it takes most of the time until a page is there."""
    heavy = {"sympy", "matplotlib", "xarray", "scipy.linalg", "scipy.optimize", "scipy.integrate"}
    program = f"import sys, rodgen_live.page.server; print({heavy} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert done.stdout.strip() == b"set()"
