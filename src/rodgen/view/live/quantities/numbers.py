"""Numbers as text that does not jitter: always as wide, always as many digits."""

from __future__ import annotations

import math

WIDTH = 12  # of -1.2345e-100
FIGURE_SPACE = "\u2007"  # as wide as a digit, and kept by HTML at the start of a line
THIN_SPACE = "\u202f"  # between thousands, where no line is broken
NOTHING = "–"


def five(value: float) -> str:
    """Five significant digits."""
    text = f"{value:#.5g}" if math.isfinite(value) else str(value)
    return padded(text.removesuffix("."))


def three(value: float) -> str:
    """Three significant digits."""
    text = f"{value:#.3g}" if math.isfinite(value) else str(value)
    return padded(text.removesuffix("."))


def fixed(value: float, decimals: int) -> str:
    """So many decimals; five significant digits of what is too large for them."""
    if not abs(value) < 10.0 ** (WIDTH - 3 - decimals):
        return five(value)
    return padded(f"{round(value, decimals) + 0.0:.{decimals}f}")  # + 0.0: no negative zero


def whole(value: int) -> str:
    """A whole number, its thousands apart."""
    return padded(f"{value:,}".replace(",", THIN_SPACE))


def padded(text: str) -> str:
    """Right-justified."""
    return text.rjust(WIDTH, FIGURE_SPACE)
