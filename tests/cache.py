"""The folder of what tests, and the site, derive and compile: kept from one run to the next, for as
long as the generator is what it was."""

from __future__ import annotations

import os
from pathlib import Path

from rodgen.loading.cache import PACKAGES, source_hash

CACHES = Path(
    os.environ.get("RODGEN_TEST_CACHES") or Path(__file__).parents[1] / "build" / "test-cache"
)


def cache() -> Path:
    """That folder, of the present generator."""
    folder = CACHES / source_hash(*PACKAGES, "rodgen.check")[:16]
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    return folder
