"""The process of one unit: python -m rodgen.judge.worker, the unit on standard input."""

from __future__ import annotations

import json
import sys
import time

from rodgen.judge.unit import Row, Unit

LONGEST = 300  # letters of a reason


def main() -> None:
    """Call the unit; its rows, or why there are none, as the last line of standard output."""
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
