"""The listing's external damping, lines 493-584, case by case, and its claims."""

from __future__ import annotations

from collections.abc import Callable

from .java_members import FreeRodModel, Num


def velocityAngle(it: FreeRodModel, i: int) -> None:
    """Lines 495-503."""
    vx, vy = it.velocities[2 * i], it.velocities[2 * i + 1]
    atan, PI = it.math.atan, it.math.PI
    half = it.math.one / 2
    if vx > 0 and vy > 0:
        it.velocityAngles[i] = atan(vy / vx)
    if vx < 0 and vy > 0:
        it.velocityAngles[i] = PI - atan(-vy / vx)
    if vx < 0 and vy < 0:
        it.velocityAngles[i] = -PI + atan(-vy / -vx)
    if vx > 0 and vy < 0:
        it.velocityAngles[i] = -atan(vy / -vx)
    if vx == 0 and vy > 0:
        it.velocityAngles[i] = half * PI
    if vx == 0 and vy < 0:
        it.velocityAngles[i] = -half * PI
    if vx > 0 and vy == 0:
        it.velocityAngles[i] = 0 * it.math.one
    if vx < 0 and vy == 0:
        it.velocityAngles[i] = PI


# The argument of line 511 before the sine, from the angles of velocity and of the two links.
Mean = Callable[[Num, Num, Num], Num]


def MEAN(velocity: Num, before: Num, after: Num) -> Num:
    """Line 511 with the missing parenthesis opened at the break of the line, after the minus."""
    return abs(velocity - (before + after) / 2)


def WITHOUT(velocity: Num, before: Num, after: Num) -> Num:
    """Line 511 with the last parenthesis dropped."""
    return abs(velocity - before + after) / 2


def aeroDamping(it: FreeRodModel, i: int, mean: Mean = MEAN) -> None:
    """Lines 505-511."""
    n, angles, angle = it.elementCount, it.angles, it.velocityAngles[i]
    if i == 0:
        it.aeroDampingCoef[i] = abs(it.math.sin(abs(angle - angles[i])))
    if i == n:
        it.aeroDampingCoef[i] = abs(it.math.sin(abs(angle - angles[i - 1])))
    if i != 0 and i != n:
        it.aeroDampingCoef[i] = abs(it.math.sin(mean(angle, angles[i - 1], angles[i])))


def dampingForces(it: FreeRodModel) -> None:
    """Lines 514-529, both loops."""
    for at, forces in enumerate((it.dampingForcesX, it.dampingForcesY)):
        for s in range(it.elementCount + 1):
            forces[s] = -_dampingCoefficient(it, s) * it.velocities[s * 2 + at]


def _dampingCoefficient(it: FreeRodModel, s: int) -> Num:
    """Lines 517-519 and 525-527 but for the velocity."""
    c, a, half = it.exterDampingCoef, it.aeroDampingCoef[s], it.math.one / 2
    medium = it.mediumDampingCoef
    if s == 0:
        return c * (it.spikeDampingCoef * medium * a) * half * it.elementMass
    if s < it.elementCount:
        return c * (medium * a) * it.elementMass
    return c * (it.tailDampingCoef * medium * a) * half * it.elementMass


def kitExtDamping(it: FreeRodModel) -> list[Num]:
    """Lines 531-584: kitExtDampingOverall."""
    n, X, Y = it.elementCount, it.dampingForcesX, it.dampingForcesY
    overall = [sum(X), sum(Y)]
    for r in range(2, n + 2):
        valueX = sum(X[i] for i in range(r - 1, n + 1))
        valueY = sum(Y[i] for i in range(r - 1, n + 1))
        Xmoment = it.elementLength * it.anglesSin[r - 2] * valueX
        Ymoment = it.elementLength * it.anglesCos[r - 2] * valueY
        overall.append(-Xmoment + Ymoment)
    return overall


def externalDamping(it: FreeRodModel) -> list[Num]:
    """Lines 493-584."""
    for i in range(it.elementCount + 1):
        velocityAngle(it, i)
        aeroDamping(it, i)
    dampingForces(it)
    return kitExtDamping(it)
