"""How much of the error of DOP853 its own estimate sees, of a motion y' = lambda y.

In steps close to the limit of stability a motion that dies out is left with an error that the
estimate hardly sees: along the negative real axis it has a zero at h lambda = -5.7, and samples
inside a step, by the dense output, are off by a hundred times what it says.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

SEEN = 10.0  # times the estimate that an error between two ends may be
SHARES = np.linspace(0.05, 0.95, 19)  # of a step, at which its dense output is looked at


def unseen(z: Any) -> NDArray[np.float64]:
    """The largest error of the dense output of a step over the estimated error of the step, by
    h lambda (E. Hairer, S. P. Norsett, G. Wanner: Solving Ordinary Differential Equations I, II.5
    and II.6)."""
    z = np.asarray(z, dtype=complex)
    stages = len(DOP853.B)
    k: list[Any] = []
    for row in [*DOP853.A, DOP853.B, *DOP853.A_EXTRA]:
        moved = sum((float(a) * one for a, one in zip(row, k, strict=False)), np.ones_like(z))
        k.append(z * moved)
    end = k[stages] / z - 1
    five, three = (np.abs(_sum(row, k)) for row in (DOP853.E5, DOP853.E3))
    estimate = five**2 / np.sqrt(five**2 + 0.01 * three**2)
    inner = [_sum(row, k) for row in DOP853.D]
    parts = [end, k[0] - end, 2 * end - (k[stages] + k[0]), *inner]
    error = np.zeros(z.shape)
    for x in SHARES:
        found: Any = np.zeros_like(z)
        for at, part in enumerate(reversed(parts)):
            found = (found + part) * (1 - x if at % 2 else x)
        error = np.maximum(error, np.abs(1 + found - np.exp(x * z)))
    return np.asarray(error / estimate)


def _sum(row: Any, k: list[Any]) -> Any:
    return sum(float(a) * one for a, one in zip(row, k, strict=False))
