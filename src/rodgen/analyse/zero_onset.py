"""The load at which a motion begins to grow without oscillating, of a rod that has neutral motions:
an eigenvalue goes through zero beside those that are zero under every load, so that no stiffness
tells it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from rodgen.analyse.modal import ROUNDING
from rodgen.analyse.onset import APART, Onset, unfound
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

WIDER = 4.0  # times the way to either side in which an onset is looked for
CLOSE = 1e-13  # of a load: rounding


def zero_onset(matrix: Callable[[float], Array], near: Onset, unit: float) -> Onset:
    """The onset next to an estimate: its error is the width of what was searched for it. matrix: of
    first order under a load, without the neutral motions; unit: a size of the load that matters.
    Raises AnalysisError."""
    beyond = float(np.linalg.slogdet(matrix(near.force))[1])

    def product(force: float) -> float:
        """Of all eigenvalues, in comparison."""
        sign, size = np.linalg.slogdet(matrix(force))
        return float(sign * np.exp(size - beyond))

    size = max(abs(near.force), unit)
    apart = max(near.error, CLOSE * size)
    while apart < APART * size:
        low, high = near.force - apart, near.force + apart
        ends = product(low), product(high)
        if ends[0] * ends[1] < 0:
            force = float(brentq(product, low, high, xtol=CLOSE * size))
            slope = abs(ends[1] - ends[0]) / (high - low)
            error = len(matrix(force)) * ROUNDING * max(map(abs, ends)) / slope
            return Onset(force, 0j, max(error, CLOSE * abs(force)))
        apart *= WIDER
    raise AnalysisError(unfound(near.force))
