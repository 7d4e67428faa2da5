"""The listing's object filled with the letters of the truth, and what its methods must give."""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy
from sympy import Expr, S, Symbol

from rodgen.derive.loads import gravity
from rodgen.derive.symbols import k, l, m, vx0, vy0
from rodgen.model.rod import BOUNDARIES
from rodgen_evidence.thesis.audit.claim import Entries
from rodgen_evidence.thesis.audit.java_equation import FreeRodModel
from rodgen_evidence.thesis.audit.java_object import JavaArray
from rodgen_evidence.thesis.audit.truth import (
    LETTERS,
    Column,
    P,
    c_ext,
    c_int,
    g,
    nu,
    omega,
    phi,
    product,
    truth,
)

H = Symbol("h", positive=True)  # time step
FINS = sympy.symbols("s_spike s_medium s_tail", nonnegative=True)  # factors of external damping


class Symbolic(FreeRodModel):
    """The object after setInitialState; members: functions of n, whose values
    are then written."""

    def __init__(self, n: int, printed: bool = False, **members: Any) -> None:
        super().__init__(n, H, printed=printed)
        self.setLetters()
        for name, value in members.items():
            written = value(n)
            setattr(self, name, JavaArray(written) if isinstance(written, list) else written)

    def setLetters(self) -> None:
        """setInitialState with the letters of the truth."""
        n = self.elementCount
        spike, medium, tail = FINS
        self.setInitialState(
            vx0,
            vy0,
            omega[:n],
            phi[:n],
            mass=n * m,
            length=n * l,
            stiffness=k * l,
            innerDampingCoef=c_int,
            followerForce=P,
            gravityAcceleration=g,
            followerAngle=nu,
            exterDampingCoef=c_ext,
            spikeDampingCoef=spike,
            tailDampingCoef=tail,
            mediumDampingCoef=medium,
        )


def listing(*calls: str, read: str, factor: Expr = S.One, **members: Any) -> Entries:
    """Entries, times a factor, of what is read after calls of methods of the object.

    read: members, or methods that return something, with spaces between them; members: as of
    `Symbolic`.
    """

    def entries(n: int) -> Column:
        it = Symbolic(n, **members)
        it.call(*calls)
        found = [getattr(it, name) for name in read.split()]
        values = [value() if callable(value) else value for value in found]
        return [factor * e for value in values for e in np.ravel(np.array(value, dtype=object))]

    return entries


def indexed_symbols(name: str, count: int) -> Column:
    """Symbols name_0, name_1, ..."""
    return [Symbol(f"{name}_{at}", real=True) for at in range(count)]


def state_letters(n: int) -> Column:
    """x0, y0, phi_i and their rates, in the order of rodgen's state."""
    return [*truth(n).positions, *truth(n).rates]


def joints(n: int) -> Column:
    """x_0, y_0, x_1, y_1, ... of the joints."""
    t = truth(n)
    return [t.letters(c) for s in range(n + 1) for c in t.derived.joint(s)]


def joint_velocities(n: int) -> Column:
    """Rates of the joints' coordinates."""
    t = truth(n)
    return [
        t.letters(t.derived.time_derivative(c)) for s in range(n + 1) for c in t.derived.joint(s)
    ]


def centre(n: int) -> Column:
    """Centre of gravity: the mean over the links of the mean over each."""
    t = truth(n)
    axes = zip(*t.derived.link_points, strict=True)
    return [sum((t.letters(t.derived.mean(c)) for c in axis), S.Zero) / n for axis in axes]


def gravity_energy(n: int) -> Expr:
    """Minus the work of the weights from the origin."""
    force = (f.xreplace(LETTERS) for f in gravity.LOAD.weight(n * m, BOUNDARIES["free"]))
    return -sum((f * c for f, c in zip(force, centre(n), strict=True)), S.Zero)


def right_side(n: int) -> Column:
    """Q omega^2 - K phi - D_i omega + F + A - D_e."""
    t = truth(n)
    squares = product(t.Q, [w**2 for w in omega[:n]])
    springs, dampers = product(t.K, list(phi[:n])), product(t.D_i, list(omega[:n]))
    terms = zip(squares, springs, dampers, t.F, t.A, t.D_e, strict=True)
    return [q - k - d + f + a - e for q, k, d, f, a, e in terms]
