"""Access to the server: for this machine's own pages, and from elsewhere with the token."""

from __future__ import annotations

import hmac
import re
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

OWN = {"localhost", "127.0.0.1", "::1"}
HOST = re.compile(r"([\w.-]+|\[[0-9a-fA-F:.]+\])(:[0-9]{1,5})?", re.ASCII)
TOKEN = "token"
LONGEST = 2 * 2**20  # bytes of a request: a scene, and what is around it
# For browsers that do not say who asks.
UNFRAMED = [
    (b"x-frame-options", b"DENY"),
    (b"content-security-policy", b"frame-ancestors 'none'"),
]


class AccessGuard:
    """ASGI middleware that refuses requests from pages of other servers, under other names of this
    machine (a name that a stranger's DNS gives it), that are too long, and where there is a token,
    without it. Pages of other servers may link to ours, but not hold it in a frame.

    token: asked for in the address of the first request, and kept by a cookie; None on the loopback
    address. port: the server's; cookies are those of a host, whatever its port.
    """

    def __init__(self, app: App, token: str | None, port: int):
        self._app, self._token, self._cookie = app, token, f"rodgen_token_{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {name.decode("latin-1"): v.decode("latin-1") for name, v in scope["headers"]}
        given = parse_qs(scope["query_string"].decode("latin-1")).get(TOKEN, [""])[0]
        refusal = self._refusal(headers, given)
        if refusal:
            await _refuse(scope, send, refusal)
        elif scope["type"] == "websocket":
            await self._app(scope, receive, send)
        else:
            await self._app(scope, receive, self._with_headers(send, remember=bool(given)))

    def _refusal(self, headers: dict[str, str], given: str) -> str:
        """Reason why a request is refused, or nothing."""
        host, origin = headers.get("host", ""), headers.get("origin")
        if self._token is None and _host_name(host) not in OWN:
            return f"this server is not called {host[:100]!r}"
        if origin is not None and origin != f"http://{host}":
            return "requests from pages of other servers are refused"
        if _is_embedding(headers):
            return "pages of other servers can link to this one, and nothing else"
        if _is_too_long(headers):
            return f"a request has at most {LONGEST >> 20} MiB"
        if self._token is not None:
            kept = _cookie_value(headers.get("cookie", ""), self._cookie)
            wanted = self._token.encode()
            if not any(hmac.compare_digest(one.encode(), wanted) for one in (given, kept)):
                return "the address needs the token that `rodgen view` has printed: /?token=..."
        return ""

    def _with_headers(self, send: Send, *, remember: bool) -> Send:
        """Wrap `send` to add our headers to answers, and the token for the browser to remember."""
        headers = list(UNFRAMED)
        if remember and self._token:
            # Lax: whoever comes by a link, such as one in a mail, has it with them.
            value = f"{self._cookie}={self._token}; HttpOnly; SameSite=Lax; Path=/"
            headers.append((b"set-cookie", value.encode()))

        async def send_with_headers(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message["headers"], *headers]
            await send(message)

        return send_with_headers


def _host_name(host: str) -> str:
    """Name in a Host header, without the port; nothing where the header is malformed."""
    found = HOST.fullmatch(host)
    return found[1].strip("[]").lower() if found else ""


def _is_embedding(headers: dict[str, str]) -> bool:
    """Whether a page of another server has this as its frame, image or script: like a link that is
    followed, these are asked for without an origin."""
    others = headers.get("sec-fetch-site") in ("cross-site", "same-site")
    return others and headers.get("sec-fetch-dest") != "document"


def _is_too_long(headers: dict[str, str]) -> bool:
    """Whether the body of a request is longer than it may be, or of unknown length."""
    length = headers.get("content-length", "0")
    told = "transfer-encoding" not in headers and length.isdecimal() and len(length) < 10
    return not told or int(length) > LONGEST


def _cookie_value(header: str, name: str) -> str:
    """Token that a browser keeps, or nothing."""
    try:
        found = SimpleCookie(header).get(name)
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
