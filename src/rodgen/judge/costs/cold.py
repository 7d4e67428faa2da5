"""Generation and compilation from cold, in a process of their own.

python -m rodgen.judge.costs.cold takes a scene's tables on standard input, and gives seconds by
name as the last line of standard output. RODGEN_CACHE says where the module is left.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from typing import Any

LIMIT = 200.0  # s
LETTERS = 200  # of what a process said that failed


def cold(table: dict[str, Any], cache: str) -> dict[str, float]:
    """Seconds of "generate" (without the import of SymPy) and "compile", into an empty cache.

    Raises RuntimeError with what the process said last.
    """
    made = subprocess.run(
        [sys.executable, "-m", "rodgen.judge.costs.cold"],
        input=json.dumps(table),
        capture_output=True,
        text=True,
        timeout=LIMIT,
        env={**os.environ, "RODGEN_CACHE": cache},
    )
    if made.returncode:
        raise RuntimeError(" ".join(made.stderr.split())[-LETTERS:])
    seconds: dict[str, float] = json.loads(made.stdout.splitlines()[-1])
    return seconds


def main() -> None:
    """The process."""
    import rodgen.emit  # noqa: F401, taken in for what it takes: SymPy and the derivations with it
    from rodgen.loading import load_files, sources
    from rodgen.scene import Scene

    scene = Scene.from_dict(json.load(sys.stdin))
    start = time.perf_counter()
    texts = sources(scene, "c")
    written = time.perf_counter()
    load_files(texts)
    done = time.perf_counter()
    print(json.dumps({"generate": written - start, "compile": done - written}))


if __name__ == "__main__":
    main()
