"""Types of arrays, and evenly spaced indices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def even_indices(first: int, last: int, most: int) -> NDArray[np.int_]:
    """Return at most so many indices from the first to the last, about evenly spaced."""
    return np.unique(np.linspace(first, last, most).round().astype(int))
