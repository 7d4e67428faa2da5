"""What a generated module is specialised to: no values, only what is there and what is not."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, field

from rodgen.scene.errors import SceneError
from rodgen.scene.plain import plain


@dataclass(frozen=True)
class Hold:
    """How the start of a rod is held: whether joint 0 moves, the first link that moves, and
    whether a spring at joint 0 holds that link against clamp_angle."""

    translates: bool
    first: int
    root_spring: bool = False

    @property
    def least_links(self) -> int:
        """The fewest links with which something moves."""
        return self.first + 1


# What this release offers, in the order in which names list it.
BOUNDARIES = {
    "free": Hold(True, 0),
    "cantilever": Hold(False, 1),
    "clamped": Hold(False, 0, root_spring=True),
    "pinned": Hold(False, 0),
}
INERTIAS = ("uniform", "lumped")
THESIS_TERMS = ("follower", "gravity", "internal_damping", "external_damping")
TERMS = (*THESIS_TERMS, "tip_load")
TARGETS = ("numpy", "c")
FORMS = ("chain", "dense")
COLLOCATION = ("gauss", "radau")  # implicit methods that are compiled
MOST_LINKS = 10**6

# Parameters of a term, and of a boundary.
ROD_PARAMETERS = ("mass", "length", "bending_stiffness")
TERM_PARAMETERS = {
    "follower": ("follower_force", "follower_angle"),
    "gravity": ("gravity",),
    "internal_damping": ("internal_damping",),
    "external_damping": ("external_damping", "fin_factor"),
    "tip_load": ("tip_force_x", "tip_force_y"),
}
BOUNDARY_PARAMETERS: dict[str, tuple[str, ...]] = {
    "free": (),
    "cantilever": ("clamp_angle",),
    "clamped": ("clamp_angle",),
    "pinned": (),
}

# All of them in the order in which p holds them; fin_factor last, since it is many numbers.
PARAMETERS = (
    *ROD_PARAMETERS,
    *("follower_force", "follower_angle", "gravity", "internal_damping", "external_damping"),
    *("clamp_angle", "tip_force_x", "tip_force_y", "fin_factor"),
)
# Those that may be functions of time.
TIMED = ("follower_force", "tip_force_x", "tip_force_y")


@dataclass(frozen=True)
class Structure:
    """Links, boundary, inertia and terms of a module, checked.

    expressions: parameters that are functions of time, by name, as canonical text of the grammar
    in `scene.expression`; they are part of the code and no parameters of it.
    """

    links: int
    boundary: str = "free"
    inertia: str = "uniform"
    terms: tuple[str, ...] = THESIS_TERMS
    expressions: tuple[tuple[str, str], ...] = field(default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "links", plain(self.links, "links"))
        choose("boundary", self.boundary, BOUNDARIES)
        choose("inertia", self.inertia, INERTIAS)
        for term in self.terms:
            choose("terms", term, TERMS)
        check_links(self.links, self.boundary)
        ordered = tuple(term for term in TERMS if term in self.terms)
        if ordered != self.terms:
            object.__setattr__(self, "terms", ordered)
        timed = [name for name in TIMED if name in self._names]
        for name, _ in self.expressions:
            choose("expressions", name, timed or ["none: no term may change with time"])
        by_name = sorted(self.expressions, key=lambda pair: TIMED.index(pair[0]))
        object.__setattr__(self, "expressions", tuple(by_name))

    @property
    def hold(self) -> Hold:
        """How the start of the rod is held."""
        return BOUNDARIES[self.boundary]

    @property
    def _names(self) -> set[str]:
        """Parameters of the rod, its boundary and its terms, whether functions of time or not."""
        terms = {name for term in self.terms for name in TERM_PARAMETERS[term]}
        return terms.union(ROD_PARAMETERS, BOUNDARY_PARAMETERS[self.boundary])

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters, in the order in which p holds them; fin_factor last."""
        names = self._names - dict(self.expressions).keys()
        return tuple(name for name in PARAMETERS if name in names)

    @property
    def stem(self) -> str:
        """File name of the module in its default form and target, without its ending."""
        return self.module_stem()

    def module_stem(self, target: str = "numpy", form: str = "chain") -> str:
        """File name of a module of this structure, without its ending.

        Expressions are part of the code: with some, it ends in six letters of the hash, so that
        modules that differ in them have names and symbols of their own.
        """
        check_output(target, form)
        terms = "" if self.terms == THESIS_TERMS else "_" + ("_".join(self.terms) or "conservative")
        inertia = "" if self.inertia == "uniform" else f"_{self.inertia}"
        how = "" if form == "chain" else f"_{form}"
        where = "" if target == "numpy" else f"_{target}"
        timed = f"_{self.hash[:6]}" if self.expressions else ""
        return f"rod_{self.boundary}_n{self.links}{terms}{inertia}{how}{where}{timed}"

    @property
    def hash(self) -> str:
        """Content hash: equal for scenes that need the same code."""
        content = [self.links, self.boundary, self.inertia, self.terms, self.expressions]
        return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:16]


def parse_terms(text: str) -> tuple[str, ...]:
    """Terms from `all` (the thesis's four), `none` or a list with commas; raises SceneError."""
    if text == "all":
        return THESIS_TERMS
    if text in ("none", "conservative"):
        return ()
    names = [name.strip() for name in text.split(",")]
    for name in names:
        choose("terms", name, TERMS if "," in text else (*TERMS, "all", "none"))
    if len(set(names)) < len(names):
        raise SceneError("terms", text, "each term once")
    return tuple(term for term in TERMS if term in names)


def choose(field_name: str, value: object, allowed: Iterable[str]) -> None:
    """Raise SceneError unless the value is one of those allowed."""
    allowed = tuple(allowed)
    if value not in allowed:
        raise SceneError(field_name, value, "one of " + ", ".join(allowed))


def check_output(target: object, form: object) -> None:
    """Raise SceneError unless a module can be written for this target in this form."""
    choose("target", target, TARGETS)
    choose("form", form, FORMS)
    if target == "c" and form == "dense":
        raise SceneError("form", form, "chain for target c (target numpy has both)")


def check_links(links: object, boundary: str, field_name: str = "links") -> None:
    """Raise SceneError unless this many links can move under the boundary."""
    least = BOUNDARIES[boundary].least_links
    whole = links if isinstance(links, int) and not isinstance(links, bool) else -1
    if not least <= whole <= MOST_LINKS:
        held = "" if least == 1 else f" for boundary {boundary}"
        raise SceneError(field_name, links, f"a whole number from {least} to {MOST_LINKS}{held}")
