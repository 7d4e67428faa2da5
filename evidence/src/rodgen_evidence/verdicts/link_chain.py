"""A chain of rigid links under the loads of a scene, by Newton-Euler at one state.

Places are sums over the links of c_i e_i + d_i n_i; forces act in places, moments on links. It
reads the tables of a scene, and knows those that the scenes of this package have.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from rodgen_evidence.verdicts.digits import NumberKind, Vector, solve

Table = dict[str, Any]


class LinkChain:
    """The rod of a scene: sizes, springs and masses, and how its coordinates are ordered."""

    def __init__(self, table: Table, numbers: NumberKind):
        self.table, self.numbers = table, numbers
        rod, of = table["rod"], numbers.of
        self.n, self.boundary = int(rod["links"]), rod["boundary"]
        self.base = 2 * (self.boundary == "free")
        self.held = int(self.boundary == "cantilever")
        self.l, self.mass = of(rod["length"]) / self.n, of(rod["mass"])
        self.k = of(rod["bending_stiffness"]) / self.l
        self.axis = of(rod.get("clamp_angle", 0.0))
        self.states = list(table.get("states", {}))
        self.size = self.base + self.n - self.held
        self.joints = [self.arms(s, 0) for s in range(self.n)]
        self.joints.append(self.arms(self.n - 1, self.l))
        self.springs = self._springs()
        self.masses, self.spin = self._masses()

    def arms(self, link: int, along: Any, across: Any = 0) -> list[tuple[Any, Any]]:
        """A place on a link: c_i and d_i of every link."""
        before = [(self.l, 0)] * link
        return [*before, (along, across), *[(0, 0)] * (self.n - link - 1)]

    def place(self, s: float) -> tuple[int, Any]:
        """The link on which s lies, and how far along it."""
        whole = Fraction(repr(float(s))) * self.n
        link = min(int(whole), self.n - 1)
        share = whole - link
        return link, self.numbers.of(share.numerator) / share.denominator * self.l

    def _springs(self) -> list[tuple[int, int, Any]]:
        """Links before and after every spring, the clamp as -1, and its stiffness: EI over the rod
        that bends there, half a link to either side and, at an end, on to a body that resists
        turning."""
        half = self.numbers.of(0.5) * self.l
        first, last = half, half
        for body in self.table.get("bodies", ()):
            link, along = self.place(body["at"])
            if body.get("inertia", 0.0) or any(body.get("offset", ())):
                last = max(last, along) if link == self.n - 1 else last
                first = max(first, self.l - along) if link == 0 else first
        before, after = [half] * (self.n - 1), [half] * (self.n - 1)
        if self.n > 1:
            after[-1] = last
            before[0] = first if self.boundary in ("free", "pinned") else half
        EI = self.k * self.l
        cells = enumerate(zip(before, after, strict=True))
        found = [(s, s + 1, EI / (one + other)) for s, (one, other) in cells]
        if self.boundary == "clamped":
            found.append((-1, 0, EI / (last if self.n == 1 else half)))
        return found

    def _masses(self) -> tuple[list[tuple[Any, Any]], Vector]:
        """Masses with their places, and moments of inertia of the links."""
        m, half = self.mass / self.n, self.numbers.of(0.5)
        if self.table["rod"].get("inertia", "uniform") == "lumped":
            found = [(m * self.at_joint(s), joint) for s, joint in enumerate(self.joints)]
            spin = [0 * m] * self.n
        else:
            found = [(m, self.arms(i, half * self.l)) for i in range(self.n)]
            spin = [m * self.l**2 / 12] * self.n
        for body in self.table.get("bodies", ()):
            link, along = self.place(body["at"])
            a, b = map(self.numbers.of, body.get("offset", (0.0, 0.0)))
            found.append((self.numbers.of(body["mass"]), self.arms(link, along + a, b)))
            spin[link] += self.numbers.of(body.get("inertia", 0.0))
        return found, spin

    def at_joint(self, s: int) -> Any:
        """Links' worth of what is spread along the rod that counts at a joint."""
        return self.numbers.of(0.5 if s in (0, self.n) else 1.0)

    def at(self, y: Sequence[Any]) -> ChainState:
        """The chain in a state: position of joint 0, angles, their rates, added states."""
        return ChainState(self, y)


class ChainState:
    """Angles, rates and directions of all links, places and velocities."""

    def __init__(self, chain: LinkChain, y: Sequence[Any]):
        self.chain = chain
        size, base, zero = chain.size, chain.base, chain.numbers.of(0)
        q, u = list(y[:size]), list(y[size : 2 * size])
        self.u = u
        self.added = dict(zip(chain.states, y[2 * size :], strict=True))
        self.origin, self.v0 = (q[:2], u[:2]) if base else ([zero, zero], [zero, zero])
        self.phi = [chain.axis] * chain.held + q[base:]
        self.omega = [zero] * chain.held + u[base:]
        self.e = [(chain.numbers.cos(a), chain.numbers.sin(a)) for a in self.phi]

    def place(self, arms: Any) -> tuple[Any, Any]:
        """Position of a place."""
        x, y = self.origin
        for (c, d), (cos, sin) in zip(arms, self.e, strict=True):
            x, y = x + c * cos - d * sin, y + c * sin + d * cos
        return x, y

    def columns(self, arms: Any) -> list[tuple[Any, Any]]:
        """Derivatives of a place by every angle."""
        each = zip(arms, self.e, strict=True)
        return [(-c * sin - d * cos, c * cos - d * sin) for (c, d), (cos, sin) in each]

    def velocity(self, arms: Any) -> tuple[Any, Any]:
        """Velocity of a place."""
        x, y = self.v0
        for (a, b), omega in zip(self.columns(arms), self.omega, strict=True):
            x, y = x + a * omega, y + b * omega
        return x, y

    def rates(self, forces: Any, moments: Vector) -> Vector:
        """Accelerations of the coordinates under forces in places and moments on links."""
        chain, first = self.chain, self.chain.held
        squares = [w**2 for w in self.omega]
        size, base = chain.size, chain.base
        M: list[Vector] = [[0] * size for _ in range(size)]
        Q: Vector = [0] * base + moments[first:]
        pushed = [(0, arms, x, y) for arms, x, y in forces]
        for m, arms in chain.masses:
            spun = zip(self.columns(arms), squares, strict=True)
            back = [(b * w, -a * w) for (a, b), w in spun]
            pushed.append((m, arms, m * sum(b[0] for b in back), m * sum(b[1] for b in back)))
        for m, arms, x, y in pushed:
            J = [(1, 0), (0, 1)][:base] + self.columns(arms)[first:]
            for i, (a, b) in enumerate(J):
                Q[i] += a * x + b * y
                if m:
                    for j in range(i + 1):
                        M[i][j] += m * (a * J[j][0] + b * J[j][1])
        for i in range(size):
            for j in range(i):
                M[j][i] = M[i][j]
        for i, spin in enumerate(chain.spin[first:]):
            M[base + i][base + i] += spin
        return solve(M, Q)
