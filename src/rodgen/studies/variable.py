"""Arrays that a study fills: their names, dimensions and types, known before any point is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from rodgen.dataset_result import DOUBTS, LONG_NAME, UNITS, UNKNOWN

MESSAGE = 200  # characters of a message that are kept


@dataclass(frozen=True)
class Variable:
    """An array of results: dims and shape beside those of the points, dtype as NumPy writes it,
    units, what stands where nothing was found, and what it is in words."""

    name: str
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    dtype: str = "f8"
    units: str = ""
    fill: Any = math.nan
    words: str = ""

    @property
    def attributes(self) -> dict[str, Any]:
        """What xarray has beside its values."""
        whole = self.dtype.startswith("i")
        found = {LONG_NAME: self.words, UNITS: self.units, UNKNOWN: self.fill if whole else ""}
        return {name: value for name, value in found.items() if value != ""}


# Of every point, whatever is computed.
ALWAYS = (
    Variable("status", dtype="U8", fill=""),
    Variable("message", dtype=f"U{MESSAGE}", fill=""),
    Variable(DOUBTS, dtype="i4", fill=-1, words="doubts about the numbers"),
    Variable("energy_error", units="J"),
    Variable("seconds", units="s"),
)
METHOD = Variable("method", dtype="U16", fill="")  # of every run: by which it was computed
