"""The command line: one file a command, no logic."""

from __future__ import annotations

import sys

from rodgen.cli.exits import INTERRUPTED, end_within_libraries, report_errors, resend_lost_ctrl_c


def main() -> None:
    """Entry point of the `rodgen` command."""
    resend_lost_ctrl_c()
    end_within_libraries()
    with report_errors():
        from rodgen.cli.app import app  # inside, so that Ctrl-C is reported from the start

        status = app(prog_name="rodgen", standalone_mode=False) or 0
        if status == INTERRUPTED:  # typer keeps the interrupt itself to itself
            raise KeyboardInterrupt
        sys.exit(status)
