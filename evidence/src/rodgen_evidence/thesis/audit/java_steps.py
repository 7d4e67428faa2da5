"""The listing's steppers, lines 705-1002 (section 4.1), call by call.

A stepper calls the other methods by their names, so that what a name stands for can be told apart
from the order in which the names are called.
"""

from __future__ import annotations

from collections.abc import Sequence

from rodgen_evidence.thesis.audit.java_equation import FreeRodModel
from rodgen_evidence.thesis.audit.java_object import JavaArray, Num

Names = Sequence[str]

MATRICES = ("assembleMatrixM", "assembleMatrixQ", "assembleMatrixK")
EVALUATE_C = (*MATRICES, "assembleMatrixC", "createEquation", "getSolution")
EVALUATE_D = (*MATRICES, "assembleMatrixD", "createEquation", "getSolution")
ENERGIES = ("updateKineticEnergy", "updatePotentialEnergy", "updateOverallEnergy")
FINISH = ("updateCG", *ENERGIES, "updateTime")
MOVE_EULER = ("updateAngles", "updateCoords", "updateOmegas", "updateVelocities")
MOVE = ("updateOmegas", "updateVelocities", "updateAngles", "updateCoords")
# Put right: the joints' velocities follow from the new angles, not from the old ones.
MOVE_FRESH = ("updateOmegas", "updateAngles", "updateVelocities", "updateCoords")


def stepEuler(it: FreeRodModel) -> None:
    """Lines 706-730."""
    it.call(*EVALUATE_D, *MOVE_EULER, *FINISH)


def stepImprovedEuler(it: FreeRodModel, move: Names = MOVE) -> None:
    """Lines 748-772."""
    it.call(*EVALUATE_D, *move, *FINISH)


def stepRungeKutta(it: FreeRodModel, move: Names = MOVE, copies: bool = False) -> None:
    """Lines 801-1002. The passages for k2, k3 and k4 (843-966) differ in the factor and in the
    spelling of updateOmegas alone. copies: the reading in which allocateFor copies the vector that
    it is given, to which addValue then adds it once more."""
    T = Saved(it)
    # k1; the move of lines 830-834 is undone in lines 850-859, all but the sines and cosines.
    it.call(*EVALUATE_C, *move)
    K = [_store(it.solution, copies)]
    for divisor, spelling in ((2, "updateOmegas"), (2, "updateOmeegas"), (1, "updateOmeegas")):
        it.solution = [k / divisor for k in K[-1]]
        T.restore(it)
        it.call(spelling, *move[1:], *EVALUATE_C)
        K.append(_store(it.solution, copies))
    it.solution = [(k1 + 2 * k2 + 2 * k3 + k4) / 6 for k1, k2, k3, k4 in zip(*K, strict=True)]
    T.restore(it)
    it.call(*move, *FINISH)


def _store(solution: Sequence[Num], copies: bool) -> list[Num]:
    """Store a solution as lines 836-841 do: allocateFor, then addValue of every value."""
    return [value + (value if copies else 0) for value in solution]


class Saved:
    """xi(t): lines 808-818."""

    def __init__(self, it: FreeRodModel):
        self.angles, self.omegas = it.angles.copy(), it.omegas.copy()
        self.coordinates, self.velocities = it.coordinates.copy(), it.velocities.copy()

    def restore(self, it: FreeRodModel) -> None:
        """Lines 850-859, 892-901, 934-943, 978-987: neither anglesSin nor anglesCos."""
        it.angles, it.omegas = JavaArray(self.angles), JavaArray(self.omegas)
        it.coordinates, it.velocities = JavaArray(self.coordinates), JavaArray(self.velocities)


# Put right -----------------------------------------------------------------------------------


def complete(it: FreeRodModel) -> None:
    """Sines, cosines, and the joints' coordinates and velocities, of the angles and omegas as they
    are: the updates with a step of no length."""
    step, it.step = it.step, 0 * it.step
    it.solution = [it.step] * (it.elementCount + 2)
    it.call(*MOVE_FRESH)
    it.step = step


def stepClassical(it: FreeRodModel) -> None:
    """stepRungeKutta put right, (1.85): every stage has its own rates of angles and coordinates,
    and moves them by those, not by velocities that are updated already."""
    T, rates = Saved(it), []
    for factor in (it.math.one / 2, it.math.one / 2, it.math.one):
        rates.append(_rates(it))
        _move(it, T, rates[-1], factor)
    rates.append(_rates(it))
    mean = [(k1 + 2 * k2 + 2 * k3 + k4) / 6 for k1, k2, k3, k4 in zip(*rates, strict=True)]
    _move(it, T, mean, it.math.one)
    it.call(*FINISH)


def _rates(it: FreeRodModel) -> list[Num]:
    """Rates of the start of the rod, of the angles, of the start's velocity and of the omegas."""
    it.call(*EVALUATE_C)
    return [it.velocities[0], it.velocities[1], *it.omegas, *it.solution]


def _move(it: FreeRodModel, T: Saved, rates: list[Num], factor: Num) -> None:
    n, h = it.elementCount, factor * it.step
    T.restore(it)
    for i in range(2):
        it.coordinates[i] += h * rates[i]
        it.velocities[i] += h * rates[n + 2 + i]
    for i in range(n):
        it.angles[i] += h * rates[2 + i]
        it.omegas[i] += h * rates[n + 4 + i]
    complete(it)
