"""The claims of the listing's external damping, lines 493-584."""

from __future__ import annotations

from sympy import Abs, Expr, S, Symbol, atan2, cos, sin, symbols

from rodgen.derive.loads import JointDrag, drag_divisor, drag_force, joint_mass

from .claim import Claim, Entries
from .equations_medium import angles_at, resisting
from .java_damping import (
    MEAN,
    WITHOUT,
    Mean,
    aeroDamping,
    dampingForces,
    externalDamping,
    kitExtDamping,
    velocityAngle,
)
from .java_forces import symbolic_damping
from .java_members import FINS, Array, symbolic
from .java_truth import indexed
from .truth import truth

A, B = symbols("a b", positive=True)
CASES = ((A, B), (-A, B), (-A, -B), (A, -B), (S.Zero, B), (S.Zero, -B), (A, S.Zero), (-A, S.Zero))


def _angles_by_case(n: int) -> list[Expr]:
    it = symbolic(n)
    found = []
    for it.velocities[0], it.velocities[1] in CASES:
        velocityAngle(it, 0)
        found.append(it.velocityAngles[0])
    return found


def _velocity_angles(n: int) -> list[Expr]:
    return indexed("varphi_v", n + 1)


def _coefficients(mean: Mean) -> Entries:
    """Squares of the coefficients, which are not negative: in the square of a sine, the sign of
    the argument has no part, and the absolute values drop out."""

    def entries(n: int) -> list[Expr]:
        it = symbolic(n)
        it.velocityAngles = Array(_velocity_angles(n))
        for i in range(n + 1):
            aeroDamping(it, i, mean)
        return [(a**2).replace(Abs, lambda inner: inner) for a in it.aeroDampingCoef]

    return entries


def _across_squared(n: int) -> list[Expr]:
    """The share of a velocity of length 1 that is across the rod."""
    shares = []
    for angle, of_rod in zip(_velocity_angles(n), angles_at(n), strict=True):
        joint = JointDrag(cos(angle), sin(angle), S.One, of_rod, S.One, S.One)
        (across,) = drag_force(joint)[0].atoms(Abs)
        shares.append(across.args[0] ** 2)
    return shares


def _joint_speeds(n: int) -> list[Expr]:
    x, y = indexed("v_x", n + 1), indexed("v_y", n + 1)
    return [v for pair in zip(x, y, strict=True) for v in pair]


def _forces(closed: str) -> Entries:
    """Forces at the joints, the loop over i closed at one of three places; a_i is what lines
    505-511 give, old_i what was there before."""

    def entries(n: int) -> list[Expr]:
        it = symbolic(n)
        it.velocities = Array(_joint_speeds(n))
        it.aeroDampingCoef = Array(indexed("old", n + 1))
        for i, a in enumerate(indexed("a", n + 1)):
            it.aeroDampingCoef[i] = a
            if closed != "after line 511":
                dampingForces(it)
            if closed == "in line 603":
                kitExtDamping(it)
        if closed == "after line 511":
            dampingForces(it)
        return [*it.dampingForcesX, *it.dampingForcesY]

    return entries


def _forces_true(n: int) -> list[Expr]:
    """By the law of the load: a_i stands for the share across the rod."""
    spike, medium, tail = FINS
    fins = [spike * medium, *[medium] * (n - 1), tail * medium]
    speeds, angle, divisor = _joint_speeds(n), Symbol("angle", real=True), Symbol("divisor")
    x, y = [], []
    for i, (fin, a) in enumerate(zip(fins, indexed("a", n + 1), strict=True)):
        mass = joint_mass(2 if 0 < i < n else 1)
        joint = JointDrag(speeds[2 * i], speeds[2 * i + 1], divisor, angle, mass, fin)
        fx, fy = (-f.replace(Abs, lambda _, a=a: a * divisor) for f in resisting(joint))
        x.append(fx)
        y.append(fy)
    return x + y


def _forces_at_rest(n: int) -> list[Expr]:
    """All velocities zero, the angles of the velocities as they were before."""
    it = symbolic(n)
    it.velocities = it.zeros(2 * n + 2)
    it.velocityAngles = Array(_velocity_angles(n))
    externalDamping(it)
    return [*it.dampingForcesX, *it.dampingForcesY]


def _no_forces(n: int) -> list[Expr]:
    zero = S.Zero
    joint = JointDrag(zero, zero, drag_divisor(zero, zero), S.One, S.One, S.One)
    return [*drag_force(joint)] * (n + 1)


CLAIMS = (
    Claim(
        "Java 495-503",
        "angle of the velocity of a joint",
        {"as printed": _angles_by_case},
        lambda n: [atan2(vy, vx) for vx, vy in CASES],
        links=(1,),
        note="All four quadrants and all four axes are right; Math.atan2 would have done it. "
        "(2.57) of the text has the first and the fourth quadrant only.",
        printed="if (vx<0 && vy<0) velocityAngles[i]=-Math.PI+Math.atan(-vy/-vx); "
        "if (vx>0 && vy<0) velocityAngles[i]=-Math.atan(vy/-vx); ...",
        label=lambda n, at: f"v = ({CASES[at][0]}, {CASES[at][1]})",
    ),
    Claim(
        "Java 495-503, at rest",
        "damping forces at joints without velocity",
        {"as printed": _forces_at_rest},
        _no_forces,
        note="No case of the angle fits, and the old one stays. That is without effect on the "
        "forces; getVelocityAngles and getAeroCoefficients give what is left over.",
        printed="if (vx==0 && vy>0) ...; if (vx==0 && vy<0) ...; if (vx>0 && vy==0) ...; ...",
    ),
    Claim(
        "Java 505-511",
        "share of the velocity across the rod",
        {
            "velocityAngles[i]-(angles[i-1]+angles[i])/2d": _coefficients(MEAN),
            "(velocityAngles[i]-angles[i-1]+angles[i])/2d": _coefficients(WITHOUT),
        },
        _across_squared,
        repairs=(
            "lines 506, 508 and 511 close one parenthesis more than they open; all three are "
            "broken right after a minus, where one may have been lost",
        ),
        note="Compared as squares. As the parentheses stand, the program does not compile. The "
        "first reading is (2.56).",
        printed="aeroDampingCoef[i]=Math.abs(Math.sin(Math.abs("
        "velocityAngles[i]-angles[i-1]+angles[i])/2d)));",
        correction="Math.abs(Math.sin(Math.abs(velocityAngles[i]-(angles[i-1]+angles[i])/2d)))",
    ),
    Claim(
        "Java 513-529",
        "damping forces at the joints",
        {place: _forces(place) for place in ("after line 511", "after line 529", "in line 603")},
        _forces_true,
        repairs=(
            "the loop over i of line 494 is closed in line 603 only, where i would be declared "
            "twice and rightSide1 be out of scope: closed after line 511 or after line 529",
        ),
        note="Where the loop is closed has no effect: its last pass has all coefficients. The fin "
        "factor s_i is spike*medium at the start, medium inside, tail*medium at the tail.",
        printed="dampingForcesX[s]=-exterDampingCoef*(spikeDampingCoef*mediumDampingCoef*"
        "aeroDampingCoef[s])*0.5*elementMass*velocities[s*2];",
    ),
    Claim(
        "Java 531-584",
        "effect of the damping forces",
        {"as printed": lambda n: symbolic_damping(symbolic(n))},
        lambda n: [-e for e in truth(n).D_e],
        note="The minus of line 583 belongs to the arm -l sin(phi) of a force along x; the forces "
        "carry their own.",
        printed="-kitExtDampingXmoment+kitExtDampingYmoment+kitExtDampingTrans",
    ),
)
