"""The server as a process: addresses, tokens, ports, and what a page may hand in."""

from __future__ import annotations

import http.server
import socket
import threading
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from tests.live.view import PATIENT

SCENES = Path(__file__).parents[2] / "scenes"
MISSILE = str(SCENES / "missile.toml")


def status(address: str, **headers: str) -> int:
    """Of a request for it."""
    request = urllib.request.Request(address, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=PATIENT) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        return error.code


def test_taken_port_is_named(rodgen: Callable[..., Any]) -> None:
    pytest.importorskip("nicegui", reason="the extra view is not installed")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = rodgen("view", MISSILE, "--port", port, "--no-open")
    assert done.returncode == 2
    assert f"--port = {port}" in done.stderr
    assert "in use" in done.stderr


def test_loopback_server_refuses_strangers(server: Any) -> None:
    assert status(server.address) == 200
    assert status(server.address, Host="evil.example") == 403
    assert status(server.address, Origin="http://evil.example") == 403
    for path in ("live/channel/x", "..%2f..%2fetc/passwd", "_nicegui/../../etc/passwd", "docs"):
        assert status(server.address + path) in (403, 404)


@pytest.mark.nightly
def test_token_opens_the_page_elsewhere(
    serve: Callable[..., Any], blank: Any, folder: Path
) -> None:
    served = serve(str(folder / "dart.toml"), "--host", "0.0.0.0", "--port", "0")
    told = urlsplit(served.address)
    assert told.hostname != "0.0.0.0"  # no browser elsewhere gets there by it
    assert status(served.address) == 200
    place, token = f"http://127.0.0.1:{told.port}/", told.query.partition("=")[2]
    assert len(token) > 20
    address = f"{place}?token={token}"
    assert status(place) == 403
    assert status(f"{place}?token=guess") == 403
    blank.open(address)
    blank.page.goto(place)  # the token is kept by the browser
    blank.ready()


def test_long_upload_is_refused_unread(server: Any) -> None:
    """At most 2 MiB, whatever a browser lets through."""
    told = urlsplit(server.address)
    with socket.create_connection((told.hostname, told.port), timeout=PATIENT) as asking:
        head = f"POST / HTTP/1.1\r\nHost: {told.netloc}\r\nContent-Length: {3 * 2**20}\r\n\r\n"
        asking.sendall(head.encode())
        assert asking.recv(100).startswith(b"HTTP/1.1 403")


def test_page_of_another_server_cannot_hold_ours_in_a_frame(server: Any, blank: Any) -> None:
    class Theirs(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(f'<iframe src="{server.address}"></iframe>'.encode())

        def log_message(self, *_: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Theirs) as made:
        threading.Thread(target=made.serve_forever, daemon=True).start()
        with blank.page.expect_response(server.address) as answer:
            blank.page.goto(f"http://127.0.0.1:{made.server_port}/")
        made.shutdown()
    assert answer.value.status == 403
