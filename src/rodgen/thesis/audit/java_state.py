"""The claims of the listing's members and of its initial state, lines 13-118."""

from __future__ import annotations

from sympy import Expr, S, Symbol

from rodgen.derive.symbols import k, l, m, x0, y0

from .claim import NOT_PRINTED, Claim, Entries
from .java_members import Array, FreeRodModel, setSymbols, symbolic
from .java_motion import updateCoords, updateVelocities
from .java_truth import H, joint_velocities, joints
from .truth import omega, phi

NAN = Symbol("NaN")  # Java's 0.0/0, as a letter that no truth has


def _members(printed: bool) -> Entries:
    """Lengths of the arrays, and the values of an element."""

    def entries(n: int) -> list[Expr]:
        it = symbolic(n, printed)
        lengths = [len(it.angles), len(it.coordinates), len(it.matrixM), len(it.dampingForcesX)]
        values = [it.elementMass, it.elementLength, it.elementStiffness]
        return [*map(S, lengths), *(NAN if value is S.NaN else value for value in values)]

    return entries


def _state(quantity: str) -> Entries:
    """What setInitialState has written into a member, and what it has not."""

    def entries(n: int) -> list[Expr]:
        it = FreeRodModel(n, H)
        setattr(it, quantity, Array([NOT_PRINTED] * len(getattr(it, quantity))))
        setSymbols(it)
        return list(getattr(it, quantity))

    return entries


def _completed(quantity: str) -> Entries:
    """After the joints' coordinates and velocities are updated with a step of no length."""

    def entries(n: int) -> list[Expr]:
        it: FreeRodModel = symbolic(n)
        it.step, it.solution = S.Zero, [S.Zero] * (n + 2)
        updateVelocities(it)
        updateCoords(it)
        return list(getattr(it, quantity))

    return entries


def _joints_from_origin(n: int) -> list[Expr]:
    return [q.xreplace({x0: S.Zero, y0: S.Zero}) for q in joints(n)]


def _joint(n: int, at: int) -> str:
    return f"{'xy'[at % 2]} of joint {at // 2}"


_COMPLETION = "updateVelocities(); updateCoords(); with step=0 at the end of setInitialState"

CLAIMS = (
    Claim(
        "Java 27-77",
        "members that depend on the number of links and on the rod",
        {"as printed": _members(printed=True)},
        lambda n: [*map(S, (n, 2 * n + 2, n + 2, n + 1)), m, l, k],
        corrected=_members(printed=False),
        note="Java runs these initialisers before the constructor's body: the number of links is "
        "still 0, 0.0/0 is not a number, and the arrays have the lengths of a rod without links. "
        "As printed the program stops in line 251, at the index -1: its only columns are 0 and 1, "
        "and for the last one it asks for the sine of link c-2. Hypothesis: the constructor was "
        "shortened for print.",
        printed="double elementMass=mass/elementCount; double[] angles=new double[elementCount];",
        correction="lines 52-77 at the end of the constructor, 27-29 at that of setInitialState",
    ),
    Claim(
        "Java 85-111, angles",
        "initial angles and angular velocities",
        {"as printed": lambda n: [*_state("angles")(n), *_state("omegas")(n)]},
        lambda n: [*phi[:n], *omega[:n]],
        printed="omegas[i]=omegasInit[i]; angles[i]=anglesInit[i];",
    ),
    Claim(
        "Java 85-111, velocities",
        "initial velocities of the joints",
        {"as printed": _state("velocities")},
        joint_velocities,
        corrected=_completed("velocities"),
        note="Those behind the start keep Java's zero, and the first evaluation of external "
        "damping reads it.",
        label=_joint,
        printed="velocities[0]=vx0Init; velocities[1]=vy0Init;",
        correction=_COMPLETION,
    ),
    Claim(
        "Java 85-111, coordinates",
        "initial coordinates of the joints, the start at the origin",
        {"as printed": _state("coordinates")},
        _joints_from_origin,
        corrected=_completed("coordinates"),
        note="They keep Java's zero until the first step. No force depends on them.",
        label=_joint,
        correction=_COMPLETION,
    ),
)
