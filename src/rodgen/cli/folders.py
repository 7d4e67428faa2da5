"""Folders that results go into."""

from __future__ import annotations

import tempfile
from pathlib import Path

from rodgen.scene import SceneError


def writable(folder: Path) -> Path:
    """Make a folder if it is not there and see that it can be written; raises SceneError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise unwritable(folder, error) from None
    return folder


def unwritable(folder: Path, error: OSError) -> SceneError:
    """The error for a folder that cannot be written."""
    reason = error.strerror or str(error)
    return SceneError("--out", str(folder), f"a folder to write into ({reason})")
