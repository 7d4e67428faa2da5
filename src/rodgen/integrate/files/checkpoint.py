"""Checkpoints: states of a run from which it can go on, in a file beside its result."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError
from rodgen.integrate.files import atomic_write

Number = float | int | str
NUMBERS = "numbers"  # the entry that holds them, as JSON; arrays are named array_<name>
ARRAY = "array_"
DIGITS = hashlib.sha256().digest_size * 2


def checkpoint_path(result: Path) -> Path:
    """Path of the checkpoint of a result file: run.nc has run.nc.checkpoint."""
    return result.with_name(result.name + ".checkpoint")


def write(path: Path, arrays: Mapping[str, NDArray[Any]], numbers: Mapping[str, Number]) -> None:
    """Write arrays and numbers, whole or not at all, in place of what was there.

    The file is an .npz; its comment is the SHA-256 of all before it. Raises TypeError for arrays
    of objects and values that are no numbers or text, InputError where there is no such folder.
    """
    for name, array in arrays.items():
        if array.dtype.hasobject:
            raise TypeError(f"{name} holds objects of Python")
    entries: dict[str, Any] = {ARRAY + name: array for name, array in arrays.items()}
    entries[NUMBERS] = np.array(json.dumps(dict(numbers), default=_to_python))
    buffer = io.BytesIO()
    np.savez(buffer, **entries)
    with zipfile.ZipFile(buffer, "a") as archive:
        archive.comment = b"-" * DIGITS
    content = buffer.getvalue()[:-DIGITS]
    with atomic_write(path, "checkpoint") as part:
        part.write_bytes(content + _digest(content))


def read(path: Path) -> tuple[dict[str, NDArray[Any]], dict[str, Number]]:
    """Read the arrays and numbers that `write` was given; raises InputError for damaged and for
    other files."""
    try:
        stored = path.read_bytes()
    except OSError as error:
        allowed = f"a file that can be read ({error.strerror})"
        raise InputError("checkpoint", str(path), allowed) from None
    content, digest = stored[:-DIGITS], stored[-DIGITS:]
    if digest != _digest(content):
        raise InputError("checkpoint", str(path), "one of rodgen's, and as it was written")
    with np.load(io.BytesIO(stored), allow_pickle=False) as entries:
        arrays = {name[len(ARRAY) :]: entries[name] for name in entries if name != NUMBERS}
        return arrays, json.loads(str(entries[NUMBERS]))


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


def _to_python(value: object) -> object:
    """Convert a number of NumPy's to one of Python's."""
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{value!r} is no number")
