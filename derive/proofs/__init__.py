"""Comparisons that prove a structure: any_n for every number of links, explicit entry by entry
with LagrangesMethod, points in rational numbers, joint_forces for derivation 3."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .any_n import prove_any_n
from .comparison import Comparison, DisagreementError
from .explicit import prove_explicit
from .joint_forces import prove_joint_forces
from .points import prove_at_points

__all__ = ["Comparison", "DisagreementError", "comparisons"]


def comparisons(
    links: int,
    boundary: str,
    inertia: str,
    terms: Sequence[str],
    explicit: bool,
    most_joints: int,
    uneven: Sequence[str] = (),
) -> Iterator[Comparison]:
    """Derivation 2 for any n, then derivation 1 at n links or, where ``explicit`` is not wanted,
    exact evaluation at random rational points, then derivation 3 at so many links at most; raises
    DisagreementError."""
    yield from prove_any_n(boundary, inertia, terms, uneven)
    prove = prove_explicit if explicit else prove_at_points
    yield from prove(links, boundary, inertia, terms, uneven)
    yield from prove_joint_forces(min(links, most_joints), boundary, inertia, terms, uneven)
