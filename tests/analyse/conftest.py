"""The linearised rod in 50-digit arithmetic, from the hand-assembled closed form: another route
than the generated modules, whose linearisation comes from derivation 3."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import mpmath as mp
import pytest
from rodgen.derive.chain import BOUNDARIES
from rodgen.derive.closed_form import Arithmetic, ClosedForm, link_sizes

from rodgen.scene import Scene

DIGITS = 50
ROD = {"length": 5.0, "bending_stiffness": 100.0, "mass": 50.0}
ZERO = mp.mpf(10) ** -20  # of the largest s^2: a rigid-body motion
NUDGE = mp.mpf(10) ** -15  # central differences: errors of 1e-30 and of 1e-35


def _total(term: Any, low: int, high: int) -> Any:
    return mp.fsum(term(i) for i in range(low, high + 1))


ARITHMETIC = Arithmetic(mp.cos, mp.sin, mp.mpf(1) / 2, _total)


@dataclass
class Exact:
    """A straight rod along x of mass M, length L, stiffness EI (exact floats), at rest."""

    n: int
    boundary: str
    mass: float = 50.0
    length: float = 5.0
    stiffness: float = 100.0
    lumped: bool = False

    def closed(self, phi: list[Any]) -> ClosedForm:
        m, l, k = link_sizes(*map(mp.mpf, (self.mass, self.length, self.stiffness, self.n)))
        return ClosedForm(
            n=self.n,
            m=m,
            l=l,
            k=k,
            phi=phi,
            hold=BOUNDARIES[self.boundary],
            arithmetic=ARITHMETIC,
            lumped=self.lumped,
        )

    @property
    def first(self) -> int:
        return BOUNDARIES[self.boundary].first

    @property
    def base(self) -> int:
        return 2 * BOUNDARIES[self.boundary].translates

    def forces(self, moving: list[Any], P: Any) -> mp.matrix:
        """Generalised forces of springs and follower force at these angles, less M times the
        steady acceleration of the straight rod along itself, where joint 0 is free."""
        phi = [mp.mpf(0)] * self.first + list(moving)
        form = self.closed(phi)
        columns = ([mp.mpf(0)] if form.hold.root else []) + phi
        K = mp.matrix(form.K())
        total = -K * mp.matrix(columns) + mp.matrix(form.F(P, mp.mpf(0)))
        if self.base:
            steady = mp.zeros(len(total), 1)
            steady[0] = -P / mp.mpf(self.mass)
            total -= mp.matrix(form.M()) * steady
        return total

    def matrices(self, P: Any) -> tuple[mp.matrix, mp.matrix]:
        """M and K of M q'' + K q = 0, joint 0 included."""
        links = self.n - self.first
        zero = [mp.mpf(0)] * links
        M = mp.matrix(self.closed([mp.mpf(0)] * self.n).M())
        K = mp.zeros(self.base + links)
        for j in range(links):
            up, down = list(zero), list(zero)
            up[j], down[j] = NUDGE, -NUDGE
            column = (self.forces(down, P) - self.forces(up, P)) / (2 * NUDGE)
            for i in range(self.base + links):
                K[i, self.base + j] = column[i]
        return M, K

    def internal_damping(self, c_int: float) -> mp.matrix:
        D = self.closed([mp.mpf(0)] * self.n).D_i(mp.mpf(c_int))
        C = mp.zeros(len(D))
        for i, row in enumerate(D):
            for j, value in enumerate(row):
                C[i, self.base + j] = value
        return C

    def external_damping(self, c_ext: float, fins: list[float]) -> mp.matrix:
        """Drag c s m_i v_i of motions across the rod: every joint moves in y alone."""
        form = self.closed([mp.mpf(0)] * self.n)
        size = self.base + self.n - self.first
        C = mp.zeros(size)
        for j in range(size):
            if self.base and j == 0:
                continue  # along the rod
            v = [mp.mpf(0)] * (self.n + 1)
            for i in range(self.n):
                rate = mp.mpf(1) if i - self.first == j - self.base else mp.mpf(0)
                v[i + 1] = v[i] + form.velocity_step(i, rate)[1]
            if self.base and j == 1:
                v = [mp.mpf(1)] * (self.n + 1)
            masses = [form.m / 2, *[form.m] * (self.n - 1), form.m / 2]
            D = [mp.mpf(c_ext) * mp.mpf(s) * m * u for s, m, u in zip(fins, masses, v, strict=True)]
            column = form.D_e(([mp.mpf(0)] * (self.n + 1), D))
            for i in range(size):
                C[i, j] = column[i]
        return C

    def squares(self, P: Any) -> list[Any]:
        """s^2 of all motions but the rigid ones, the slowest first."""
        M, K = self.matrices(P)
        if self.base:  # joint 0 follows: M_b a_b + M_bl phi'' + K_bl phi = 0
            b, size = self.base, len(M)
            carried = M[b:size, 0:b] * mp.inverse(M[0:b, 0:b])
            K = K[b:size, b:size] - carried * K[0:b, b:size]
            M = M[b:size, b:size] - carried * M[0:b, b:size]
        values = mp.eig(-mp.inverse(M) * K, left=False, right=False)
        largest = max(abs(v) for v in values)
        return sorted((v for v in values if abs(v) > ZERO * largest), key=abs)

    def rates(self, P: Any, C: mp.matrix) -> list[Any]:
        """s of all motions with damping."""
        M, K = self.matrices(P)
        size = len(K)
        A = mp.zeros(2 * size)
        low = [-mp.inverse(M) * part for part in (K, C)]
        for i in range(size):
            A[i, size + i] = mp.mpf(1)
            for j in range(size):
                A[size + i, j], A[size + i, size + j] = low[0][i, j], low[1][i, j]
        return list(mp.eig(A, left=False, right=False))


@pytest.fixture
def exact() -> Iterator[type[Exact]]:
    """The rod of ROD in 50-digit arithmetic."""
    with mp.workdps(DIGITS):
        yield Exact


@pytest.fixture
def rod() -> Callable[..., Scene]:
    """Scene of the rod of ROD: rod(links, boundary, loads, key of [rod]=...)."""

    def make(links: int, boundary: str, loads: dict[str, Any] | None = None, **keys: Any) -> Scene:
        table = {"name": "rod", "rod": ROD | {"links": links, "boundary": boundary} | keys}
        return Scene.from_dict(table | {"loads": loads or {}})

    return make
