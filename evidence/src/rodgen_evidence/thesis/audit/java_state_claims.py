"""The claims of the listing's members, motion and energies, lines 13-232."""

from __future__ import annotations

from sympy import Expr, S, Symbol

from rodgen.derive.symbols import k, l, m, vx0, vy0, x0, y0
from rodgen_evidence.thesis.audit.claim import NOT_PRINTED, READ, Claim, Entries
from rodgen_evidence.thesis.audit.java_letters import (
    H,
    Symbolic,
    centre,
    gravity_energy,
    indexed_symbols,
    joint_velocities,
    joints,
    listing,
)
from rodgen_evidence.thesis.audit.java_object import JavaArray
from rodgen_evidence.thesis.audit.java_steps import ENERGIES
from rodgen_evidence.thesis.audit.truth import Column, omega, phi, truth

NAN = Symbol("NaN")  # Java's 0.0/0, as a letter that no truth has


def _members(printed: bool) -> Entries:
    """Lengths of the arrays, and the values of an element."""

    def entries(n: int) -> Column:
        it = Symbolic(n, printed)
        lengths = [len(it.angles), len(it.coordinates), len(it.matrixM), len(it.dampingForcesX)]
        values = [it.elementMass, it.elementLength, it.elementStiffness]
        return [*map(S, lengths), *(NAN if value is S.NaN else value for value in values)]

    return entries


def _initial(*quantities: str) -> Entries:
    """Entries that setInitialState has written into members, and those that it has not."""

    def entries(n: int) -> Column:
        it = Symbolic(n)
        for quantity in quantities:
            setattr(it, quantity, JavaArray([NOT_PRINTED] * len(getattr(it, quantity))))
        it.setLetters()
        return [entry for quantity in quantities for entry in getattr(it, quantity)]

    return entries


def _after_update(quantity: str) -> Entries:
    """Entries after the joints' coordinates and velocities are updated with a step of no length."""
    return listing(
        "updateVelocities",
        "updateCoords",
        read=quantity,
        step=lambda n: S.Zero,
        solution=lambda n: [S.Zero] * (n + 2),
    )


def _start(n: int) -> Column:
    """Coordinates of the joints, of which the first alone is given."""
    return [x0, y0, *[S.Zero] * (2 * n)]


def _after(method: str, quantity: str) -> Entries:
    """A member after one method, the start of the rod at x_0, y_0 and accelerations a_i."""
    return listing(method, read=quantity, coordinates=_start, solution=_accelerations)


def _accelerations(n: int) -> Column:
    return indexed_symbols("a", n + 2)


def _euler_step(values: tuple[Expr, ...], rates: tuple[Expr, ...] | Column) -> Column:
    return [q + H * u for q, u in zip(values, rates, strict=True)]


def _velocities_after_step(n: int) -> Column:
    """Velocities of the joints when the start is faster by h a; omegas are as they are."""
    a = _accelerations(n)
    return [q.xreplace({vx0: vx0 + H * a[0], vy0: vy0 + H * a[1]}) for q in joint_velocities(n)]


def _joints_from(x: Expr, y: Expr) -> Entries:
    """Coordinates of the joints of a rod that starts there."""
    return lambda n: [q.xreplace({x0: x, y0: y}) for q in joints(n)]


def _overall_with_weight(n: int) -> Column:
    """The weight of the rod times the height of its centre of gravity added."""
    it = Symbolic(n, coordinates=joints)
    it.call(*ENERGIES, "updateCG")
    return [it.overallEnergy + it.mass * it.gravityAcceleration * it.centerOfGravity[1]]


def _joint(n: int, at: int) -> str:
    return f"{'xy'[at % 2]} of joint {at // 2}"


_COMPLETION = "updateVelocities(); updateCoords(); with step=0 at the end of setInitialState"

CLAIMS = (
    Claim(
        "Java 27-77",
        "members that depend on the number of links and on the rod",
        {READ: _members(printed=True)},
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
        {READ: _initial("angles", "omegas")},
        lambda n: [*phi[:n], *omega[:n]],
        printed="omegas[i]=omegasInit[i]; angles[i]=anglesInit[i];",
    ),
    Claim(
        "Java 85-111, velocities",
        "initial velocities of the joints",
        {READ: _initial("velocities")},
        joint_velocities,
        corrected=_after_update("velocities"),
        note=(
            "The velocities of the other joints keep Java's zero, and the first evaluation of "
            "external damping reads it."
        ),
        label=_joint,
        printed="velocities[0]=vx0Init; velocities[1]=vy0Init;",
        correction=_COMPLETION,
    ),
    Claim(
        "Java 85-111, coordinates",
        "initial coordinates of the joints, the start at the origin",
        {READ: _initial("coordinates")},
        _joints_from(S.Zero, S.Zero),
        corrected=_after_update("coordinates"),
        note="They keep Java's zero until the first step. No force depends on them.",
        label=_joint,
        correction=_COMPLETION,
    ),
    Claim(
        "Java 126-133",
        "new angular velocities",
        {READ: _after("updateOmegas", "omegas")},
        lambda n: _euler_step(omega[:n], _accelerations(n)[2:]),
        printed="omegas[i]+=step*solution.getValue(i+2);",
    ),
    Claim(
        "Java 135-146",
        "new angles",
        {READ: _after("updateAngles", "angles")},
        lambda n: _euler_step(phi[:n], omega[:n]),
        printed="angles[i]+=step*omegas[i];",
    ),
    Claim(
        "Java 148-157",
        "coordinates of the joints",
        {READ: _after("updateCoords", "coordinates")},
        _joints_from(x0 + H * vx0, y0 + H * vy0),
        note=(
            "The indices i-i/2-1 and i-i/2-2 are both those of the link that ends in the joint, "
            "because the division is one of integers."
        ),
        printed="coordinates[i]=coordinates[i-2]+elementLength*anglesCos[(i-i/2-1)];",
    ),
    Claim(
        "Java 159-170",
        "velocities of the joints",
        {READ: _after("updateVelocities", "velocities")},
        _velocities_after_step,
        note=(
            "It is right for the sines and cosines that it finds. The steppers tell which these "
            "are."
        ),
        printed="velocities[i]=velocities[i-2]-omegas[(i-i/2-1)]*elementLength*anglesSin[...];",
    ),
    Claim(
        "Java 172-186",
        "centre of gravity",
        {READ: listing("updateCG", read="centerOfGravity", coordinates=joints)},
        centre,
        note="Two halves of its mass at its ends have the same centre of gravity as the link.",
        printed="topX=coordinates[0]+coordinates[length-2]; topX+=2*coordinates[i]; "
        "centerOfGravity[0]=topX/(2*elementCount);",
    ),
    Claim(
        "Java 120-124",
        "time",
        {READ: listing("updateTime", read="time")},
        lambda n: [H],
        links=(1,),
        printed="time+=step;",
    ),
    Claim(
        "Java 188-212",
        "kinetic energy",
        {READ: listing("updateKineticEnergy", read="kineticEnergy")},
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
        {READ: listing("updatePotentialEnergy", read="potentialEnergy")},
        lambda n: [truth(n).spring_energy],
        note="It is called potential energy, but leaves out the weight; see the overall energy.",
        printed="potentialEnergy+=(angles[i+1]-angles[i])*(angles[i+1]-angles[i]); "
        "potentialEnergy*=0.5*elementStiffness;",
    ),
    Claim(
        "Java 227-232",
        "overall energy under gravity",
        {READ: listing(*ENERGIES, read="overallEnergy")},
        lambda n: [truth(n).kinetic_energy + truth(n).spring_energy + gravity_energy(n)],
        corrected=_overall_with_weight,
        note="The energy that is shown is not kept by a falling rod.",
        printed="overallEnergy=kineticEnergy+potentialEnergy;",
        correction="overallEnergy = kineticEnergy + potentialEnergy + "
        "mass*gravityAcceleration*centerOfGravity[1]",
    ),
)
