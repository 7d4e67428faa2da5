"""Who may talk to the server: this machine's own pages, and elsewhere who has the token."""

from __future__ import annotations

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

OWN = {"localhost", "127.0.0.1", "::1"}
TOKEN, COOKIE = "token", "rodgen_token"


class Guard:
    """Refuses requests that come from pages of other servers, under other names of this machine
    (a name that a stranger's DNS gives it), and where there is a token, without it.

    token: asked for in the address of the first request, and kept by a cookie; None on the
    loopback address.
    """

    def __init__(self, app: App, token: str | None):
        self._app, self._token = app, token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {name.decode("latin-1"): v.decode("latin-1") for name, v in scope["headers"]}
        given = parse_qs(scope["query_string"].decode("latin-1")).get(TOKEN, [""])[0]
        refusal = self._refusal(headers, given)
        if refusal:
            await _refuse(scope, send, refusal)
        elif given and self._token and scope["type"] == "http":
            await self._app(scope, receive, self._remembering(send))
        else:
            await self._app(scope, receive, send)

    def _refusal(self, headers: dict[str, str], given: str) -> str:
        """Why a request is refused, or nothing."""
        host, origin = headers.get("host", ""), headers.get("origin")
        if self._token is None and _name(host) not in OWN:
            return f"this server is not called {host[:100]!r}"
        if origin is not None and urlsplit(origin).netloc != host:
            return "requests from pages of other servers are refused"
        if self._token is not None:
            kept, wanted = _cookie(headers.get("cookie", "")), self._token.encode()
            if not any(hmac.compare_digest(one.encode(), wanted) for one in (given, kept)):
                return "the address needs the token that `rodgen view` has printed: /?token=..."
        return ""

    def _remembering(self, send: Send) -> Send:
        assert self._token is not None
        value = f"{COOKIE}={self._token}; HttpOnly; SameSite=Strict; Path=/"

        async def sending(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message["headers"], (b"set-cookie", value.encode())]
            await send(message)

        return sending


def _name(host: str) -> str:
    """The name in a Host header, without the port."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _cookie(header: str) -> str:
    """The token that a page keeps."""
    try:
        found = SimpleCookie(header).get(COOKIE)
    except CookieError:
        return ""
    return found.value if found else ""


async def _refuse(scope: Scope, send: Send, why: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": why[:100]})
        return
    body = f"rodgen: {why}\n".encode()
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"cache-control", b"no-store")]
    await send({"type": "http.response.start", "status": 403, "headers": headers})
    await send({"type": "http.response.body", "body": body})
