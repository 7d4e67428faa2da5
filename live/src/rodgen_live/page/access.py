"""Access to the server: for this machine's own pages, and from elsewhere with the token."""

from __future__ import annotations

import hmac
import re

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from rodgen_live.page.address import TOKEN

OWN_HOST = re.compile(r"(localhost|127\.0\.0\.1|\[::1\])(:\d{1,5})?", re.ASCII | re.IGNORECASE)
LONGEST = 2 * 2**20  # bytes of a request: a scene, and what is around it
# For browsers that do not say who asks.
UNFRAMED = {"x-frame-options": "DENY", "content-security-policy": "frame-ancestors 'none'"}


class AccessGuard:
    """ASGI middleware that refuses requests from pages of other servers, under other names of this
    machine (a name that a stranger's DNS gives it), that are too long, and where there is a token,
    without it. Pages of other servers may link to ours, but not hold it in a frame.

    token: asked for in the address of the first request, and kept by a cookie; None on the loopback
    address. port: the server's; cookies are those of a host, whatever its port.
    """

    def __init__(self, app: ASGIApp, token: str | None, port: int):
        self._app, self._token, self._cookie = app, token, f"rodgen_token_{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        asked = HTTPConnection(scope)
        given = asked.query_params.get(TOKEN, "")

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.update(UNFRAMED)
                if given and self._token:
                    # Lax: whoever comes by a link, such as one in a mail, has it with them.
                    kept = f"{self._cookie}={self._token}; HttpOnly; SameSite=Lax; Path=/"
                    headers.append("set-cookie", kept)
            await send(message)

        if not (why := self._refusal(asked, given)):
            await self._app(scope, receive, send_with_headers)
        elif scope["type"] == "websocket":
            await WebSocketClose(1008, why[:100])(scope, receive, send)
        else:
            answer = PlainTextResponse(f"rodgen: {why}\n", 403, {"cache-control": "no-store"})
            await answer(scope, receive, send)

    def _refusal(self, asked: HTTPConnection, given: str) -> str:
        headers = asked.headers
        host, origin = headers.get("host", ""), headers.get("origin")
        if self._token is None and not OWN_HOST.fullmatch(host):
            return f"this server is not called {host[:100]!r}"
        if origin is not None and origin != f"http://{host}":
            return "requests from pages of other servers are refused"
        # Of a frame, an image or a script: like a link that is followed, these are asked for
        # without an origin.
        others = headers.get("sec-fetch-site") in ("cross-site", "same-site")
        if others and headers.get("sec-fetch-dest") != "document":
            return "pages of other servers can link to this one, and nothing else"
        if _is_too_long(headers):
            return f"a request has at most {LONGEST >> 20} MiB"
        if self._token is not None:
            wanted, kept = self._token.encode(), asked.cookies.get(self._cookie, "")
            if not any(hmac.compare_digest(one.encode(), wanted) for one in (given, kept)):
                return "the address needs the token that `rodgen view` has printed: /?token=..."
        return ""


def _is_too_long(headers: Headers) -> bool:
    """Whether the body of a request is longer than it may be, or of unknown length."""
    length = headers.get("content-length", "0")
    told = "transfer-encoding" not in headers and length.isdecimal() and len(length) < 10
    return not told or int(length) > LONGEST
