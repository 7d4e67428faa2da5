"""Seconds of generation and compilation before a first run."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import sympy  # noqa: F401 - its import is part of no scene's set-up

from rodgen.loading import load_files, sources
from rodgen.scene import Scene

TARGETS = ("c", "numpy")
PATIENCE = 30.0  # seconds of a target, with the imports


def setups(table: dict[str, Any]) -> dict[str, float]:
    """Seconds by "target_kind", each target in a process of its own; of those that succeed.

    A target that fails does so again where it is built to be run, and says why there.
    """
    found: dict[str, float] = {}
    for target in TARGETS:
        command = [sys.executable, "-m", __name__, target]
        try:
            made = subprocess.run(
                command,
                input=json.dumps(table),
                capture_output=True,
                text=True,
                check=True,
                timeout=PATIENCE,
            )
        except subprocess.SubprocessError:
            continue
        taken = json.loads(made.stdout.splitlines()[-1])
        found |= {f"{target}_{kind}": seconds for kind, seconds in taken.items()}
    return found


def setup(scene: Scene, target: str) -> dict[str, float]:
    """Seconds to "generate" the module of a scene and, of the C target, to "compile" and load it.

    As for a user who has nothing yet, with an empty cache; SymPy is imported already.
    """
    with _empty_cache():
        start = time.perf_counter()
        texts = sources(scene, target)
        generated = time.perf_counter()
        load_files(texts)
        loaded = time.perf_counter()
    taken = {"generate": generated - start}
    return taken | {"compile": loaded - generated} if target == "c" else taken


@contextmanager
def _empty_cache() -> Iterator[None]:
    before = os.environ.get("RODGEN_CACHE")
    with tempfile.TemporaryDirectory(prefix="rodgen-cache-") as folder:
        os.environ["RODGEN_CACHE"] = folder
        try:
            yield
        finally:
            if before is None:
                del os.environ["RODGEN_CACHE"]
            else:
                os.environ["RODGEN_CACHE"] = before


if __name__ == "__main__":
    print(json.dumps(setup(Scene.from_dict(json.load(sys.stdin)), sys.argv[1])))
