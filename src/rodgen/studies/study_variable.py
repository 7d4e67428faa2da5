"""Variables of a study: arrays with their names, dimensions and types, known before any result."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from rodgen.dataset_result import DOUBTS, LONG_NAME, UNITS, UNKNOWN

MESSAGE = 200  # characters of a message that are kept


@dataclass(frozen=True)
class StudyVariable:
    """An array of results. dims, shape: beside those of the points; dtype: as NumPy writes it;
    fill: value where there is no result; words: description."""

    name: str
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    dtype: str = "f8"
    units: str = ""
    fill: Any = math.nan
    words: str = ""

    @property
    def attributes(self) -> dict[str, Any]:
        """Its attributes in xarray: description, units and, of whole numbers, the fill value."""
        whole = self.dtype.startswith("i")
        found = {LONG_NAME: self.words, UNITS: self.units, UNKNOWN: self.fill if whole else ""}
        return {name: value for name, value in found.items() if value != ""}


# Variables of every study.
ALWAYS = (
    StudyVariable("status", dtype="U8", fill=""),
    StudyVariable("message", dtype=f"U{MESSAGE}", fill=""),
    StudyVariable(DOUBTS, dtype="i4", fill=-1, words="doubts about the numbers"),
    StudyVariable("energy_error", units="J"),
    StudyVariable("seconds", units="s"),
)
METHOD = StudyVariable("method", dtype="U16", fill="")  # of runs: the method that computed them
