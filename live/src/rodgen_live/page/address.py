"""The address of the server: the socket that holds it, and how it is told.

It is there before the server, whose modules take a while to import: a browser starts meanwhile.
"""

from __future__ import annotations

import errno
import secrets
import socket
from typing import NamedTuple

from rodgen.errors import InputError

OWN = {"localhost", "127.0.0.1", "::1"}
TOKEN = "token"
EVERYWHERE = {"0.0.0.0", "::"}
ELSEWHERE = ("192.0.2.1", 9)  # of RFC 5737: nobody has it
PORT_ERRORS = (errno.EADDRINUSE, errno.EACCES)
MOST_WAITING = 1024  # connections that wait to be taken up: more are cut off without a word


class Address(NamedTuple):
    """Address of a server. told: that for other machines where they are let in; here: that for a
    browser on this one; port; token: that requests need, None on the loopback address."""

    told: str
    here: str
    port: int
    token: str | None


def address_of(host: str, listening: socket.socket) -> Address:
    """Address of a socket that listens on a host, elsewhere where that is possible."""
    port, everywhere = listening.getsockname()[1], host in EVERYWHERE
    token = None if host in OWN else secrets.token_urlsafe(16)
    here = "localhost" if everywhere or host in OWN else host
    elsewhere = _network_name() if everywhere else here

    def address(name: str) -> str:
        place = f"[{name}]" if ":" in name else name
        return f"http://{place}:{port}/" + (f"?{TOKEN}={token}" if token else "")

    return Address(address(elsewhere), address(here), port, token)


def _network_name() -> str:
    """Name of this machine for others in its network: the address from which it would send (nothing
    is sent), else its host name."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as outward:
        try:
            outward.connect(ELSEWHERE)
        except OSError:
            return socket.gethostname()
        return str(outward.getsockname()[0])


def listen(host: str, port: int) -> socket.socket:
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
