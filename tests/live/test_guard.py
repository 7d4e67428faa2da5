"""Who is let in: by requests as a server gets them."""

from __future__ import annotations

from typing import Any

import pytest

pytest.importorskip("nicegui", reason="the extra view is not installed")

from rodgen.live.page.guard import Guard
from tests.live.conftest import finished

TOKEN, PORT = "s3cret-token", 8642


def ask(
    token: str | None, query: str = "", kind: str = "http", port: int = PORT, **headers: str
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
    finished(Guard(app, token, port)(scope, receive, send))
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
    assert "SameSite=Lax" in cookie  # Strict ones are not sent by who follows a link in a mail
    kept = cookie.split(";")[0]
    assert ask(TOKEN, host=host, cookie=kept)[0] == 200
    assert ask(TOKEN, kind="websocket", host=host, cookie=kept)[0] == 101
    assert ask(TOKEN, kind="websocket", host=host)[0] == 1008
    assert ask(TOKEN, host=host, cookie=kept.split("=")[0] + "=\u00e9")[0] == 403


def test_token_of_a_server_on_another_port_is_left_alone() -> None:
    """Cookies are those of a host: with one name for all ports, the servers of a host would take
    each other's away."""
    first, second = (
        ask(TOKEN, f"token={TOKEN}", port=port, host=f"lan:{port}")[1]["set-cookie"]
        for port in (PORT, PORT + 1)
    )
    assert first.partition("=")[0] != second.partition("=")[0]


@pytest.mark.parametrize("kind", ["iframe", "frame", "embed", "object", "image", "script", "empty"])
@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_pages_of_other_servers_may_link_and_no_more(site: str, kind: str) -> None:
    """Navigations of frames say no origin, but where they are from and what for."""
    theirs = {"sec-fetch-site": site, "sec-fetch-dest": kind}
    assert ask(None, "scene=x", **theirs)[0] == 403
    assert ask(None, "scene=x", **{**theirs, "sec-fetch-dest": "document"})[0] == 200
    assert ask(None, "scene=x", **{**theirs, "sec-fetch-site": "same-origin"})[0] == 200


def test_pages_are_in_no_frame() -> None:
    for token, query in ((None, ""), (TOKEN, f"token={TOKEN}")):
        headers = ask(token, query)[1]
        assert headers["x-frame-options"] == "DENY"
        assert headers["content-security-policy"] == "frame-ancestors 'none'"


@pytest.mark.parametrize(
    ("said", "status"),
    [
        ({"content-length": str(2 * 1024 * 1024)}, 200),
        ({"content-length": str(2 * 1024 * 1024 + 1)}, 403),
        ({"content-length": "9" * 5000}, 403),
        ({"content-length": "-1"}, 403),
        ({"transfer-encoding": "chunked"}, 403),
    ],
)
def test_long_requests_are_refused(said: dict[str, str], status: int) -> None:
    """Before anything is read: at most 2 MiB, a scene of 1 MiB and what is around it."""
    assert ask(None, **said)[0] == status
