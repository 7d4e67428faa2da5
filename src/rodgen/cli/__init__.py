"""The command line: one file a command, no logic."""

from __future__ import annotations

import gc
import sys

from rodgen.cli.exits import INTERRUPTED, end_within_libraries, report_errors, resend_lost_ctrl_c


def main() -> None:
    """Entry point of the `rodgen` command."""
    resend_lost_ctrl_c()
    end_within_libraries()
    with report_errors():
        gc.disable()  # modules are many objects and no garbage: to look for it takes a tenth
        from rodgen.cli.app import make_app  # inside, so that Ctrl-C is reported from the start

        app = make_app(*sys.argv[1:2])
        gc.enable()
        status = app(prog_name="rodgen", standalone_mode=False) or 0
        if status == INTERRUPTED:  # typer keeps the interrupt itself to itself
            raise KeyboardInterrupt
        sys.exit(status)
