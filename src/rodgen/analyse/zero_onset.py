"""Onset of divergence of a rod with neutral motions: an eigenvalue goes through zero beside those
that are zero under every load, so that the stiffness does not show it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from rodgen.analyse.modal import ROUNDING
from rodgen.analyse.onset import APART, Onset, no_onset_message
from rodgen.arrays import Array
from rodgen.errors import AnalysisError

WIDER = 4.0  # times the way to either side in which an onset is looked for
CLOSE = 1e-13  # of a load: rounding


def solve_zero_onset(matrix: Callable[[float], Array], near: Onset, unit: float) -> Onset:
    """Find the onset next to an estimate; its error is rounding of the determinant. matrix: of
    first order under a load, without the neutral motions; unit: a typical size of the load. Raises
    AnalysisError."""
    beyond = float(np.linalg.slogdet(matrix(near.force))[1])

    def eigenvalue_product(force: float) -> float:
        """Product of all eigenvalues, over that at the estimate."""
        sign, size = np.linalg.slogdet(matrix(force))
        return float(sign * np.exp(size - beyond))

    size = max(abs(near.force), unit)
    apart = max(near.error, CLOSE * size)
    while apart < APART * size:
        low, high = near.force - apart, near.force + apart
        ends = eigenvalue_product(low), eigenvalue_product(high)
        if ends[0] * ends[1] < 0:
            force = float(brentq(eigenvalue_product, low, high, xtol=CLOSE * size))
            slope = abs(ends[1] - ends[0]) / (high - low)
            error = len(matrix(force)) * ROUNDING * max(map(abs, ends)) / slope
            return Onset(force, 0j, max(error, CLOSE * abs(force)))
        apart *= WIDER
    raise AnalysisError(no_onset_message(near.force))
