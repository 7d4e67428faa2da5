"""Comparisons that prove a structure: any_n for every number of links, explicit_proof by entries
with LagrangesMethod, rational_points in exact numbers, joint_force_proof for derivation 3."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..comparison import Comparison, DisagreementError
from .any_n import prove_any_n
from .explicit_proof import prove_explicit
from .joint_force_proof import prove_joint_forces
from .rational_points import prove_at_points

__all__ = ["Comparison", "DisagreementError", "comparisons"]


def comparisons(
    links: int,
    boundary: str,
    inertia: str,
    terms: Sequence[str],
    explicit: bool,
    most_joints: int,
    nonuniform: Sequence[str] = (),
) -> Iterator[Comparison]:
    """Compare derivation 2 for any n, then derivation 1 at n links or, without ``explicit``, exact
    values at random rational points, then derivation 3 at up to ``most_joints`` links; raises
    DisagreementError."""
    yield from prove_any_n(boundary, inertia, terms, nonuniform)
    prove = prove_explicit if explicit else prove_at_points
    yield from prove(links, boundary, inertia, terms, nonuniform)
    yield from prove_joint_forces(min(links, most_joints), boundary, inertia, terms, nonuniform)
