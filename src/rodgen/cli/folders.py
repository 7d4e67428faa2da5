"""Folders that results go into."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
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


@contextmanager
def promised(folder: Path | None) -> Iterator[Path]:
    """A folder that is seen to be writable before what goes into it is computed; where nothing
    is put into it in the end, it is taken away again. None where nothing is to be written."""
    if folder is None:
        yield Path()
        return
    new = [path for path in (folder, *folder.parents) if not os.path.exists(path)]
    try:
        yield writable(folder)
    finally:
        for path in new:
            with suppress(OSError):  # it is not empty
                path.rmdir()


def unwritable(folder: Path, error: OSError) -> SceneError:
    """The error for a folder that cannot be written."""
    reason = error.strerror or str(error)
    return SceneError("--out", str(folder), f"a folder to write into ({reason})")
