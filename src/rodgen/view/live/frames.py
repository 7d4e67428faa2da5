"""Messages to the page: a header in JSON, then arrays, as static/message.js reads them."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

WORD = 8  # bytes to which the arrays are aligned
TYPES = {np.dtype(np.float32): "f4", np.dtype(np.float64): "f8"}

Named = tuple[str, NDArray[Any]]


def encode(header: dict[str, Any], arrays: Iterable[Named]) -> bytes:
    """Length of the header (uint32, little-endian), the header with [name, type, count] of every
    array, and the arrays, each from a multiple of 8 bytes on. Raises ValueError for what JSON
    does not have: not-a-number in the header."""
    arrays = [(name, np.ascontiguousarray(array)) for name, array in arrays]
    listed = [[name, TYPES[array.dtype], array.size] for name, array in arrays]
    text = json.dumps({**header, "arrays": listed}, allow_nan=False, ensure_ascii=False)
    head = text.encode()
    head += b" " * (-(4 + len(head)) % WORD)
    parts = [struct.pack("<I", len(head)), head]
    for _, array in arrays:
        content = array.astype(array.dtype.newbyteorder("<"), copy=False).tobytes()
        parts += [content, bytes(-len(content) % WORD)]
    return b"".join(parts)
