"""Formats and widths of the pictures that commands write."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from rodgen.errors import InputError

FORMATS = ("png", "svg", "pdf")
VECTORS = ("svg", "pdf")  # for papers, whose captions say what a title would
PER_INCH = {"in": 1.0, "cm": 2.54, "mm": 25.4, "pt": 72.0}  # points are those of PostScript
LEAST_WIDTH, MOST_WIDTH = 2.5, 40.0  # inches: in less, labels have no room


@dataclass(frozen=True)
class PictureSettings:
    """How pictures are written. format: one of FORMATS; width: of every picture [inches], None:
    each as wide as suits it. Raises InputError."""

    format: str = "png"
    width: float | None = None

    def __post_init__(self) -> None:
        if self.format not in FORMATS:
            raise InputError("--format", self.format, f"one of {', '.join(FORMATS)}")


def parse_width(text: str) -> float:
    """Parse a length with its unit, such as 3.3in or 84mm [inches]. Raises InputError."""
    found = re.fullmatch(rf"\s*([0-9.]+)\s*({'|'.join(PER_INCH)})\s*", text.lower())
    try:
        width = float(found[1]) / PER_INCH[found[2]] if found else math.nan
    except ValueError:
        width = math.nan
    if not math.isfinite(width):
        raise InputError("--width", text, "a length with its unit, such as 3.3in, 84mm or 240pt")
    if not LEAST_WIDTH <= width <= MOST_WIDTH:
        raise InputError("--width", text, f"from {LEAST_WIDTH:g} to {MOST_WIDTH:g} inches")
    return width
