"""Ctrl-C, and what a batch system sends to end a program, while there is something to lose."""

from __future__ import annotations

import signal


def end_as_by_ctrl_c() -> None:
    """Let what a batch system sends to end a program do what Ctrl-C does, so that it loses and
    leaves no more."""
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))


def hold_back_ctrl_c() -> None:
    """Ignore Ctrl-C: what was computed is to be written first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def let_ctrl_c_through() -> None:
    """Let Ctrl-C end what it meets again."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
