"""The rod: its parameters, boundaries, inertias, what may differ along it, and what is fixed or
added to it: bodies, supports, a foundation, states.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, replace

from rodgen.model.term import ANY, LINKS, NOT_NEGATIVE, POSITIVE, SPRINGS, Parameter

# fmt: off
ROD = (
    Parameter("mass", "mass", "mass", "M", "kg", "of the rod []", rule=POSITIVE, decades=True),
    Parameter("length", "length", "length", "L", "m", "of the rod []", rule=POSITIVE, decades=True),
    Parameter("bending_stiffness", "bending_stiffness", "bending stiffness", "EI", "N m^2",
        "EI []", rule=NOT_NEGATIVE, decades=True),
)
# Numbers of a scene that reach its module as those of links.
MASS_PER_LENGTH = Parameter("mass_per_length", "mass_per_length", "mass per length", "", "kg/m",
    "instead of the mass []", rule=POSITIVE, decades=True)
SPRING = Parameter("spring", "spring", "moment of a spring", "", "N m",
    "by its stiffness k and the angle d that bends it []")
REST_CURVATURE = Parameter("rest_curvature", "rest_curvature", "curvature at rest", "", "1/m",
    "to the left, of the rod that no load acts on []")
CLAMP_ANGLE = Parameter("clamp_angle", "clamp_angle", "clamp angle", "", "rad",
    "angle at which the start is held []", default=0.0)
# fmt: on


@dataclass(frozen=True, slots=True)
class Boundary:
    """Boundary of a rod: how its ends are held.

    title: of a rod that is held so; description: what holds it.
    translates: joint 0 moves freely, with coordinates x0, y0.
    first: the first link that moves; links before it are held at clamp_angle.
    root: stiffness of a spring in joint 0 that holds link 0 at clamp_angle, in springs between
    links (half a link bends there: twice as stiff), and internal damping there, in the same way.
    tail: likewise of a spring in joint n that holds the last link at clamp_angle.
    moves: what holds the start is moved, as a function of time.
    """

    title: str
    description: str
    _: KW_ONLY
    translates: bool = False
    first: int = 0
    root: int = 0
    tail: int = 0
    moves: bool = False

    @property
    def first_joint(self) -> int:
        """The first joint that moves, freely or as it is moved."""
        return 0 if self.translates or self.moves else self.first + 1

    @property
    def first_in_motion(self) -> int:
        """The first link that moves, freely or as it is moved."""
        return 0 if self.moves else self.first

    @property
    def first_force(self) -> int:
        """The first joint that passes a force on to a moving link."""
        return 1 if self.translates else self.first

    @property
    def first_spring(self) -> int:
        """The first joint with a spring."""
        return 0 if self.root else 1

    def spring_joints(self, links: int) -> range:
        """The joints with a spring."""
        return range(self.first_spring, links + bool(self.tail))

    @property
    def min_links(self) -> int:
        """The fewest links with which something moves."""
        return self.first + 1

    @property
    def is_held(self) -> bool:
        """Whether something holds the start of the rod in its place."""
        return not self.translates

    @property
    def is_clamped(self) -> bool:
        """Whether the rod is held at clamp_angle, by a link that does not move or by a spring."""
        return bool(self.first or self.root or self.tail)

    @property
    def start_drawing(self) -> str:
        """Name of the drawing at joint 0: "none", a "wall" or a "pin"."""
        if self.translates:
            return "none"
        return "wall" if self.is_clamped else "pin"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of this boundary."""
        return (CLAMP_ANGLE,) if self.is_clamped else ()


# fmt: off
BOUNDARIES = {
    "free": Boundary("free in space", "nothing", translates=True),
    "cantilever": Boundary("held at link 0 (the thesis's clamp)",
        "link 0 stays at `clamp_angle` (the thesis's clamp, of first order in 1/n)", first=1),
    "clamped": Boundary("clamped by a root spring",
        "a spring of 2 EI n/L at joint 0, against `clamp_angle` (of second order in 1/n)", root=2),
    "pinned": Boundary("pinned at joint 0", "nothing: a chain of n pendulums"),
}
# fmt: on


@dataclass(frozen=True, slots=True)
class Inertia:
    """Distribution of the mass along a link: in words, and whether a link resists being turned
    about its own middle other than by masses at its ends."""

    description: str
    rotary: bool


INERTIAS = {
    "uniform": Inertia("mass spread along each link", rotary=True),
    "lumped": Inertia("massless links, M/n at inner joints, M/2n at joints 0 and n", rotary=False),
}


@dataclass(frozen=True, slots=True)
class Nonuniform:
    """Parameters by which a rod differs along its length.

    parameters: what it has; instead: names of parameters of an even rod whose place they take;
    title: what differs, in words.
    """

    parameters: tuple[Parameter, ...]
    title: str
    instead: tuple[str, ...] = ()


def _of_links(
    name: str, label: str, description: str, rule: str = ANY, unit: str = ""
) -> Parameter:
    """A parameter with a number for every link."""
    return Parameter(name, "", label, "", unit, description, rule=rule, each=LINKS)


# fmt: off
LINK_LENGTH = _of_links("link_length", "link length", "of each link []", POSITIVE, "m")
LINK_MASS = _of_links("link_mass", "link mass", "of each link []", POSITIVE, "kg")
CENTRE_ALONG = _of_links("link_centre_along", "centre along",
    "centre of gravity of each link along it, over its length")
CENTRE_ACROSS = _of_links("link_centre_across", "centre across",
    "centre of gravity of each link across it, over its length")
SPREAD_ALONG = _of_links("link_spread_along", "spread along",
    "mean square of the mass of each link along it about its centre, over its length squared",
    NOT_NEGATIVE)
SPREAD_ACROSS = _of_links("link_spread_across", "spread across",
    "mean square of the mass of each link across it about its centre, over its length squared",
    NOT_NEGATIVE)
SPREAD_MIXED = _of_links("link_spread_mixed", "mixed spread",
    "mean product of both of the mass of each link about its centre, over its length squared")
# fmt: on
CENTRE = CENTRE_ALONG, CENTRE_ACROSS
SPREAD = SPREAD_ALONG, SPREAD_ACROSS, SPREAD_MIXED


def _steady(one: Parameter) -> Parameter:
    """Parameter of the masses of links that do not change with time, where others do."""
    return replace(
        one,
        name=one.name.replace("link", "steady"),
        label=f"{one.label}, steady",
        description=f"{one.description}, of masses that do not change",
        rule=NOT_NEGATIVE if one is LINK_MASS else one.rule,
    )


def changing_body_rows(name: str) -> tuple[Parameter, ...]:
    """Parameters of a body whose mass changes with time: its place on its link and its inertia;
    name: prefix of their names."""
    body = name.removeprefix("body_")
    spread = f"half the moment of inertia of {body} over the square of the length of a link []"
    numbers = (
        ("along", "", f"place of {body} along its link, over its length", ANY),
        ("across", "", f"place of {body} across its link, over its length", ANY),
        ("spread", "kg", spread, NOT_NEGATIVE),
    )
    return tuple(
        Parameter(f"{name}_{what}", "", f"{name} {what}", "", unit, words, rule=rule)
        for what, unit, words, rule in numbers
    )


STEADY = {one.name: _steady(one) for one in (LINK_MASS, *CENTRE, *SPREAD)}

# fmt: off
JOINT_STIFFNESS = Parameter("joint_stiffness", "bending_stiffness", "joint stiffness", "k",
    "N m/rad", "of the spring in each joint that has one []", rule=NOT_NEGATIVE, each=SPRINGS)
REST_ANGLE = Parameter("rest_angle", REST_CURVATURE.key, "rest angle", "", "rad",
    "between the links at each joint with a spring where that is not bent []", each=SPRINGS)
BENT_LENGTH = Parameter("bent_length", "", "bent length", "", "m",
    "of the rod that bends in each joint with a spring []", rule=POSITIVE, each=SPRINGS)
NONUNIFORM = {
    "stiffness": Nonuniform((JOINT_STIFFNESS,), "stiffness that differs from joint to joint",
        instead=("bending_stiffness",)),
    "mass": Nonuniform((LINK_MASS,), "mass that differs from link to link"),
    "bodies": Nonuniform((LINK_MASS, *CENTRE, *SPREAD), "bodies fixed to its links"),
    "points": Nonuniform((LINK_MASS, CENTRE_ALONG), "point masses in its joints"),
    "rest": Nonuniform((REST_ANGLE,), "springs that are at rest where it is bent"),
    "lengths": Nonuniform((LINK_LENGTH, BENT_LENGTH), "links of unequal length"),
    "ends": Nonuniform((BENT_LENGTH,), "a body at its end that resists turning"),
}
# fmt: on
# Of these ways to differ a rod has one at most: how its mass lies.
MASS_WAYS = {what for what, way in NONUNIFORM.items() if LINK_MASS in way.parameters}


def _row(name: str, label: str, unit: str, rule: str = NOT_NEGATIVE) -> Parameter:
    """A number that is zero where a scene does not give it."""
    return Parameter(name, name, label, "", unit, f"{label} []", rule=rule, default=0.0)


def _pair(key: str, one: Parameter) -> tuple[Parameter, Parameter]:
    """Both numbers of a key that has two, in x and in y."""
    x, y = (
        replace(one, name=f"{one.name}{axis}", key=key, label=f"{one.label} {axis}", part=part)
        for part, axis in enumerate("xy")
    )
    return x, y


# Where on the rod something is.
# fmt: off
AT = Parameter("at", "at", "place s", "", "", "from 0 at the start (nose or root) to 1 at the tail",
    rule=NOT_NEGATIVE, first=1.0, most=1.0)
# fmt: on
# Of a force the place is part of the module.
AT_IN_MODULE = replace(AT, fixed=True)

BODY_MASS = Parameter(
    "body_mass", "mass", "mass", "", "kg", "of a body []", rule=POSITIVE, decades=True
)
OFFSET = (
    replace(_row("along", "centre along the link", "m", ANY), key="offset", part=0),
    replace(_row("across", "centre across the link", "m", ANY), key="offset", part=1),
)
BODY = (BODY_MASS, _row("inertia", "moment of inertia", "kg m^2"), AT, *OFFSET)
CHANGING_BODY = (*BODY[:2], AT_IN_MODULE, *OFFSET)  # a body whose mass changes with time

SUPPORT = (
    AT,
    *_pair("to", replace(_row("", "fixed point in", "m", ANY), default=None)),
    *_pair("stiffness", replace(_row("stiffness_", "stiffness in", "N/m"), first=10.0)),
    *_pair("damping", _row("damping_", "damping in", "N s/m")),
    _row("rotation", "stiffness against turning", "N m/rad"),
    _row("rotation_damping", "damping of turning", "N m s/rad"),
)
SHARE = _row("share", "share of the link before the point", "1")  # what becomes of AT
FOUNDATION = (
    replace(_row("stiffness", "stiffness of the foundation", "N/m^2"), first=10.0),
    _row("damping", "damping of the foundation", "N s/m^2"),
)
STATE = (Parameter("rate", "rate", "rate", "", "", "per second", timed=True),)
STATE_AT_START = _row("initial", "at the start", "", ANY)
