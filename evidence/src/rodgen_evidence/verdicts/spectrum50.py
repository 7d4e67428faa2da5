"""Eigenvalues of the small motions of a chain about its rest, by differences in 50 digits."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from mpmath import mp, mpf

from rodgen_evidence.verdicts.chain_loads import rates
from rodgen_evidence.verdicts.digits import DIGITS, FIFTY
from rodgen_evidence.verdicts.exact_rest import ExactRest, state
from rodgen_evidence.verdicts.link_chain import LinkChain, Table

STEP = mpf(10) ** -30  # its error is its square, or itself where a force is |v| v
ZERO = 1e-26  # of the largest derivative: a column that is zero
# Of the largest rate: a growth next to zero, which in floating point may be that of two zeros; and
# the digits in which it is looked at.
CLOSE, PRECISE = 1e-5, 40
# Zeros of the whole rod that are left form blocks of two at most, which differences that are right
# to 1e-30 split by 1e-15 1/s; what grows does so by feedback and damping of 1e-3 or more.
GROWS = 1e-9


class Spectrum50(NamedTuple):
    """s: eigenvalues [1/s]; zeros: how many more are exactly zero, of places on which nothing
    depends."""

    s: Any
    zeros: int

    @property
    def growth(self) -> float:
        """Growth rate of the motion that grows most [1/s]."""
        return float(self.s.real.max(initial=-np.inf if not self.zeros else 0.0))

    @property
    def growing(self) -> Any:
        """The eigenvalues that grow."""
        return self.s[self.s.real > GROWS]


def spectrum50(table: Table, rest: ExactRest) -> Spectrum50:
    """The eigenvalues about a rest."""
    with mp.workdps(DIGITS):
        chain = LinkChain(table, FIFTY)
        y = state(chain, rest.z)
        columns = []
        for j in range(len(y)):
            up, down = list(y), list(y)
            up[j], down[j] = y[j] + STEP, y[j] - STEP
            pairs = zip(rates(chain, up), rates(chain, down), strict=True)
            columns.append([(a - b) / (2 * STEP) for a, b in pairs])
        own = _moving(columns)
        J = [[columns[j][i] for j in own] for i in own]
    s = np.linalg.eigvals(np.array(J, dtype=float).reshape(len(own), len(own)))
    if own and np.abs(s.real).min() < CLOSE * max(1.0, np.abs(s).max()):
        with mp.workdps(PRECISE):
            s = np.array([complex(v) for v in mp.eig(mp.matrix(J), left=False, right=False)])
    return Spectrum50(s, len(y) - len(own))


def _moving(columns: Any) -> list[int]:
    """Numbers of the states without those on which nothing depends: eigenvalues that are zero."""
    least = ZERO * max(abs(v) for column in columns for v in column)
    own = list(range(len(columns)))
    while True:
        left = [j for j in own if any(abs(columns[j][i]) > least for i in own)]
        if left == own:
            return own
        own = left
