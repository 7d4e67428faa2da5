"""Seconds of generation and compilation before a first run."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager

from rodgen.loading import load_files, sources
from rodgen.scene import Scene


def setup(scene: Scene, target: str) -> dict[str, float]:
    """Seconds to "generate" the module of a scene and, of the C target, to "compile" and load it.

    As for a user who has nothing yet: with an empty cache, and with the import of SymPy if this
    process has not imported it.
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
