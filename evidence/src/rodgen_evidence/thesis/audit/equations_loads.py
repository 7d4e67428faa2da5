"""Equations 2.46 to 2.64 as printed, but those with matrices: forces, damping, gravity, medium."""

from __future__ import annotations

from collections.abc import Iterator

from sympy import Abs, Expr, Integer, S, Symbol, atan, atan2, cos, sin, sqrt, symbols

from rodgen.derive.link_properties import Rod
from rodgen.derive.loads.external_damping import LOAD as DRAG
from rodgen.derive.loads.follower import LOAD as FOLLOWER
from rodgen.derive.loads.gravity import LOAD as GRAVITY
from rodgen.derive.loads.internal_damping import LOAD as DAMPING
from rodgen.derive.loads.joint_drag import JointMotion, joint_mass
from rodgen.derive.symbols import l, m, s
from rodgen.model.rod import BOUNDARIES
from rodgen_evidence.thesis.audit.claim import NOT_PRINTED, READ, Claim, Entries
from rodgen_evidence.thesis.audit.equations_energy import HALF
from rodgen_evidence.thesis.audit.equations_matrices import (
    ROWS,
    TWO_LINKS,
    entry_of,
    row_name,
    tridiagonal,
)
from rodgen_evidence.thesis.audit.latex import Names, equation, read
from rodgen_evidence.thesis.audit.truth import (
    LETTERS,
    MOST,
    Column,
    D_x,
    D_y,
    P,
    c_ext,
    c_int,
    flat,
    g,
    nu,
    omega,
    phi,
    total,
    truth,
)

omega_r = Symbol("omega_r", real=True)  # rate at which a joint opens
a_g = Symbol("a_g", real=True)  # acceleration that acts on a link
LOADS: Names = {
    "F_follower": P,
    r"\nu": nu,
    "c": c_int,
    "c_int": c_int,
    r"\omega": omega_r,
    "g": g,
    "a_g": a_g,
}
COMPONENTS = (
    r"F_{follower,x} = F_{follower} \cos(\varphi_{n-1} + \nu), \quad "
    r"F_{follower,y} = F_{follower} \sin(\varphi_{n-1} + \nu)"
)
DAMPER = r"M = -c_{int} m (\omega_{s+1} - \omega_s)"


def derived_follower(n: int) -> Column:
    return [e.xreplace(LETTERS) for e in FOLLOWER.force(phi[n - 1])]


def against_thrust(n: int) -> Column:
    """The force at the tail, counted against the thrust: what 2.46 calls F_follower."""
    return [-e for e in derived_follower(n)]


def follower_vector(base: int, sign: int) -> Entries:
    """2.47; base: F_x, F_y in units of F_follower; sign: of F_follower against 2.46."""

    def rows(n: int) -> Column:
        x, y = (sign * component for component in read(COMPONENTS, letters=LOADS)(n))
        turns = [x * l * sin(phi[i]) - y * l * cos(phi[i]) for i in range(n)]
        return [base * x, base * y, *turns]

    return rows


def damper(before: Expr, after: Expr) -> Expr:
    return DAMPING.moment(before, after, Rod().joint(s)).xreplace(LETTERS)


def derived_dampers(n: int) -> Column:
    return [damper(omega[s], omega[s + 1]) for s in range(n - 1)]


def gravity_vector(a_g: Expr, base: int = 1) -> Entries:
    """2.64; base: sign of M a_g in the first vector."""

    def rows(n: int) -> Column:
        arms = [(n - HALF - i) * cos(phi[i]) for i in range(n - 1)]
        arms.append(HALF * cos(phi[n - 1]))
        return [S.Zero, base * n * m * a_g, *(-a_g * m * l * arm for arm in arms)]

    return rows


def derived_weight(n: int) -> Expr:
    """Weight of a link, upwards."""
    return GRAVITY.weight(m, BOUNDARIES["free"])[1].xreplace(LETTERS)


speed = Symbol("v", positive=True)
vx = symbols(f"v_x0:{MOST + 1}", real=True)  # velocities of the joints
vy = symbols(f"v_y0:{MOST + 1}", real=True)
share = symbols(f"a_0:{MOST + 1}", positive=True)  # of the velocity, across the rod
fin = symbols(f"s_0:{MOST + 1}", positive=True)

# One velocity in every quadrant, and along y: 3, 4, 5 so that everything stays rational.
VELOCITIES = ((3, 4), (-3, 4), (-3, -4), (3, -4), (0, 5), (0, -5))


def resisting(joint: JointMotion) -> Column:
    """Components of the resisting force of derive/: D of the thesis."""
    return [-e.xreplace(LETTERS) for e in DRAG.force(joint)]


def given_share(i: int, mass: Expr, factor: Expr) -> Column:
    """Components of the resisting force on a joint of which the share a_i is given: the law of
    derive/ finds it as (velocity across the rod) / divisor."""
    angle = phi[0]
    across = Abs(vy[i] * cos(angle) - vx[i] * sin(angle))
    return resisting(JointMotion(vx[i], vy[i], across / share[i], angle, mass, (factor,)))


def across_only(n: int) -> Column:
    """Resisting force on a mass that moves across the rod."""
    joint = JointMotion(S.Zero, speed, speed, S.Zero, m, (S.One,))
    return resisting(joint)[1:]


def angles_at(n: int) -> Iterator[Expr]:
    """Angle of the rod at every joint, from derive/."""
    for i in range(n + 1):
        before, after = phi[i - 1] if i else None, phi[i] if i < n else None
        yield Rod().mean_angle(before, after, i)


def derived_shares(n: int) -> Column:
    """a_i^2 of every joint: the resisting force over c m v, squared."""
    out = []
    for i, angle in enumerate(angles_at(n)):
        divisor = sqrt(vx[i] ** 2 + vy[i] ** 2)
        x, _ = resisting(JointMotion(vx[i], vy[i], divisor, angle, m, (S.One,)))
        out.append((x / (c_ext * m * vx[i])) ** 2)
    return out


def shares(n: int) -> Column:
    """a_i^2 of 2.56, with 2.57: for joints between two links."""
    inner = [sin(atan(vy[i] / vx[i]) - (phi[i - 1] + phi[i]) / 2) ** 2 for i in range(1, n)]
    return [NOT_PRINTED, *inner, NOT_PRINTED]


def shares_right(n: int) -> Column:
    angles = [phi[0], *((phi[i - 1] + phi[i]) / 2 for i in range(1, n)), phi[n - 1]]
    return [sin(atan(vy[i] / vx[i]) - angle) ** 2 for i, angle in enumerate(angles)]


def principal(n: int) -> Column:
    """Cosine and sine of the angle of 2.57, of the principal value; none for v_x = 0."""
    out: Column = []
    for x, y in VELOCITIES:
        angle = atan(Integer(y) / x) if x else None
        out += [NOT_PRINTED, NOT_PRINTED] if angle is None else [cos(angle), sin(angle)]
    return out


def with_quadrant(n: int) -> Column:
    angles = [atan2(Integer(y), Integer(x)) for x, y in VELOCITIES]
    return [function(angle) for angle in angles for function in (cos, sin)]


def directions(n: int) -> Column:
    """Unit vectors of the velocities."""
    return [component / sqrt(Integer(x * x + y * y)) for x, y in VELOCITIES for component in (x, y)]


def velocity_name(n: int, at: int) -> str:
    return f"{('cos', 'sin')[at % 2]} for v = {VELOCITIES[at // 2]}"


def joint_forces(n: int) -> Column:
    """2.59: D_x, D_y of every joint."""
    out: Column = []
    for i in range(n + 1):
        mass = m / 2 if i in (0, n) else m
        out += [c_ext * fin[i] * share[i] * mass * v for v in (vx[i], vy[i])]
    return out


def derived_joint_forces(n: int) -> Column:
    out: Column = []
    for i in range(n + 1):
        out += given_share(i, joint_mass(1 if i in (0, n) else 2), fin[i])
    return out


def medium_vector(n: int) -> Column:
    """2.60."""

    def after(force: tuple[Expr, ...], i: int) -> Expr:
        return total(lambda q: force[q], i + 1, n)

    turns = [l * (cos(phi[i]) * after(D_y, i) - sin(phi[i]) * after(D_x, i)) for i in range(n)]
    return [total(lambda q: D_x[q], 0, n), total(lambda q: D_y[q], 0, n), *turns]


CLAIMS: tuple[Claim, ...] = (
    equation(
        "2.46",
        "components of the follower force, counted against the thrust",
        COMPONENTS,
        against_thrust,
        letters=LOADS,
        repairs=("The angle nu was read as v.",),
        note=(
            "Compared with the opposite of the thrust, which acts from the tail towards the "
            "nose. The sign of a component is a convention, and the moments of 2.47 are right "
            "with this one. The force of 2.47 need not be right; see there."
        ),
    ),
    Claim(
        "2.47",
        "vector of the follower force",
        {
            "F_x = F_follower,x of 2.46": follower_vector(1, 1),
            "F_x = F_follower,x, that of 2.46 with the other sign": follower_vector(1, -1),
            "F_x = -F_follower,x, as in the listing, lines 434 and 444": follower_vector(-1, 1),
        },
        lambda n: truth(n).F,
        corrected=follower_vector(-1, 1),
        printed=r"\mathbf{F} = \begin{bmatrix} F_x \\ F_y \\ 0 \\ \vdots \\ 0 \end{bmatrix} "
        r"+ F_{follower,x} l \begin{bmatrix} 0 \\ 0 \\ \sin(\varphi_0) \\ \vdots \\ "
        r"\sin(\varphi_{n-1}) \end{bmatrix} - F_{follower,y} l \begin{bmatrix} 0 \\ 0 \\ "
        r"\cos(\varphi_0) \\ \vdots \\ \cos(\varphi_{n-1}) \end{bmatrix}",
        correction=r"F_x = -F_{follower,x}, \quad F_y = -F_{follower,y}",
        note=(
            "F_x and F_y are not defined. As the components of 2.46 they pull at the tail, but "
            "the moments are those of a push. With the other sign in 2.46 the force pushes and "
            "the moments are those of a pull. With the minus of the listing, 2.46 is right as "
            "printed."
        ),
        label=row_name,
    ),
    equation(
        "2.48",
        "moment of linear damping",
        r"M = -c m \omega",
        lambda n: [damper(S.Zero, omega_r)],
        letters=LOADS,
        note="c is c_int and omega the rate at which a joint opens.",
    ),
    Claim(
        "2.49",
        "moment of internal damping",
        {READ: read(DAMPER, over=lambda n: range(n - 1), letters=LOADS)},
        derived_dampers,
        links=TWO_LINKS,
        printed=r"M = -c_{int} m \frac{d}{dt} \Delta\varphi = -c_{int} m \omega_r",
        note="With the difference of angles of 2.18.",
    ),
    equation(
        "2.50",
        "moment of internal damping across joint s+1",
        DAMPER,
        derived_dampers,
        over=lambda n: range(n - 1),
        letters=LOADS,
        links=TWO_LINKS,
        note="The moment on link s+1; link s gets the opposite.",
    ),
    Claim(
        "2.52",
        "matrix of internal damping",
        {READ: lambda n: flat(tridiagonal(n, c_int * m))},
        lambda n: flat(truth(n).D_i),
        links=TWO_LINKS,
        printed=r"\mathbf{D}_i = c_{int} m " + ROWS,
        note="A single link has no damper.",
        label=entry_of(lambda n: n),
    ),
    equation(
        "2.62",
        "weight of a link",
        r"F_g = m g",
        lambda n: [-derived_weight(n)],
        letters=LOADS,
        note="Its magnitude, which acts downwards.",
    ),
    equation(
        "2.63",
        "force of the acceleration a_g on a link",
        r"F_a = m a_g",
        lambda n: [derived_weight(n).xreplace({g: -a_g})],
        letters=LOADS,
        note=(
            "A definition: force and acceleration are both upwards, or both downwards. The text "
            "does not say which. 2.64 uses both, and the conflict is counted there."
        ),
    ),
    Claim(
        "2.64",
        "vector of gravity",
        {"a_g = g": gravity_vector(g), "a_g = -g": gravity_vector(-g)},
        lambda n: truth(n).A,
        corrected=gravity_vector(g, base=-1),
        printed=r"\mathbf{A} = \begin{bmatrix} 0 \\ M a_g \\ 0 \\ \vdots \\ 0 \end{bmatrix} "
        r"- a_g m l \begin{bmatrix} 0 \\ 0 \\ (n - \frac{1}{2}) \cos(\varphi_0) \\ "
        r"(n - \frac{1}{2} - 1) \cos(\varphi_1) \\ \vdots \\ "
        r"(n - \frac{1}{2} - i) \cos(\varphi_i) \\ \frac{1}{2} \cos(\varphi_{n-1}) "
        r"\end{bmatrix}",
        correction=r"-M a_g \text{ in place of } M a_g, \quad a_g = g",
        note=(
            "No sign of a_g makes both vectors right. The force is that of a_g upwards, its "
            "moments are those of a_g downwards. The listing (lines 468, 482) has both "
            "downwards."
        ),
        label=row_name,
    ),
    equation(
        "2.54",
        "damping force, in general",
        r"D = c m v",
        across_only,
        letters={"c": c_ext, "v": speed},
        note=(
            "Compared for a mass that moves across the rod. D is the force that the motion "
            "overcomes, so 2.53 has it with a minus."
        ),
    ),
    Claim(
        "2.55",
        "damping force, by direction",
        {READ: lambda n: [c_ext * share[0] * m * v for v in (vx[0], vy[0])]},
        lambda n: given_share(0, m, S.One),
        printed=r"D = c_{ext} a_i m v",
        note="For the components of D and v.",
    ),
    Claim(
        "2.56",
        "share of the velocity across the rod",
        {READ: shares},
        derived_shares,
        corrected=shares_right,
        printed=r"a_i = \left| \sin \left(\varphi_{v,i} - \frac{\varphi_{i-1} + \varphi_i}{2} "
        r"\right) \right|",
        correction=r"a_0 = |\sin(\varphi_{v,0} - \varphi_0)|, \quad "
        r"a_n = |\sin(\varphi_{v,n} - \varphi_{n-1})|",
        note=(
            "Joints 0 and n, which have forces in 2.59, have one link only: phi_{-1} and phi_n "
            "do not exist. Corrected as in the listing, lines 505 to 508. Compared as squares, "
            "with the angle of 2.57. The missing quadrant has no effect, because |sin| has the "
            "period pi."
        ),
        label=lambda n, at: f"joint {at}",
    ),
    Claim(
        "2.57",
        "angle of the velocity of a joint",
        {
            "principal value of the arctangent": principal,
            "in the quadrant of the velocity": with_quadrant,
        },
        directions,
        corrected=with_quadrant,
        printed=r"\varphi_{v,i} = \arctan \left(\frac{v_{y,i}}{v_{x,i}} \right)",
        correction=r"\varphi_{v,i} = \operatorname{atan2}(v_{y,i}, v_{x,i})",
        note=(
            "The principal value is wrong by pi for v_x < 0 and undefined for v_x = 0. Only the "
            "latter affects 2.56. The listing (lines 495 to 503) distinguishes quadrants."
        ),
        label=velocity_name,
    ),
    Claim(
        "2.58",
        "damping force with fins",
        {READ: lambda n: [c_ext * fin[0] * share[0] * m * v for v in (vx[0], vy[0])]},
        lambda n: given_share(0, m, fin[0]),
        printed=r"D = c_{ext} s_i a_i m v",
        note="For the components of D and v.",
    ),
    Claim(
        "2.59",
        "damping forces at the joints",
        {READ: joint_forces},
        derived_joint_forces,
        printed=r"D_{x,0} = c_{ext} s_0 a_0 \frac{m}{2} v_{x,0}, \quad "
        r"D_{y,0} = c_{ext} s_0 a_0 \frac{m}{2} v_{y,0}, \quad "
        r"D_{x,i} = c_{ext} s_i a_i m v_{x,i}, \quad D_{y,i} = c_{ext} s_i a_i m v_{y,i}, \quad "
        r"i = 1, 2, \dots, n-1, \quad D_{x,n} = c_{ext} s_n a_n \frac{m}{2} v_{x,n}, \quad "
        r"D_{y,n} = c_{ext} s_n a_n \frac{m}{2} v_{y,n}",
    ),
    Claim(
        "2.60",
        "vector of external damping",
        {READ: medium_vector},
        lambda n: truth(n).D_e,
        printed=r"\mathbf{D}_e = \begin{bmatrix} \sum_{i=0}^n D_{x,i} \\ \sum_{i=0}^n D_{y,i} \\ "
        r"0 \\ \vdots \\ 0 \end{bmatrix} - l \begin{bmatrix} 0 \\ 0 \\ "
        r"\sin(\varphi_0) \sum_{i=1}^n D_{x,i} \\ \sin(\varphi_1) \sum_{i=2}^n D_{x,i} \\ \vdots "
        r"\\ \sin(\varphi_{k-1}) \sum_{i=k}^n D_{x,i} \\ \sin(\varphi_{n-1}) D_{x,n} "
        r"\end{bmatrix} + l \begin{bmatrix} 0 \\ 0 \\ \cos(\varphi_0) \sum_{i=1}^n D_{y,i} \\ "
        r"\cos(\varphi_1) \sum_{i=2}^n D_{y,i} \\ \vdots \\ "
        r"\cos(\varphi_{k-1}) \sum_{i=k}^n D_{y,i} \\ \cos(\varphi_{n-1}) D_{y,n} \end{bmatrix}",
        label=row_name,
    ),
)
