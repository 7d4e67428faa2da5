"""The listing's updates of the motion, lines 120-186, statement by statement, and their claims."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from sympy import Expr, S

from rodgen.derive.symbols import vx0, vy0, x0, y0

from .claim import Claim, Entries
from .java_members import Array, FreeRodModel, symbolic
from .java_truth import H, centre, indexed, joint_velocities, joints
from .truth import omega, phi


def updateTime(it: FreeRodModel) -> None:
    """Line 123."""
    it.time += it.step


def updateOmegas(it: FreeRodModel) -> None:
    """Lines 129-132; solution.getValue(i) is solution[i]."""
    for i in range(len(it.omegas)):
        it.omegas[i] += it.step * it.solution[i + 2]


def updateAngles(it: FreeRodModel) -> None:
    """Lines 138-144."""
    for i in range(len(it.angles)):
        it.angles[i] += it.step * it.omegas[i]
    for i in range(len(it.anglesSin)):
        it.anglesSin[i] = it.math.sin(it.angles[i])
    for i in range(len(it.anglesCos)):
        it.anglesCos[i] = it.math.cos(it.angles[i])


def updateCoords(it: FreeRodModel) -> None:
    """Lines 151-156."""
    for i in range(len(it.coordinates)):
        if i < 2:
            it.coordinates[i] += it.step * it.velocities[i]
        elif i % 2 == 0:  # x
            at = i - i // 2 - 1
            it.coordinates[i] = it.coordinates[i - 2] + it.elementLength * it.anglesCos[at]
        elif i % 2 != 0:  # y
            at = i - i // 2 - 2
            it.coordinates[i] = it.coordinates[i - 2] + it.elementLength * it.anglesSin[at]


def updateVelocities(it: FreeRodModel) -> None:
    """Lines 163-169."""
    l = it.elementLength
    for i in range(2):
        it.velocities[i] += it.step * it.solution[i]
    for i in range(2, len(it.velocities)):
        if i % 2 == 0:  # x
            at = i - i // 2 - 1
            it.velocities[i] = it.velocities[i - 2] - it.omegas[at] * l * it.anglesSin[at]
        elif i % 2 != 0:  # y
            at = i - i // 2 - 2
            it.velocities[i] = it.velocities[i - 2] + it.omegas[at] * l * it.anglesCos[at]


def updateCG(it: FreeRodModel) -> None:
    """Lines 177-185."""
    length = len(it.coordinates)
    topX = it.coordinates[0] + it.coordinates[length - 2]
    for i in range(2, length - 2, 2):
        topX += 2 * it.coordinates[i]
    it.centerOfGravity[0] = topX / (2 * it.elementCount)
    topY = it.coordinates[1] + it.coordinates[length - 1]
    for i in range(3, length - 1, 2):
        topY += 2 * it.coordinates[i]
    it.centerOfGravity[1] = topY / (2 * it.elementCount)


# Claims --------------------------------------------------------------------------------------


def _after(method: Callable[[FreeRodModel], None], quantity: str) -> Entries:
    """A member after one method, the start of the rod at x_0, y_0 and accelerations a_i."""

    def entries(n: int) -> list[Expr]:
        it = symbolic(n)
        it.coordinates[0], it.coordinates[1] = x0, y0
        it.solution = indexed("a", n + 2)
        method(it)
        return list(getattr(it, quantity))

    return entries


def _moved(values: Sequence[Expr], rates: Sequence[Expr]) -> list[Expr]:
    return [q + H * u for q, u in zip(values, rates, strict=True)]


def _joints_moved(n: int) -> list[Expr]:
    """Joints of the rod whose start has moved by h v_0."""
    start = {x0: x0 + H * vx0, y0: y0 + H * vy0}
    return [q.xreplace(start) for q in joints(n)]


def _velocities_moved(n: int) -> list[Expr]:
    """Velocities of the joints when the start is faster by h a; omegas are as they are."""
    a = indexed("a", n + 2)
    return [q.xreplace({vx0: vx0 + H * a[0], vy0: vy0 + H * a[1]}) for q in joint_velocities(n)]


def _gravity_centre(n: int) -> list[Expr]:
    it = symbolic(n)
    it.coordinates = Array(joints(n))
    updateCG(it)
    return list(it.centerOfGravity)


CLAIMS = (
    Claim(
        "Java 126-133",
        "new angular velocities",
        {"as printed": _after(updateOmegas, "omegas")},
        lambda n: _moved(omega[:n], indexed("a", n + 2)[2:]),
        printed="omegas[i]+=step*solution.getValue(i+2);",
    ),
    Claim(
        "Java 135-146",
        "new angles",
        {"as printed": _after(updateAngles, "angles")},
        lambda n: _moved(phi[:n], omega[:n]),
        printed="angles[i]+=step*omegas[i];",
    ),
    Claim(
        "Java 148-157",
        "coordinates of the joints",
        {"as printed": _after(updateCoords, "coordinates")},
        _joints_moved,
        note="The indices i-i/2-1 and i-i/2-2 are both those of the link that ends in the joint: "
        "the division is one of integers.",
        printed="coordinates[i]=coordinates[i-2]+elementLength*anglesCos[(i-i/2-1)];",
    ),
    Claim(
        "Java 159-170",
        "velocities of the joints",
        {"as printed": _after(updateVelocities, "velocities")},
        _velocities_moved,
        note="Right for the sines and cosines that it finds: see the steppers for which these are.",
        printed="velocities[i]=velocities[i-2]-omegas[(i-i/2-1)]*elementLength*anglesSin[...];",
    ),
    Claim(
        "Java 172-186",
        "centre of gravity",
        {"as printed": _gravity_centre},
        centre,
        note="Half the mass of a link at each of its ends has the centre of gravity of the link.",
        printed="topX=coordinates[0]+coordinates[length-2]; topX+=2*coordinates[i]; "
        "centerOfGravity[0]=topX/(2*elementCount);",
    ),
    Claim(
        "Java 120-124",
        "time",
        {"as printed": lambda n: [_time(n)]},
        lambda n: [H],
        links=(1,),
        printed="time+=step;",
    ),
)


def _time(n: int) -> Expr:
    it = symbolic(n)
    updateTime(it)
    return S(it.time)
