"""The claims of the listing's equation, lines 235-604: matrices, loads, right side."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from sympy import Abs, Expr, S, Symbol, atan2, cos, sin, symbols

from rodgen.derive.loads.external_damping import LOAD as DRAG
from rodgen.derive.loads.joint_drag import JointMotion, drag_divisor, joint_mass
from rodgen.derive.symbols import k, m
from rodgen_evidence.thesis.audit.claim import READ, Claim, Entries
from rodgen_evidence.thesis.audit.equations_loads import angles_at, resisting
from rodgen_evidence.thesis.audit.java_equation import MEAN, WITHOUT, Mean
from rodgen_evidence.thesis.audit.java_letters import (
    FINS,
    Symbolic,
    indexed_symbols,
    listing,
    right_side,
)
from rodgen_evidence.thesis.audit.java_steps import MATRICES
from rodgen_evidence.thesis.audit.truth import Column, D_x, D_y, c_int, flat, truth

# Of a velocity: one in every quadrant, and along every axis.
A, B = symbols("a b", positive=True)
CASES = ((A, B), (-A, B), (-A, -B), (A, -B), (S.Zero, B), (S.Zero, -B), (A, S.Zero), (-A, S.Zero))
# Forces -D_x, -D_y at the joints.
RESISTED: dict[str, Any] = {
    "dampingForcesX": lambda n: [-f for f in D_x[: n + 1]],
    "dampingForcesY": lambda n: [-f for f in D_y[: n + 1]],
}


def _entry(columns: int) -> Callable[[int, int], str]:
    """Java's name of an entry of a matrix with this many columns more than links."""
    return lambda n, at: f"[{at // (n + columns)}][{at % (n + columns)}]"


def _row(n: int, at: int) -> str:
    return ("row of x0", "row of y0")[at] if at < 2 else f"row of phi_{at - 2}"


def _right_side(n: int) -> Column:
    it = Symbolic(n, **RESISTED)
    it.call(*MATRICES, "assembleMatrixC")
    vars(it)["externalDamping"] = it.kitExtDamping
    it.createEquation()
    return it.rightSide


def velocity_angles(n: int) -> Column:
    return indexed_symbols("varphi_v", n + 1)


def _angles_by_case(n: int) -> Column:
    it = Symbolic(n)
    found = []
    for it.velocities[0], it.velocities[1] in CASES:
        it.velocityAngle(0)
        found.append(it.velocityAngles[0])
    return found


def _coefficients(mean: Mean) -> Entries:
    """Squares of the coefficients, which are not negative: in the square of a sine, the sign of
    the argument has no part, and the absolute values drop out."""

    def entries(n: int) -> Column:
        it = Symbolic(n, velocityAngles=velocity_angles)
        for i in range(n + 1):
            it.aeroDamping(i, mean)
        return [(a**2).replace(Abs, lambda inner: inner) for a in it.aeroDampingCoef]

    return entries


def _across_shares(n: int) -> Column:
    """Squared shares of a velocity of length 1 that are across the rod."""
    shares = []
    for angle, of_rod in zip(velocity_angles(n), angles_at(n), strict=True):
        joint = JointMotion(cos(angle), sin(angle), S.One, of_rod, S.One, (S.One,))
        (across,) = DRAG.force(joint)[0].atoms(Abs)
        shares.append(across.args[0] ** 2)
    return shares


def _joint_speeds(n: int) -> Column:
    x, y = indexed_symbols("v_x", n + 1), indexed_symbols("v_y", n + 1)
    return [v for pair in zip(x, y, strict=True) for v in pair]


def _forces(closed: str) -> Entries:
    """Forces at the joints, the loop over i closed at one of three places; a_i is what lines
    505-511 give, old_i what was there before."""

    def entries(n: int) -> Column:
        it = Symbolic(
            n, velocities=_joint_speeds, aeroDampingCoef=lambda n: indexed_symbols("old", n + 1)
        )
        for i, a in enumerate(indexed_symbols("a", n + 1)):
            it.aeroDampingCoef[i] = a
            if closed != "after line 511":
                it.dampingForces()
            if closed == "in line 603":
                it.kitExtDamping()
        if closed == "after line 511":
            it.dampingForces()
        return [*it.dampingForcesX, *it.dampingForcesY]

    return entries


def _forces_true(n: int) -> Column:
    """Forces by the law of the load: a_i stands for the share across the rod."""
    spike, medium, tail = FINS
    fins = [spike * medium, *[medium] * (n - 1), tail * medium]
    speeds, angle, divisor = _joint_speeds(n), Symbol("angle", real=True), Symbol("divisor")
    x, y = [], []
    for i, (fin, a) in enumerate(zip(fins, indexed_symbols("a", n + 1), strict=True)):
        mass = joint_mass(2 if 0 < i < n else 1)
        joint = JointMotion(speeds[2 * i], speeds[2 * i + 1], divisor, angle, mass, (fin,))
        fx, fy = (-f.replace(Abs, lambda _, a=a: a * divisor) for f in resisting(joint))
        x.append(fx)
        y.append(fy)
    return x + y


def _no_forces(n: int) -> Column:
    zero = S.Zero
    joint = JointMotion(zero, zero, drag_divisor(zero, zero), S.One, S.One, (S.One,))
    return [*DRAG.force(joint)] * (n + 1)


def _assembly(name: str, factor: Expr, times: int = 1) -> Entries:
    """Entries of a matrix with the factor that createEquation gives it (lines 375-403)."""
    return listing(*[f"assembleMatrix{name}"] * times, read=f"matrix{name}", factor=factor)


def _band_claims(
    lines: str, factored: str, title: str, name: str, factor: Expr, true: Entries, note: str = ""
) -> tuple[Claim, Claim]:
    """A matrix of three diagonals for two links or more, and for one, where it must stay empty."""
    claim = partial(
        Claim,
        readings={READ: _assembly(name, factor)},
        truth=true,
        label=_entry(0),
        printed="if (r==2) {1, -1}; if (r>2 && r<rows-1) {-1, 2, -1}; if (r==rows-1) {-1, 1}",
    )
    several = f"{title} matrix, two links or more"
    return (
        claim(f"Java {lines}, {factored}", several, links=range(2, 7), note=note),
        claim(
            f"Java {lines}, n=1",
            f"{title} matrix, one link",
            corrected=listing(read=f"matrix{name}"),
            links=(1,),
            note="The branches for the first and for the last link both apply to the only link, "
            "and the last leaves a 1 where there is no joint: a single free link is turned back "
            "towards the x axis.",
            correction="if (elementCount>1) { ... }",
        ),
    )


CLAIMS = (
    Claim(
        "Java 235-286, 375-382",
        "mass matrix",
        {READ: _assembly("M", m / 2)},
        lambda n: flat(truth(n).M),
        note=(
            "Rows are completed in order, so every entry below the diagonal is written before it"
            " is read. The thesis prints no M, so this is its only statement of M."
        ),
        printed="matrixM[r][r] = 2d*l*l*(1/3d+(n+(r-(2*r-1)))); ... matrixM[c][r]=matrixM[r][c];",
    ),
    Claim(
        "Java 288-313, 385-389",
        "velocity matrix",
        {READ: _assembly("Q", m / 2)},
        lambda n: flat(truth(n).Q),
        note="The loop that completes the lower half also runs over the entries it has written: "
        "they are negated twice. The last row is filled by it alone.",
        printed="if (r-2!=c) matrixQ[c+2][r-2]=-matrixQ[r][c];",
    ),
    Claim(
        "Java 288-313, again",
        "velocity matrix, assembled a second time over the first",
        {READ: _assembly("Q", m / 2, times=2)},
        lambda n: flat(truth(n).Q),
        note=(
            "The members are kept from step to step, but nothing of the last assembly remains in"
            " them."
        ),
        printed="if (r-2!=c) matrixQ[c+2][r-2]=-matrixQ[r][c];",
    ),
    *_band_claims("315-341", "392-396", "stiffness", "K", k, lambda n: flat(truth(n).K)),
    *_band_claims(
        "343-369",
        "399-403",
        "internal damping",
        "C",
        c_int * m,
        lambda n: flat(truth(n).D_i),
        "Section 4.1 calls it assembleMatrixD and D_i.",
    ),
    Claim(
        "Java 424-443",
        "follower force",
        {READ: listing(read="kitFollower")},
        lambda n: truth(n).F,
        repairs=("lines 429 and 439, comments: the digit 1 is the letter l",),
        note="A thrust at the tail that compresses for a positive force, as the text describes it.",
        printed="kitFollowerX.addValue(0, -followerForceX); "
        "kitFollowerX.addValue(r, followerForceX*elementLength*anglesSin[r-2]);",
    ),
    Claim(
        "Java 446-489",
        "gravity",
        {READ: listing(read="kitGravity")},
        lambda n: truth(n).A,
        note="Downwards for a positive acceleration in every row.",
        printed="-elementMass*gravityAcceleration*elementLength*anglesCos[r-2]*"
        "(elementCount-0.5-(r-2)); -mass*gravityAcceleration",
    ),
    Claim(
        "Java 586-604",
        "right side, two links or more",
        {READ: _right_side},
        right_side,
        links=range(2, 7),
        note="The external damping by the forces at the joints. One link has the spring and the "
        "damper that K and C give it.",
        printed="QtimesOmegaSq-KtimesFi-CtimesOmega+kitFollowerX+kitFollowerY+kitGravityOverall"
        "+kitExtDampingOverall",
    ),
    Claim(
        "Java 495-503",
        "angle of the velocity of a joint",
        {READ: _angles_by_case},
        lambda n: [atan2(vy, vx) for vx, vy in CASES],
        links=(1,),
        note=(
            "All four quadrants and all four axes are right; Math.atan2 would give the same. "
            "(2.57) of the text has the first and the fourth quadrant only."
        ),
        printed="if (vx<0 && vy<0) velocityAngles[i]=-Math.PI+Math.atan(-vy/-vx); "
        "if (vx>0 && vy<0) velocityAngles[i]=-Math.atan(vy/-vx); ...",
    ),
    Claim(
        "Java 495-503, at rest",
        "damping forces at joints without velocity",
        {
            READ: listing(
                "externalDamping",
                read="dampingForcesX dampingForcesY",
                velocities=lambda n: [S.Zero] * (2 * n + 2),
                velocityAngles=velocity_angles,
            )
        },
        _no_forces,
        note=(
            "No case of the angle fits, so the old value stays. This has no effect on the "
            "forces. getVelocityAngles and getAeroCoefficients return the old value."
        ),
        printed="if (vx==0 && vy>0) ...; if (vx==0 && vy<0) ...; if (vx>0 && vy==0) ...; ...",
    ),
    Claim(
        "Java 505-511",
        "share of the velocity across the rod",
        {
            "velocityAngles[i]-(angles[i-1]+angles[i])/2d": _coefficients(MEAN),
            "(velocityAngles[i]-angles[i-1]+angles[i])/2d": _coefficients(WITHOUT),
        },
        _across_shares,
        repairs=(
            "lines 506, 508 and 511 close one parenthesis more than they open; all three are "
            "broken right after a minus, where one may have been lost",
        ),
        note=(
            "Compared as squares. With the printed parentheses the program does not compile. The"
            " first reading is (2.56)."
        ),
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
        note=(
            "The place where the loop is closed has no effect, because its last pass has all "
            "coefficients. The fin factor s_i is spike*medium at the start, medium inside, "
            "tail*medium at the tail."
        ),
        printed="dampingForcesX[s]=-exterDampingCoef*(spikeDampingCoef*mediumDampingCoef*"
        "aeroDampingCoef[s])*0.5*elementMass*velocities[s*2];",
    ),
    Claim(
        "Java 531-584",
        "effect of the damping forces",
        {READ: listing(read="kitExtDamping", **RESISTED)},
        lambda n: [-e for e in truth(n).D_e],
        note=(
            "The minus of line 583 belongs to the arm -l sin(phi) of a force along x. The forces"
            " have their own signs."
        ),
        printed="-kitExtDampingXmoment+kitExtDampingYmoment+kitExtDampingTrans",
    ),
)
