"""The equation of the Java listing, lines 235-614: matrices, loads, right side and solution.

The elimination that getSolution calls is of a library that is not printed, and is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from rodgen_evidence.thesis.audit.java_object import JavaArray, Num, RodObject

# The argument of line 511 before the sine, from the angles of velocity and of the two links.
Mean = Callable[[Num, Num, Num], Num]
# Names that are called and not defined, and what they must stand for.
MISSPELLED = {"assembleMatrixD": "assembleMatrixC", "updateOmeegas": "updateOmegas"}


def MEAN(velocity: Num, before: Num, after: Num) -> Num:
    """Line 511 with the missing parenthesis opened at the break of the line, after the minus."""
    return abs(velocity - (before + after) / 2)


def WITHOUT(velocity: Num, before: Num, after: Num) -> Num:
    """Line 511 with the last parenthesis dropped."""
    return abs(velocity - before + after) / 2


class FreeRodModel(RodObject):
    """An object of the listing's class."""

    def call(self, *names: str) -> None:
        """Call methods one after the other by their names, the misspelled ones put right."""
        for name in names:
            getattr(self, MISSPELLED.get(name, name))()

    # Matrices ------------------------------------------------------------------------------------

    def assembleMatrixM(self) -> None:
        """Lines 236-286."""
        for r in range(self.rows):
            for c in range(self.columns):
                # filling the first symmetric half: rows of velocities[0], velocities[1]
                if r == 0:
                    self._velocityRow(0, c)
                if r == 1:
                    self._velocityRow(1, c)
                # generic omega rows
                if r >= 2 and r < self.rows - 1:
                    self._omegaRow(r, c)
                # last omega row, line 270
                if r == self.rows - 1 and c == r:
                    two_thirds = 2 * self.math.one / 3
                    self.matrixM[r][c] = two_thirds * self.elementLength * self.elementLength
        # generating the other symmetric half
        for r in range(self.rows):
            for c in range(self.columns):
                if r != c:
                    self.matrixM[c][r] = self.matrixM[r][c]

    def _velocityRow(self, r: int, c: int) -> None:
        """Lines 248-251 (r = 0) and 257-260 (r = 1)."""
        n, l = self.elementCount, self.elementLength
        if c == 1 - r:
            self.matrixM[r][c] = 0 * self.math.one
        if c == r:
            self.matrixM[r][c] = 2 * self.math.one * n
        if c >= 2:
            self.matrixM[r][c] = self._direction(r, c) * (1 + 2 * (n - (c - 1))) * l
        if c == self.columns - 1:
            self.matrixM[r][c] = self._direction(r, c) * l

    def _direction(self, r: int, c: int) -> Num:
        return -self.anglesSin[c - 2] if r == 0 else self.anglesCos[c - 2]

    def _omegaRow(self, r: int, c: int) -> None:
        """Lines 265-267."""
        n, l, cos = self.elementCount, self.elementLength, self.math.cos
        if r == c:
            third = self.math.one / 3
            self.matrixM[r][r] = 2 * l * l * (third + (n + (r - (2 * r - 1))))
        if c > r and c < self.columns - 1:
            angle = self.angles[c - 2] - self.angles[r - 2]
            self.matrixM[r][c] = l * l * cos(angle) * (1 + 2 * (n - (c - 1)))
        if c > r and c == self.columns - 1:
            self.matrixM[r][c] = l * l * cos(self.angles[c - 2] - self.angles[r - 2])

    def assembleMatrixQ(self) -> None:
        """Lines 289-313."""
        n, l = self.elementCount, self.elementLength
        for r in range(self.rows):
            for c in range(self.rows - 2):
                weight = 1 + 2 * (n - (c + 1))
                if r == 0:
                    self.matrixQ[r][c] = l * self.anglesCos[c] * weight
                if r == 1:
                    self.matrixQ[r][c] = l * self.anglesSin[c] * weight
                if r >= 2 and r < self.rows - 1 and c >= r - 2:
                    angle = self.angles[c] - self.angles[r - 2]
                    self.matrixQ[r][c] = l * l * self.math.sin(angle) * weight
        # generating the other antisymmetric half
        for r in range(2, self.rows):
            for c in range(self.rows - 2):
                if r - 2 != c:
                    self.matrixQ[c + 2][r - 2] = -self.matrixQ[r][c]

    def assembleMatrixK(self) -> None:
        """Lines 316-341."""
        self._fillBand(self.matrixK)

    def assembleMatrixC(self) -> None:
        """Lines 344-369."""
        self._fillBand(self.matrixC)

    def _fillBand(self, matrix: JavaArray) -> None:
        """Lines 318-340 and 346-368, which differ in nothing but the name of the matrix."""
        one = self.math.one
        for r in range(2, self.rows):
            for c in range(self.elementCount):
                if r == 2:
                    if c == 0:
                        matrix[r][c] = one
                    if c == 1:
                        matrix[r][c] = -one
                if r > 2 and r < self.rows - 1:
                    if c == r - 3:
                        matrix[r][c] = -one
                    if c == r - 2:
                        matrix[r][c] = 2 * one
                    if c == r - 1:
                        matrix[r][c] = -one
                if r == self.rows - 1:
                    if c == r - 3:
                        matrix[r][c] = -one
                    if c == r - 2:
                        matrix[r][c] = one

    # Loads ---------------------------------------------------------------------------------------

    def kitFollower(self) -> list[Num]:
        """Lines 424-443: kitFollowerX + kitFollowerY."""
        n, length = self.elementCount, self.elementLength
        angle = self.angles[n - 1] + self.followerAngle
        followerForceX = self.followerForce * self.math.cos(angle)
        followerForceY = self.followerForce * self.math.sin(angle)
        kit = [0 * self.math.one] * (n + 2)
        for r in range(n + 2):
            if r == 0:
                kit[r] += -followerForceX
            if r > 1:
                kit[r] += followerForceX * length * self.anglesSin[r - 2]
        for r in range(n + 2):
            if r == 1:
                kit[r] += -followerForceY
            if r > 1:
                kit[r] += -followerForceY * length * self.anglesCos[r - 2]
        return kit

    def kitGravity(self) -> list[Num]:
        """Lines 446-489: kitGravityOverall; the moments of forces along x are zero."""
        n, half = self.elementCount, self.math.one / 2
        g, m, length = self.gravityAcceleration, self.elementMass, self.elementLength
        kit = [0 * self.math.one] * (n + 2)
        for r in range(n + 2):
            if r > 1:
                kit[r] += -m * g * length * self.anglesCos[r - 2] * (n - half - (r - 2))
        for r in range(n + 2):
            if r == 0:
                kit[r] += 0
            if r == 1:
                kit[r] += -self.mass * g
        return kit

    def velocityAngle(self, i: int) -> None:
        """Lines 495-503."""
        vx, vy = self.velocities[2 * i], self.velocities[2 * i + 1]
        atan, PI = self.math.atan, self.math.PI
        half = self.math.one / 2
        if vx > 0 and vy > 0:
            self.velocityAngles[i] = atan(vy / vx)
        if vx < 0 and vy > 0:
            self.velocityAngles[i] = PI - atan(-vy / vx)
        if vx < 0 and vy < 0:
            self.velocityAngles[i] = -PI + atan(-vy / -vx)
        if vx > 0 and vy < 0:
            self.velocityAngles[i] = -atan(vy / -vx)
        if vx == 0 and vy > 0:
            self.velocityAngles[i] = half * PI
        if vx == 0 and vy < 0:
            self.velocityAngles[i] = -half * PI
        if vx > 0 and vy == 0:
            self.velocityAngles[i] = 0 * self.math.one
        if vx < 0 and vy == 0:
            self.velocityAngles[i] = PI

    def aeroDamping(self, i: int, mean: Mean = MEAN) -> None:
        """Lines 505-511."""
        n, angles, angle = self.elementCount, self.angles, self.velocityAngles[i]
        if i == 0:
            self.aeroDampingCoef[i] = abs(self.math.sin(abs(angle - angles[i])))
        if i == n:
            self.aeroDampingCoef[i] = abs(self.math.sin(abs(angle - angles[i - 1])))
        if i != 0 and i != n:
            self.aeroDampingCoef[i] = abs(self.math.sin(mean(angle, angles[i - 1], angles[i])))

    def dampingForces(self) -> None:
        """Lines 514-529, both loops."""
        for at, forces in enumerate((self.dampingForcesX, self.dampingForcesY)):
            for s in range(self.elementCount + 1):
                forces[s] = -self._dampingCoefficient(s) * self.velocities[s * 2 + at]

    def _dampingCoefficient(self, s: int) -> Num:
        """Lines 517-519 and 525-527 but for the velocity."""
        c, a, half = self.exterDampingCoef, self.aeroDampingCoef[s], self.math.one / 2
        medium = self.mediumDampingCoef
        if s == 0:
            return c * (self.spikeDampingCoef * medium * a) * half * self.elementMass
        if s < self.elementCount:
            return c * (medium * a) * self.elementMass
        return c * (self.tailDampingCoef * medium * a) * half * self.elementMass

    def kitExtDamping(self) -> list[Num]:
        """Lines 531-584: kitExtDampingOverall."""
        n, X, Y = self.elementCount, self.dampingForcesX, self.dampingForcesY
        overall = [sum(X), sum(Y)]
        for r in range(2, n + 2):
            valueX = sum(X[i] for i in range(r - 1, n + 1))
            valueY = sum(Y[i] for i in range(r - 1, n + 1))
            Xmoment = self.elementLength * self.anglesSin[r - 2] * valueX
            Ymoment = self.elementLength * self.anglesCos[r - 2] * valueY
            overall.append(-Xmoment + Ymoment)
        return overall

    def externalDamping(self) -> list[Num]:
        """Lines 493-584."""
        for i in range(self.elementCount + 1):
            self.velocityAngle(i)
            self.aeroDamping(i)
        self.dampingForces()
        return self.kitExtDamping()

    # The equation --------------------------------------------------------------------------------

    def createEquation(self) -> None:
        """Lines 373-606."""
        half, m = self.math.one / 2, self.elementMass
        self.leftSide = [[half * m * e for e in row] for row in self.matrixM]
        QtimesOmegaSq = _multiply(self.matrixQ, half * m, [w * w for w in self.omegas])
        KtimesFi = _multiply(self.matrixK, self.elementStiffness, self.angles)
        CtimesOmega = _multiply(self.matrixC, self.innerDampingCoef * m, self.omegas)
        follower, gravity, external = self.kitFollower(), self.kitGravity(), self.externalDamping()
        self.rightSide = [
            QtimesOmegaSq[r] - KtimesFi[r] - CtimesOmega[r] + follower[r] + gravity[r] + external[r]
            for r in range(self.elementCount + 2)
        ]

    def getSolution(self) -> None:
        """Lines 607-614, in floats."""
        self.solution = np.linalg.solve(np.array(self.leftSide), np.array(self.rightSide)).tolist()


def _multiply(matrix: Sequence[Sequence[Num]], factor: Num, vector: Sequence[Num]) -> list[Num]:
    return [sum(factor * a * b for a, b in zip(row, vector, strict=True)) for row in matrix]
