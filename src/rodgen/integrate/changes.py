"""What was changed while a run went on, sample by sample."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.stepper import Array


@dataclass(frozen=True)
class Changes:
    """What held at each of T samples. p: parameters of the module, (T, parameters); given: energy
    [J] that changes and kicks have put in since the start, (T,)."""

    p: Array
    given: Array

    def taken(self, kept: NDArray[np.intp] | slice) -> Changes:
        """Those of some samples alone."""
        return Changes(self.p[kept], self.given[kept])

    def follow(self, made: Callable[..., Any], of: Sequence[Array], axis: int) -> Array:
        """What is made of arrays over the samples and of p, which is one for each call: between
        two changes of it; joined along its axis of time."""
        changed = np.any(self.p[1:] != self.p[:-1], axis=1)
        edges = [0, *(np.flatnonzero(changed) + 1), len(self.p)]
        parts = [
            np.asarray(made(*(values[a:b] for values in of), self.p[a]))
            for a, b in itertools.pairwise(edges)
        ]
        return np.concatenate(parts, axis)
