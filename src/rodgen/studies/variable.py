"""Arrays that a study fills: their names, dimensions and types, known before any point is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

MESSAGE = 200  # characters of a message that are kept


@dataclass(frozen=True)
class Variable:
    """An array of results: dims and shape beside those of the points, dtype as NumPy writes it,
    units, and what stands where nothing was found."""

    name: str
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    dtype: str = "f8"
    units: str = ""
    fill: Any = math.nan


# Of every point, whatever is computed.
ALWAYS = (
    Variable("status", dtype="U8", fill=""),
    Variable("message", dtype=f"U{MESSAGE}", fill=""),
    Variable("energy_error", units="J"),
    Variable("seconds", units="s"),
)
METHOD = Variable("method", dtype="U16", fill="")  # of every run: by which it was computed
