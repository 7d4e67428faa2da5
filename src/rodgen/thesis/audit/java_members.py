"""The listing's members, constructor and initial state (lines 13-118).

The transliteration keeps the listing's names, indices, conditions and integer divisions, so that
it can be read beside the listing. It computes in whatever numbers it is filled with: SymPy for the
comparison, floats for the measured orders.
"""

# The names are those of the listing.
# ruff: noqa: N815

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, SupportsIndex

import sympy
from sympy import S

from rodgen.derive.symbols import k, l, m, vx0, vy0

from .java_truth import H
from .truth import P, c_ext, c_int, g, nu, omega, phi

Num = Any


class Array(list[Num]):
    """A Java array: an index below zero is an error, not a place counted from the end."""

    def __getitem__(self, at: Any) -> Num:
        return super().__getitem__(_checked(at))

    def __setitem__(self, at: Any, value: Num) -> None:
        super().__setitem__(_checked(at), value)


def _checked(at: SupportsIndex) -> int:
    index = int(at)
    if index < 0:
        raise IndexError(f"ArrayIndexOutOfBoundsException: {index}")
    return index


@dataclass(frozen=True)
class Maths:
    """Java's Math, and the number one of the kind that is computed with."""

    one: Num
    sin: Callable[[Num], Num]
    cos: Callable[[Num], Num]
    atan: Callable[[Num], Num]
    PI: Num


EXACT = Maths(S.One, sympy.sin, sympy.cos, sympy.atan, sympy.pi)
FLOATS = Maths(1.0, math.sin, math.cos, math.atan, math.pi)


@dataclass(frozen=True)
class Initial:
    """The arguments of setInitialState (lines 86-90) but for the velocities and angles."""

    mass: Num
    length: Num
    stiffness: Num
    innerDampingCoef: Num
    followerForce: Num
    gravityAcceleration: Num
    followerAngle: Num
    exterDampingCoef: Num
    spikeDampingCoef: Num
    tailDampingCoef: Num
    mediumDampingCoef: Num


class FreeRodModel:
    """An object of the listing's class.

    printed: members initialised where the listing has them, before the constructor's body and
    before setInitialState, as Java does it; otherwise as soon as what they need is known.
    """

    mass: Num
    length: Num
    stiffness: Num
    innerDampingCoef: Num
    exterDampingCoef: Num
    spikeDampingCoef: Num
    tailDampingCoef: Num
    mediumDampingCoef: Num
    followerForce: Num
    followerAngle: Num
    gravityAcceleration: Num
    kineticEnergy: Num
    potentialEnergy: Num
    overallEnergy: Num
    solution: list[Num]
    leftSide: list[list[Num]]
    rightSide: list[Num]

    def __init__(
        self, elementCountInit: int, stepInit: Num, math: Maths = EXACT, printed: bool = False
    ):
        self.math, self.printed = math, printed
        zero = 0 * math.one
        self.elementCount, self.time = 0, zero
        self.mass = self.length = self.stiffness = zero
        if printed:
            self.initialiseElement()
            self.initialiseArrays()
        # Constructor, lines 116-117.
        self.step = stepInit
        self.elementCount = elementCountInit
        if not printed:
            self.initialiseArrays()

    def initialiseElement(self) -> None:
        """Lines 27-29."""
        self.elementMass = self.mass / self.elementCount
        self.elementLength = self.length / self.elementCount
        self.elementStiffness = self.stiffness / self.elementLength

    def initialiseArrays(self) -> None:
        """Lines 52-77."""
        elementCount = self.elementCount
        self.angles = self.zeros(elementCount)
        self.anglesSin = self.zeros(elementCount)
        self.anglesCos = self.zeros(elementCount)
        self.omegas = self.zeros(elementCount)
        self.coordinates = self.zeros(2 * elementCount + 2)
        self.velocities = self.zeros(2 * elementCount + 2)
        self.centerOfGravity = self.zeros(2)
        self.dampingForcesX = self.zeros(elementCount + 1)
        self.dampingForcesY = self.zeros(elementCount + 1)
        self.aeroDampingCoef = self.zeros(elementCount + 1)
        self.velocityAngles = self.zeros(elementCount + 1)
        self.rows = elementCount + 2
        self.columns = self.rows
        self.matrixM = self.table(self.rows, self.columns)
        self.matrixQ = self.table(self.rows, elementCount)
        self.matrixK = self.table(self.rows, elementCount)
        self.matrixC = self.table(self.rows, elementCount)

    def zeros(self, length: int) -> Array:
        """new double[length]."""
        return Array([0 * self.math.one] * length)

    def table(self, rows: int, columns: int) -> Array:
        """new double[rows][columns]."""
        return Array([self.zeros(columns) for _ in range(rows)])

    def setInitialState(
        self,
        vx0Init: Num,
        vy0Init: Num,
        omegasInit: Sequence[Num],
        anglesInit: Sequence[Num],
        init: Initial,
    ) -> None:
        """Lines 86-111."""
        self.velocities[0] = vx0Init
        self.velocities[1] = vy0Init
        for i in range(len(self.omegas)):
            self.omegas[i] = omegasInit[i]
        for i in range(len(self.angles)):
            self.angles[i] = anglesInit[i]
        for i in range(len(self.anglesSin)):
            self.anglesSin[i] = self.math.sin(self.angles[i])
        for i in range(len(self.anglesCos)):
            self.anglesCos[i] = self.math.cos(self.angles[i])
        vars(self).update(vars(init))  # lines 100-110
        if not self.printed:
            self.initialiseElement()


FINS = sympy.symbols("s_spike s_medium s_tail", nonnegative=True)  # factors of external damping


def symbolic(n: int, printed: bool = False) -> FreeRodModel:
    """The object after setInitialState, filled with the letters of the truth."""
    model = FreeRodModel(n, H, printed=printed)
    setSymbols(model)
    return model


def setSymbols(model: FreeRodModel) -> None:
    """setInitialState with the letters of the truth."""
    n = model.elementCount
    spike, medium, tail = FINS
    init = Initial(n * m, n * l, k * l, c_int, P, g, nu, c_ext, spike, tail, medium)
    model.setInitialState(vx0, vy0, omega[:n], phi[:n], init)
