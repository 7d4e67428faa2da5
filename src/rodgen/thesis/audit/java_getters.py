"""The listing's getters, lines 617-681, and their claims."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from sympy import Expr

from rodgen.derive.symbols import x0, y0

from .claim import Claim
from .java_energies import updatePotentialEnergy
from .java_members import Array, FreeRodModel, Num, symbolic
from .java_motion import updateCG
from .java_steps import complete
from .java_truth import centre, indexed, joint_velocities, joints
from .truth import D_x, D_y, omega, phi, truth

Getter = Callable[[FreeRodModel], Sequence[Num]]

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


def getArray(it: FreeRodModel, name: str) -> Array:
    """One of ARRAYS: the member itself, not a copy."""
    array: Array = getattr(it, ARRAYS[name])
    return array


def getCoordinate(it: FreeRodModel, index: int) -> Num:
    """Lines 617-619."""
    return it.coordinates[index]


def getVelocity(it: FreeRodModel, index: int) -> Num:
    """Lines 621-623."""
    return it.velocities[index]


def getPotentialEnergy(it: FreeRodModel) -> Num:
    """Lines 643-645."""
    return it.potentialEnergy


def getVelocitiesX(it: FreeRodModel) -> list[Num]:
    """Lines 665-672."""
    return [it.velocities[2 * i] for i in range(it.elementCount + 1)]


def getVelocitiesY(it: FreeRodModel) -> list[Num]:
    """Lines 674-681."""
    return [it.velocities[2 * i + 1] for i in range(it.elementCount + 1)]


# Claims --------------------------------------------------------------------------------------


def filled(n: int) -> FreeRodModel:
    """The object with its joints, centre of gravity, energy of the springs and forces as they are
    for the letters of the truth."""
    it = symbolic(n)
    it.coordinates[0], it.coordinates[1] = x0, y0
    complete(it)
    updateCG(it)
    updatePotentialEnergy(it)
    it.aeroDampingCoef = Array(indexed("a", n + 1))
    it.velocityAngles = Array(indexed("varphi_v", n + 1))
    it.dampingForcesX = Array(-f for f in D_x[: n + 1])
    it.dampingForcesY = Array(-f for f in D_y[: n + 1])
    return it


def _plain(n: int) -> list[Expr]:
    it = filled(n)
    by_index = [get(it, at) for get in (getCoordinate, getVelocity) for at in range(2 * n + 2)]
    arrays = [value for name in ARRAYS for value in getArray(it, name)]
    return [*by_index, getPotentialEnergy(it), *arrays]


def _plain_true(n: int) -> list[Expr]:
    by_index = [*joints(n), *joint_velocities(n), truth(n).spring_energy]
    motion = [*joints(n), *phi[:n], *centre(n), *omega[:n]]
    of_joints = [*indexed("a", n + 1), *indexed("varphi_v", n + 1)]
    return [*by_index, *motion, *of_joints, *(-f for f in (*D_x[: n + 1], *D_y[: n + 1]))]


def _velocities(lines: str, axis: int, get: Getter) -> Claim:
    name = "XY"[axis]
    return Claim(
        lines,
        f"velocities of the joints along {name.lower()}",
        {"as printed": lambda n: get(filled(n))},
        lambda n: joint_velocities(n)[axis::2],
        note="An array of its own: a caller may write into it.",
        printed=f"velocities{name}[i]=velocities[2*i{'+1' * axis}];",
        label=lambda n, at: f"joint {at}",
    )


CLAIMS = (
    Claim(
        "Java 617-663",
        "what the other getters hand out",
        {"as printed": _plain},
        _plain_true,
        note="Arrays are handed out themselves: a caller that writes into one changes the motion. "
        "The potential energy is that of the springs.",
        printed="return coordinates[index]; return velocities[index]; return angles; ...",
    ),
    _velocities("Java 665-672", 0, getVelocitiesX),
    _velocities("Java 674-681", 1, getVelocitiesY),
)
