"""Who is let in: by requests as a server gets them."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

pytest.importorskip("nicegui", reason="the extra view is not installed")

from rodgen.view.live.web.guard import Guard

TOKEN = "s3cret-token"


def ask(
    token: str | None, query: str = "", kind: str = "http", **headers: str
) -> tuple[int, dict[str, str]]:
    """Status and headers of an answer; 101: the WebSocket is let through."""
    sent: list[Any] = []

    async def app(scope: Any, _: Any, send: Any) -> None:
        if scope["type"] == "http":
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
    asyncio.run(Guard(app, token)(scope, receive, send))
    if kind == "websocket":
        return (101 if sent[0]["type"] == "websocket.accept" else sent[0]["code"]), {}
    found = {name.decode(): value.decode() for name, value in sent[0]["headers"]}
    return sent[0]["status"], found


@pytest.mark.parametrize("host", ["localhost:8642", "127.0.0.1:8642", "[::1]:8642", "localhost"])
def test_own_machine_is_let_in(host: str) -> None:
    assert ask(None, host=host)[0] == 200
    assert ask(None, kind="websocket", host=host, origin=f"http://{host}")[0] == 101


@pytest.mark.parametrize("host", ["evil.example:8642", "10.0.0.1", "", "localhost.evil", "[::1"])
def test_other_names_of_this_machine_are_refused(host: str) -> None:
    """A stranger's DNS may give this machine a name, and its page would be of our origin."""
    assert ask(None, host=host)[0] == 403
    assert ask(None, kind="websocket", host=host)[0] == 1008


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://localhost:1", "x"])
def test_pages_of_other_servers_are_refused(origin: str) -> None:
    assert ask(None, origin=origin)[0] == 403
    assert ask(None, kind="websocket", origin=origin)[0] == 1008
    assert ask(TOKEN, f"token={TOKEN}", kind="websocket", origin=origin)[0] == 1008


def test_token_is_asked_for_and_kept() -> None:
    host = "192.168.0.7:8642"
    assert ask(TOKEN, host=host)[0] == 403
    assert ask(TOKEN, "token=wrong", host=host)[0] == 403
    status, headers = ask(TOKEN, f"token={TOKEN}", host=host)
    assert status == 200
    cookie = headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    kept = cookie.split(";")[0]
    assert ask(TOKEN, host=host, cookie=kept)[0] == 200
    assert ask(TOKEN, kind="websocket", host=host, cookie=kept)[0] == 101
    assert ask(TOKEN, kind="websocket", host=host)[0] == 1008
    assert ask(TOKEN, host=host, cookie="rodgen_token=" + "\u00e9")[0] == 403
