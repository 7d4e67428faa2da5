"""Signals that end a program: as Ctrl-C does, so that it leaves nothing that it has started."""

from __future__ import annotations

import signal

import pytest

from rodgen.cli.exits import treat_signals_as_ctrl_c


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"])
def test_what_ends_a_program_interrupts_it(name: str) -> None:
    if signal.getsignal(getattr(signal, name)) is signal.SIG_IGN:  # of a test under nohup
        signal.signal(getattr(signal, name), signal.SIG_DFL)
    treat_signals_as_ctrl_c()
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(getattr(signal, name))


def test_what_is_ignored_from_the_start_stays_so() -> None:
    """As under nohup."""
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    treat_signals_as_ctrl_c()
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    signal.raise_signal(signal.SIGHUP)
