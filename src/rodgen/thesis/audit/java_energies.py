"""The listing's energies, lines 188-232, term by term, and their claims."""

from __future__ import annotations

from collections.abc import Callable

from sympy import Expr

from .claim import Claim
from .java_members import Array, FreeRodModel, symbolic
from .java_motion import updateCG
from .java_truth import gravity_energy, joints
from .truth import truth

Limit = Callable[[int], int]  # what k is compared with in lines 200 and 202, from the index l


def LETTER(l: int) -> int:
    """k<=l, k<l."""
    return l


def updateKineticEnergy(it: FreeRodModel, limit: Limit = LETTER) -> None:
    """Lines 191-210."""
    n, v, w = it.elementCount, it.velocities, it.omegas
    length, third = it.elementLength, it.math.one / 3
    energy = 0 * it.math.one
    energy += n * (v[0] * v[0] + v[1] * v[1])
    for i in range(n):
        energy += w[i] * w[i] * length * length * (third + (n - i - 1))
    for i in range(n):
        energy -= v[0] * w[i] * length * it.anglesSin[i] * (1 + 2 * (n - i - 1))
    for i in range(n):
        energy += v[1] * w[i] * length * it.anglesCos[i] * (1 + 2 * (n - i - 1))
    for i in range(n):
        for l in range(i + 1):
            for k in range(limit(l) + 1):
                if k < limit(l):
                    cosine = it.math.cos(it.angles[l] - it.angles[k])
                    if l == i:
                        energy += length * length * w[k] * w[l] * cosine
                    else:
                        energy += 2 * length * length * w[k] * w[l] * cosine
    it.kineticEnergy = energy * (it.math.one / 2 * it.elementMass)


def updatePotentialEnergy(it: FreeRodModel) -> None:
    """Lines 217-224."""
    energy = 0 * it.math.one
    for i in range(it.elementCount - 1):
        energy += (it.angles[i + 1] - it.angles[i]) * (it.angles[i + 1] - it.angles[i])
    it.potentialEnergy = energy * (it.math.one / 2 * it.elementStiffness)


def updateOverallEnergy(it: FreeRodModel) -> None:
    """Lines 230-231."""
    it.overallEnergy = it.kineticEnergy + it.potentialEnergy


# Claims --------------------------------------------------------------------------------------


def _kinetic(n: int) -> list[Expr]:
    it = symbolic(n)
    updateKineticEnergy(it)
    return [it.kineticEnergy]


def _potential(n: int) -> list[Expr]:
    it = symbolic(n)
    updatePotentialEnergy(it)
    return [it.potentialEnergy]


def _overall(n: int) -> list[Expr]:
    it = symbolic(n)
    updateKineticEnergy(it)
    updatePotentialEnergy(it)
    updateOverallEnergy(it)
    return [it.overallEnergy]


def _overall_with_weight(n: int) -> list[Expr]:
    """The weight of the rod times the height of its centre of gravity added."""
    it = symbolic(n)
    it.coordinates = Array(joints(n))
    updateCG(it)
    return [_overall(n)[0] + it.mass * it.gravityAcceleration * it.centerOfGravity[1]]


CLAIMS = (
    Claim(
        "Java 188-212",
        "kinetic energy",
        {"as printed": _kinetic},
        lambda n: [truth(n).kinetic_energy],
        repairs=(
            "lines 200 and 202: the limit of k reads as the digit 1; taken as the letter l, as "
            "in line 429, where the text has 'Fx*1*sin(fi)' for Fx*l*sin(fi)",
        ),
        note="With the digit a single link would have a moment of inertia of 4/3 m l^2. Compare "
        "(2.17) of the text, which has slips that are not here.",
        printed="for (l=0; l<=i; l++) for (k=0; k<=l; k++) if (k<l) { if (l==i) ... else 2*... }",
    ),
    Claim(
        "Java 214-225",
        "energy of the springs",
        {"as printed": _potential},
        lambda n: [truth(n).spring_energy],
        note="Called potential energy: the weight has none here, see the overall energy.",
        printed="potentialEnergy+=(angles[i+1]-angles[i])*(angles[i+1]-angles[i]); "
        "potentialEnergy*=0.5*elementStiffness;",
    ),
    Claim(
        "Java 227-232",
        "overall energy under gravity",
        {"as printed": _overall},
        lambda n: [truth(n).kinetic_energy + truth(n).spring_energy + gravity_energy(n)],
        corrected=_overall_with_weight,
        note="The energy that is shown is not kept by a falling rod.",
        printed="overallEnergy=kineticEnergy+potentialEnergy;",
        correction="overallEnergy = kineticEnergy + potentialEnergy + "
        "mass*gravityAcceleration*centerOfGravity[1]",
    ),
)
