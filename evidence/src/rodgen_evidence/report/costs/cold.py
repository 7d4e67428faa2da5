"""A module made from cold: its generation and compilation in an empty cache.

`python -m rodgen_evidence.report.costs.cold TARGET` takes a scene's tables on standard input, and
gives seconds by name as the last line of standard output. RODGEN_CACHE says where the module is
left.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from contextlib import AbstractContextManager, suppress
from functools import partial
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

from rodgen.loading import load_files, sources
from rodgen.scene import Scene

LIMIT, PATIENCE = 200.0, 30.0  # seconds, with the imports; of a target before its methods are run
LETTERS = 200  # of what a process said that failed


# A folder that is thrown away afterwards.
scratch = partial(TemporaryDirectory, prefix="rodgen-judge-", ignore_cleanup_errors=True)


def environment(**given: str) -> AbstractContextManager[object]:
    """Variables of the environment with other values: RODGEN_CACHE with another folder, say."""
    return patch.dict(os.environ, given)


def cold(
    table: dict[str, Any], cache: str, target: str = "c", limit: float = LIMIT
) -> dict[str, float]:
    """Seconds to "generate" a module and, of the C target, to "compile" and load it: in a process
    of their own, without its imports, into an empty cache.

    Raises RuntimeError with what the process said last, SubprocessError where it takes too long.
    """
    made = subprocess.run(
        [sys.executable, "-m", __name__, target],
        input=json.dumps(table),
        capture_output=True,
        text=True,
        timeout=limit,
        env={**os.environ, "RODGEN_CACHE": cache},
    )
    if made.returncode:
        raise RuntimeError(" ".join(made.stderr.split())[-LETTERS:])
    seconds: dict[str, float] = json.loads(made.stdout.splitlines()[-1])
    return seconds


def setups(table: dict[str, Any]) -> dict[str, float]:
    """Seconds by "target_kind", of the targets that succeed.

    A target that fails does so again where it is built to be run, and says why there.
    """
    found: dict[str, float] = {}
    for target in ("c", "numpy"):
        with scratch() as folder, suppress(RuntimeError, subprocess.SubprocessError):
            taken = cold(table, folder, target, PATIENCE)
            found |= {f"{target}_{kind}": seconds for kind, seconds in taken.items()}
    return found


def main() -> None:
    """Make the module; generation is without what its imports take, of SymPy above all."""
    import rodgen.emit  # noqa: F401  so that it is loaded

    scene, target = Scene.from_dict(json.load(sys.stdin)), sys.argv[1]
    start = time.perf_counter()
    texts = sources(scene, target)
    seconds = {"generate": time.perf_counter() - start}
    if target == "c":
        start = time.perf_counter()
        load_files(texts)
        seconds["compile"] = time.perf_counter() - start
    print(json.dumps(seconds))


if __name__ == "__main__":
    main()
