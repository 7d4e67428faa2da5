"""Equations 2.54 to 2.60 as printed: damping by the surrounding medium."""

from __future__ import annotations

from collections.abc import Iterator

from sympy import Abs, Expr, Integer, S, Symbol, atan, atan2, cos, sin, sqrt, symbols

from rodgen.derive.loads import JointDrag, drag_force, joint_angle, joint_mass
from rodgen.derive.symbols import l, m

from .claim import NOT_PRINTED, Claim
from .equations_definitions import READ
from .equations_matrices import row_name
from .truth import LETTERS, MOST, Column, D_x, D_y, c_ext, phi, total, truth

speed = Symbol("v", positive=True)
vx = symbols(f"v_x0:{MOST + 1}", real=True)  # velocities of the joints
vy = symbols(f"v_y0:{MOST + 1}", real=True)
share = symbols(f"a_0:{MOST + 1}", positive=True)  # of the velocity, across the rod
fin = symbols(f"s_0:{MOST + 1}", positive=True)

# One velocity in every quadrant, and along y: 3, 4, 5 so that everything stays rational.
VELOCITIES = ((3, 4), (-3, 4), (-3, -4), (3, -4), (0, 5), (0, -5))


def resisting(joint: JointDrag) -> Column:
    """Components of the resisting force of derive/: D of the thesis."""
    return [-e.xreplace(LETTERS) for e in drag_force(joint)]


def given_share(i: int, mass: Expr, factor: Expr) -> Column:
    """The same for a joint of which the share a_i is given: the law of derive/ finds it as
    (velocity across the rod) / divisor."""
    angle = phi[0]
    across = Abs(vy[i] * cos(angle) - vx[i] * sin(angle))
    return resisting(JointDrag(vx[i], vy[i], across / share[i], angle, mass, factor))


def across_only(n: int) -> Column:
    """Resisting force on a mass that moves across the rod."""
    joint = JointDrag(S.Zero, speed, speed, S.Zero, m, S.One)
    return resisting(joint)[1:]


def angles_at(n: int) -> Iterator[Expr]:
    """Angle of the rod at every joint, from derive/."""
    for i in range(n + 1):
        yield joint_angle(list(phi[max(i - 1, 0) : min(i + 1, n)]))


def derived_shares(n: int) -> Column:
    """a_i^2 of every joint: the resisting force over c m v, squared."""
    out = []
    for i, angle in enumerate(angles_at(n)):
        divisor = sqrt(vx[i] ** 2 + vy[i] ** 2)
        x, _ = resisting(JointDrag(vx[i], vy[i], divisor, angle, m, S.One))
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
    Claim(
        "2.54",
        "damping force, in general",
        {READ: lambda n: [c_ext * m * speed]},
        across_only,
        printed=r"D = c m v",
        note="Compared for a mass that moves across the rod. D is the force that is overcome: "
        "2.53 has it with a minus.",
        label=lambda n, at: "D",
    ),
    Claim(
        "2.55",
        "damping force, by direction",
        {READ: lambda n: [c_ext * share[0] * m * v for v in (vx[0], vy[0])]},
        lambda n: given_share(0, m, S.One),
        printed=r"D = c_{ext} a_i m v",
        note="For the components of D and v.",
        label=lambda n, at: f"D_{'xy'[at]}",
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
        note="Joints 0 and n, which have forces in 2.59, have one link only: phi_{-1} and phi_n "
        "do not exist. Put right as in the listing, lines 505 to 508. Compared squared, with the "
        "angle of 2.57: the missing quadrant does no harm, since |sin| has the period pi.",
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
        note="The principal value is wrong by pi for v_x < 0 and undefined for v_x = 0; what 2.56 "
        "makes of it feels only the latter. The listing (lines 495 to 503) goes by quadrants.",
        label=velocity_name,
    ),
    Claim(
        "2.58",
        "damping force with fins",
        {READ: lambda n: [c_ext * fin[0] * share[0] * m * v for v in (vx[0], vy[0])]},
        lambda n: given_share(0, m, fin[0]),
        printed=r"D = c_{ext} s_i a_i m v",
        note="For the components of D and v.",
        label=lambda n, at: f"D_{'xy'[at]}",
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
        label=lambda n, at: f"D_{'xy'[at % 2]},{at // 2}",
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
