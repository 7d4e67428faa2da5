"""Pull by hand: a spring and a damper from a point of a link to a place that is moved.

To a module it is a support, whose parameters say on which link it is, and where: a module that has
a place for supports can be pulled anywhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from rodgen.errors import InputError
from rodgen.scene import Scene, Structure
from rodgen.scene.anchors import SAME
from rodgen.scene.plain_tables import is_number
from rodgen.scene.tables import SupportTable
from rodgen.system import System

SUPPORTS = "supports"  # the key of a scene, and the name of the term


@dataclass(frozen=True)
class Pull:
    """Pull on a point of a link, by number, at a share of it from 0 at its start to 1 at its end.
    to: far end [m]; stiffness [N/m]; damping [N s/m] of the point against the ground."""

    link: int
    share: float
    to: tuple[float, float]
    stiffness: float
    damping: float = 0.0


def with_idle_support(system: System | Scene) -> System:
    """System with a support that does nothing, unless it has supports: its module has a place for a
    pull."""
    system = System.of(system)
    has_place = SUPPORTS in system.structure.loads
    return system if has_place else system.at({SUPPORTS: [{"at": 1.0}]})


def with_pull(system: System, pull: Pull) -> System:
    """System with this pull, of one that has a place for it. Raises InputError."""
    scene, links = system.scene, system.scene.rod.links
    check_point("pull", pull.link, pull.share, links)
    for name, value in (("stiffness", pull.stiffness), ("damping", pull.damping)):
        if check_number(f"pull.{name}", value) < 0:
            raise InputError(f"pull.{name}", value, "not negative")
    to = [check_number("pull.to", part) for part in pull.to]
    at = float(scene.mesh.at(pull.link + pull.share))
    link, share = scene.mesh.link_and_share(at)
    if link < scene.boundary_condition.first:
        raise InputError("pull.link", pull.link, "one that moves")
    for tie in scene.anchors.support_points:
        if tie.link == link and abs(tie.share - share) > SAME:
            raise InputError("pull.link", pull.link, "one without a support at another point")
    each = {"stiffness": [pull.stiffness] * 2, "damping": [pull.damping] * 2}
    support = SupportTable(at=at, to=to, **each)
    return System(scene.model_copy(update={SUPPORTS: [*scene.supports, support]}))


def check_point(what: str, link: object, share: object, links: int) -> None:
    """Raise InputError unless link and share are those of a point of a rod with so many links."""
    if isinstance(link, bool) or not isinstance(link, int) or not 0 <= link < links:
        raise InputError(f"{what}.link", link, f"the number of a link, from 0 to {links - 1}")
    if not 0 <= check_number(f"{what}.share", share) <= 1:
        raise InputError(f"{what}.share", share, "from 0 at the start of the link to 1 at its end")


def check_number(field: str, value: Any) -> float:
    """Return a finite number as a float. Raises InputError."""
    if is_number(value) and math.isfinite(value):
        return float(value)
    raise InputError(field, value, "a finite number")


def widen_parameters(
    p: np.ndarray, of: Structure, wide: Structure, other: np.ndarray
) -> np.ndarray:
    """Parameters of a structure in the layout of `wide`, which has more of them; these are taken
    from `other`."""
    found = other.copy()
    here, there = of.slices, wide.slices
    for name, place in here.items():
        found[there[name]] = p[place]
    return found
