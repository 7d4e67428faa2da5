"""Empty caches, by which modules are made from cold."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

CACHE = "RODGEN_CACHE"


@contextmanager
def scratch() -> Iterator[str]:
    """A folder that is thrown away afterwards."""
    with tempfile.TemporaryDirectory(prefix="rodgen-judge-", ignore_cleanup_errors=True) as folder:
        yield folder


@contextmanager
def cache_at(folder: str) -> Iterator[None]:
    """rodgen's cache in a folder."""
    before = os.environ.get(CACHE)
    os.environ[CACHE] = folder
    try:
        yield
    finally:
        if before is None:
            del os.environ[CACHE]
        else:
            os.environ[CACHE] = before
