"""The listing's equation, lines 372-614: loads, right side and solution, and their claims."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from sympy import Expr

from .claim import Claim
from .java_damping import externalDamping, kitExtDamping
from .java_matrices import assembleMatrixC, assembleMatrixK, assembleMatrixM, assembleMatrixQ
from .java_members import Array, FreeRodModel, Num, symbolic
from .java_truth import right_side
from .truth import D_x, D_y, truth


def kitFollower(it: FreeRodModel) -> list[Num]:
    """Lines 424-443: kitFollowerX + kitFollowerY."""
    n, length = it.elementCount, it.elementLength
    angle = it.angles[n - 1] + it.followerAngle
    followerForceX = it.followerForce * it.math.cos(angle)
    followerForceY = it.followerForce * it.math.sin(angle)
    kit = [0 * it.math.one] * (n + 2)
    for r in range(n + 2):
        if r == 0:
            kit[r] += -followerForceX
        if r > 1:
            kit[r] += followerForceX * length * it.anglesSin[r - 2]
    for r in range(n + 2):
        if r == 1:
            kit[r] += -followerForceY
        if r > 1:
            kit[r] += -followerForceY * length * it.anglesCos[r - 2]
    return kit


def kitGravity(it: FreeRodModel) -> list[Num]:
    """Lines 446-489: kitGravityOverall; the moments of forces along x are zero."""
    n, half = it.elementCount, it.math.one / 2
    g, m, length = it.gravityAcceleration, it.elementMass, it.elementLength
    kit = [0 * it.math.one] * (n + 2)
    for r in range(n + 2):
        if r > 1:
            kit[r] += -m * g * length * it.anglesCos[r - 2] * (n - half - (r - 2))
    for r in range(n + 2):
        if r == 0:
            kit[r] += 0
        if r == 1:
            kit[r] += -it.mass * g
    return kit


def createEquation(
    it: FreeRodModel, damping: Callable[[FreeRodModel], list[Num]] = externalDamping
) -> None:
    """Lines 373-606."""
    half, m = it.math.one / 2, it.elementMass
    it.leftSide = [[half * m * e for e in row] for row in it.matrixM]
    QtimesOmegaSq = _multiply(it.matrixQ, half * m, [w * w for w in it.omegas])
    KtimesFi = _multiply(it.matrixK, it.elementStiffness, it.angles)
    CtimesOmega = _multiply(it.matrixC, it.innerDampingCoef * m, it.omegas)
    follower, gravity, external = kitFollower(it), kitGravity(it), damping(it)
    it.rightSide = [
        QtimesOmegaSq[r] - KtimesFi[r] - CtimesOmega[r] + follower[r] + gravity[r] + external[r]
        for r in range(it.elementCount + 2)
    ]


def _multiply(matrix: Sequence[Sequence[Num]], factor: Num, vector: Sequence[Num]) -> list[Num]:
    return [sum(factor * a * b for a, b in zip(row, vector, strict=True)) for row in matrix]


def getSolution(it: FreeRodModel) -> None:
    """Lines 607-614, in floats; the Gauss elimination is of a library that is not printed."""
    it.solution = np.linalg.solve(np.array(it.leftSide), np.array(it.rightSide)).tolist()


# Claims --------------------------------------------------------------------------------------


def _row(n: int, at: int) -> str:
    return ("row of x0", "row of y0")[at] if at < 2 else f"row of phi_{at - 2}"


def symbolic_damping(it: FreeRodModel) -> list[Num]:
    """The effect of forces -D_x, -D_y at the joints."""
    joints = it.elementCount + 1
    it.dampingForcesX = Array(-f for f in D_x[:joints])
    it.dampingForcesY = Array(-f for f in D_y[:joints])
    return kitExtDamping(it)


def _right_side(n: int) -> list[Expr]:
    it = symbolic(n)
    for assemble in (assembleMatrixM, assembleMatrixQ, assembleMatrixK, assembleMatrixC):
        assemble(it)
    createEquation(it, symbolic_damping)
    return it.rightSide


CLAIMS = (
    Claim(
        "Java 424-443",
        "follower force",
        {"as printed": lambda n: kitFollower(symbolic(n))},
        lambda n: truth(n).F,
        repairs=("lines 429 and 439, comments: the digit 1 is the letter l",),
        note="A thrust at the tail that compresses for a positive force, as the text describes it.",
        printed="kitFollowerX.addValue(0, -followerForceX); "
        "kitFollowerX.addValue(r, followerForceX*elementLength*anglesSin[r-2]);",
        label=_row,
    ),
    Claim(
        "Java 446-489",
        "gravity",
        {"as printed": lambda n: kitGravity(symbolic(n))},
        lambda n: truth(n).A,
        note="Downwards for a positive acceleration in every row.",
        printed="-elementMass*gravityAcceleration*elementLength*anglesCos[r-2]*"
        "(elementCount-0.5-(r-2)); -mass*gravityAcceleration",
        label=_row,
    ),
    Claim(
        "Java 586-604",
        "right side, two links or more",
        {"as printed": _right_side},
        right_side,
        links=range(2, 7),
        note="The external damping by the forces at the joints. One link has the spring and the "
        "damper that K and C give it.",
        printed="QtimesOmegaSq-KtimesFi-CtimesOmega+kitFollowerX+kitFollowerY+kitGravityOverall"
        "+kitExtDampingOverall",
        label=_row,
    ),
)
