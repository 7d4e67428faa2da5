"""The comparisons that prove a structure's equations, in the order in which they are made."""

from __future__ import annotations

from collections.abc import Iterator

from rodgen.derive.comparison import Comparison, DisagreementError
from rodgen.derive.points import prove_at_points
from rodgen.derive.proof_any_n import prove_any_n
from rodgen.derive.proof_explicit import prove_explicit
from rodgen.derive.proof_joint_forces import prove_joint_forces
from rodgen.scene.structure import Structure

__all__ = ["Comparison", "DisagreementError", "comparisons"]


def comparisons(structure: Structure, explicit: bool, most_joints: int) -> Iterator[Comparison]:
    """Derivation 2 for any n, then derivation 1 at n links or, where ``explicit`` is not wanted,
    exact evaluation at random rational points, then derivation 3 at so many links at most; raises
    DisagreementError."""
    what = (structure.boundary, structure.inertia, structure.terms)
    yield from prove_any_n(*what)
    if explicit:
        yield from prove_explicit(structure.links, *what)
    else:
        yield from prove_at_points(structure.links, *what)
    yield from prove_joint_forces(min(structure.links, most_joints), *what)
