"""A peer's rates for one number of links."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import rodgen
from rodgen.judge.costs.rod import VALUES
from rodgen.judge.precision.contestant import Array, NotModelledError
from rodgen.judge.timing import Batch


@dataclass(frozen=True)
class Prepared:
    """rhs: from the state to its rates, both in rodgen's order, which is what is checked; batch:
    calls of the peer's own function at the state last given to rhs, without any conversion of it,
    which is what is timed; in_c: whether they are made from C; setup: seconds of generation or
    compilation, as far as they are known."""

    rhs: Callable[[Array], Array]
    batch: Batch
    in_c: bool = False
    setup: dict[str, float] = field(default_factory=dict)


def rod(links: int) -> rodgen.Scene:
    """The scene: free, uniform, under thrust at an angle."""
    thrust = {"force": VALUES["follower_force"], "angle": VALUES["follower_angle"]}
    table = {name: VALUES[name] for name in ("mass", "length", "bending_stiffness")}
    return rodgen.Scene.from_dict(
        {"name": "rod", "rod": {"links": links, **table}, "loads": {"follower": thrust}}
    )


def at_most(who: str, links: int, most: int, why: str) -> None:
    """Raise NotModelledError for more links."""
    if links > most:
        raise NotModelledError(f"{who}: {why} for more than {most} links")
