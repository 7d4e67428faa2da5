"""Result files: samples of a run, files that grow with it, and checkpoints."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Self

from rodgen.errors import InputError


class Closing:
    """Base of files that are closed at the end of a with statement."""

    def close(self) -> None:
        """Close the file; what is in it stays as it is."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@contextmanager
def atomic_write(path: Path, field: str = "file") -> Iterator[Path]:
    """Give another name in the same folder to write to, which takes the place of path at the end.

    Where the block raises, nothing is left of it. Raises InputError where there is no such folder.
    """
    if not path.parent.is_dir():
        raise InputError(field, str(path), "in a folder that exists")
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
