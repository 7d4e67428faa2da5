"""What a generated module is specialised to: no values, only what is there and what is not."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, field

from rodgen.scene.errors import SceneError


@dataclass(frozen=True)
class Hold:
    """How the start of a rod is held: whether joint 0 moves, and the first link that moves."""

    translates: bool
    first: int

    @property
    def least_links(self) -> int:
        """The fewest links with which something moves."""
        return self.first + 1


# What this release offers, in the order in which names list it.
BOUNDARIES = {"free": Hold(True, 0), "cantilever": Hold(False, 1)}
INERTIAS = ("uniform",)
TERMS = ("follower", "gravity", "internal_damping", "external_damping")
TARGETS = ("numpy",)
MOST_LINKS = 10**6

# Parameters of a term, and of a boundary, in the order in which p holds them.
ROD_PARAMETERS = ("mass", "length", "bending_stiffness")
TERM_PARAMETERS = {
    "follower": ("follower_force", "follower_angle"),
    "gravity": ("gravity",),
    "internal_damping": ("internal_damping",),
    "external_damping": ("external_damping", "fin_factor"),
}
BOUNDARY_PARAMETERS: dict[str, tuple[str, ...]] = {"free": (), "cantilever": ("clamp_angle",)}


@dataclass(frozen=True)
class Structure:
    """Links, boundary, inertia and terms of a module, checked.

    expressions: parameters that are functions of time, by name, as canonical text of the grammar
    in `scene.expression`; they are part of the code and no parameters of it.
    """

    links: int
    boundary: str = "free"
    inertia: str = "uniform"
    terms: tuple[str, ...] = TERMS
    expressions: tuple[tuple[str, str], ...] = field(default=())

    def __post_init__(self) -> None:
        choose("boundary", self.boundary, BOUNDARIES)
        choose("inertia", self.inertia, INERTIAS)
        for term in self.terms:
            choose("terms", term, TERMS)
        check_links(self.links, self.boundary)
        ordered = tuple(term for term in TERMS if term in self.terms)
        if ordered != self.terms:
            object.__setattr__(self, "terms", ordered)

    @property
    def hold(self) -> Hold:
        """How the start of the rod is held."""
        return BOUNDARIES[self.boundary]

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters, in the order in which p holds them; fin_factor last."""
        names = [*ROD_PARAMETERS]
        for term in self.terms:
            names += TERM_PARAMETERS[term]
        names += BOUNDARY_PARAMETERS[self.boundary]
        known = dict(self.expressions)
        names.sort(key=lambda name: name == "fin_factor")
        return tuple(name for name in names if name not in known)

    @property
    def stem(self) -> str:
        """File name of the module, without its ending."""
        terms = "" if self.terms == TERMS else "_" + ("_".join(self.terms) or "conservative")
        inertia = "" if self.inertia == "uniform" else f"_{self.inertia}"
        return f"rod_{self.boundary}_n{self.links}{terms}{inertia}"

    @property
    def hash(self) -> str:
        """Content hash: equal for scenes that need the same code."""
        content = [self.links, self.boundary, self.inertia, self.terms, self.expressions]
        return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:16]


def parse_terms(text: str) -> tuple[str, ...]:
    """Terms from `all`, `none` or a list with commas; raises SceneError."""
    if text == "all":
        return TERMS
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


def check_links(links: object, boundary: str, field_name: str = "links") -> None:
    """Raise SceneError unless this many links can move under the boundary."""
    least = BOUNDARIES[boundary].least_links
    whole = links if isinstance(links, int) and not isinstance(links, bool) else -1
    if not least <= whole <= MOST_LINKS:
        held = "" if least == 1 else f" for boundary {boundary}"
        raise SceneError(field_name, links, f"a whole number from {least} to {MOST_LINKS}{held}")
