"""The object of the Java listing: members, initial state, motion, energies and getters.

Appendix A, lines 13-232 and 617-681, statement by statement; java_equation has lines 235-614 and
java_steps the steppers of section 4.1, lines 705-1002. Names are those of the listing. Lines are
those of the listing too; where the scan has given a number to the rest of a wrapped line, that of
its beginning. Pages and wrapped lines are joined.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, SupportsIndex

import sympy
from sympy import S

Num = Any
Limit = Callable[[int], int]  # what k is compared with in lines 200 and 202, from the index l

# Lines 625-663: return coordinates; and so on.
ARRAYS: dict[str, str] = {
    "getCoordinates": "coordinates",
    "getAngles": "angles",
    "getCenterOfGravityCoordinates": "centerOfGravity",
    "getOmegas": "omegas",
    "getAeroCoefficients": "aeroDampingCoef",
    "getVelocityAngles": "velocityAngles",
    "getExternalDampingX": "dampingForcesX",
    "getExternalDampingY": "dampingForcesY",
}


class JavaArray(list[Num]):
    """A Java array: an index below zero is an error, not a place counted from the end."""

    def __getitem__(self, at: Any) -> Num:
        return super().__getitem__(_check_index(at))

    def __setitem__(self, at: Any, value: Num) -> None:
        super().__setitem__(_check_index(at), value)


def _check_index(at: SupportsIndex) -> int:
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


def LETTER(l: int) -> int:
    """k<=l, k<l."""
    return l


class RodObject:
    """The members of the listing's class, and the methods that move them.

    printed: members initialised where the listing has them, before the constructor's body and
    before setInitialState, as Java does it; otherwise as soon as what they need is known.
    """

    def __init__(
        self, elementCountInit: int, stepInit: Num, math: Maths = EXACT, printed: bool = False
    ):
        self.math, self.printed = math, printed
        zero: Num = 0 * math.one
        self.elementCount, self.time = 0, zero
        self.mass = self.length = self.stiffness = zero
        self.innerDampingCoef = self.exterDampingCoef = zero
        self.spikeDampingCoef = self.tailDampingCoef = self.mediumDampingCoef = zero
        self.followerForce = self.followerAngle = self.gravityAcceleration = zero
        self.kineticEnergy = self.potentialEnergy = self.overallEnergy = zero
        self.solution: list[Num] = []
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

    def zeros(self, length: int) -> JavaArray:
        """new double[length]."""
        return JavaArray([0 * self.math.one] * length)

    def table(self, rows: int, columns: int) -> JavaArray:
        """new double[rows][columns]."""
        return JavaArray([self.zeros(columns) for _ in range(rows)])

    def setInitialState(
        self,
        vx0Init: Num,
        vy0Init: Num,
        omegasInit: Sequence[Num],
        anglesInit: Sequence[Num],
        **members: Num,
    ) -> None:
        """Lines 86-111; members: the other arguments, by the names of the members they become."""
        self.velocities[0] = vx0Init
        self.velocities[1] = vy0Init
        for i in range(len(self.omegas)):
            self.omegas[i] = omegasInit[i]
        for i in range(len(self.angles)):
            self.angles[i] = anglesInit[i]
        self._turn()
        assert members.keys() <= vars(self).keys()
        vars(self).update(members)  # lines 100-110
        if not self.printed:
            self.initialiseElement()

    def _turn(self) -> None:
        """Lines 94-99 and 139-144: sines and cosines of the angles."""
        for i in range(len(self.anglesSin)):
            self.anglesSin[i] = self.math.sin(self.angles[i])
        for i in range(len(self.anglesCos)):
            self.anglesCos[i] = self.math.cos(self.angles[i])

    # Motion --------------------------------------------------------------------------------------

    def updateTime(self) -> None:
        """Line 123."""
        self.time += self.step

    def updateOmegas(self) -> None:
        """Lines 129-132; solution.getValue(i) is solution[i]."""
        for i in range(len(self.omegas)):
            self.omegas[i] += self.step * self.solution[i + 2]

    def updateAngles(self) -> None:
        """Lines 138-144."""
        for i in range(len(self.angles)):
            self.angles[i] += self.step * self.omegas[i]
        self._turn()

    def updateCoords(self) -> None:
        """Lines 151-156."""
        for i in range(len(self.coordinates)):
            if i < 2:
                self.coordinates[i] += self.step * self.velocities[i]
            elif i % 2 == 0:  # x
                at = i - i // 2 - 1
                moved = self.elementLength * self.anglesCos[at]
                self.coordinates[i] = self.coordinates[i - 2] + moved
            elif i % 2 != 0:  # y
                at = i - i // 2 - 2
                moved = self.elementLength * self.anglesSin[at]
                self.coordinates[i] = self.coordinates[i - 2] + moved

    def updateVelocities(self) -> None:
        """Lines 163-169."""
        v, l = self.velocities, self.elementLength
        for i in range(2):
            v[i] += self.step * self.solution[i]
        for i in range(2, len(v)):
            if i % 2 == 0:  # x
                at = i - i // 2 - 1
                v[i] = v[i - 2] - self.omegas[at] * l * self.anglesSin[at]
            elif i % 2 != 0:  # y
                at = i - i // 2 - 2
                v[i] = v[i - 2] + self.omegas[at] * l * self.anglesCos[at]

    def updateCG(self) -> None:
        """Lines 177-185."""
        length = len(self.coordinates)
        topX = self.coordinates[0] + self.coordinates[length - 2]
        for i in range(2, length - 2, 2):
            topX += 2 * self.coordinates[i]
        self.centerOfGravity[0] = topX / (2 * self.elementCount)
        topY = self.coordinates[1] + self.coordinates[length - 1]
        for i in range(3, length - 1, 2):
            topY += 2 * self.coordinates[i]
        self.centerOfGravity[1] = topY / (2 * self.elementCount)

    # Energies ------------------------------------------------------------------------------------

    def updateKineticEnergy(self, limit: Limit = LETTER) -> None:
        """Lines 191-210."""
        n, v, w = self.elementCount, self.velocities, self.omegas
        length, third = self.elementLength, self.math.one / 3
        energy = 0 * self.math.one
        energy += n * (v[0] * v[0] + v[1] * v[1])
        for i in range(n):
            energy += w[i] * w[i] * length * length * (third + (n - i - 1))
        for i in range(n):
            energy -= v[0] * w[i] * length * self.anglesSin[i] * (1 + 2 * (n - i - 1))
        for i in range(n):
            energy += v[1] * w[i] * length * self.anglesCos[i] * (1 + 2 * (n - i - 1))
        for i in range(n):
            for l in range(i + 1):
                for k in range(limit(l) + 1):
                    if k < limit(l):
                        cosine = self.math.cos(self.angles[l] - self.angles[k])
                        if l == i:
                            energy += length * length * w[k] * w[l] * cosine
                        else:
                            energy += 2 * length * length * w[k] * w[l] * cosine
        self.kineticEnergy = energy * (self.math.one / 2 * self.elementMass)

    def updatePotentialEnergy(self) -> None:
        """Lines 217-224."""
        energy = 0 * self.math.one
        for i in range(self.elementCount - 1):
            turn = self.angles[i + 1] - self.angles[i]
            energy += turn * turn
        self.potentialEnergy = energy * (self.math.one / 2 * self.elementStiffness)

    def updateOverallEnergy(self) -> None:
        """Lines 230-231."""
        self.overallEnergy = self.kineticEnergy + self.potentialEnergy

    # Getters -------------------------------------------------------------------------------------

    def getCoordinate(self, index: int) -> Num:
        """Lines 617-619."""
        return self.coordinates[index]

    def getVelocity(self, index: int) -> Num:
        """Lines 621-623."""
        return self.velocities[index]

    def getArray(self, name: str) -> JavaArray:
        """One of ARRAYS: the member itself, not a copy."""
        array: JavaArray = getattr(self, ARRAYS[name])
        return array

    def getPotentialEnergy(self) -> Num:
        """Lines 643-645."""
        return self.potentialEnergy

    def getVelocitiesX(self) -> list[Num]:
        """Lines 665-672."""
        return [self.velocities[2 * i] for i in range(self.elementCount + 1)]

    def getVelocitiesY(self) -> list[Num]:
        """Lines 674-681."""
        return [self.velocities[2 * i + 1] for i in range(self.elementCount + 1)]
