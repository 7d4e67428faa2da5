"""The process of one unit: python -m rodgen.judge.worker, the unit on standard input."""

from __future__ import annotations

import ctypes
import json
import signal
import sys
import time
from contextlib import suppress

from rodgen.judge.unit import Row, Unit

LONGEST = 300  # letters of a reason


PR_SET_PDEATHSIG = 1  # of Linux's prctl


def main() -> None:
    """Call the unit; its rows, or why there are none, as the last line of standard output."""
    with suppress(OSError, AttributeError):  # nobody waits for what a killed report began
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    unit = Unit(**json.load(sys.stdin))
    start = time.perf_counter()
    rows: list[Row] = []
    failed = ""
    try:
        rows = unit.call()
    except Exception as error:  # another's library may fail in any way
        failed = " ".join(str(error).split())[:LONGEST] or repr(error)
    seconds = time.perf_counter() - start
    print("\n" + json.dumps({"rows": rows, "failed": failed, "seconds": seconds}), flush=True)


if __name__ == "__main__":
    main()
