"""Couples on a rod and their points, as pictures show them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate.quantity_formulas import Motion
from rodgen.model.term import COUPLE
from rodgen.model.terms import TERMS, load_places
from rodgen.scene.rod_mesh import parse_place


def couples_of(motion: Motion, terms: Iterable[str]) -> dict[str, Array]:
    """Point of each couple, x and y [m], and its moment [N m], (..., 3), by name; terms: of the
    structure."""
    joints, found = motion.values("joints"), {}
    for name, place in load_places(terms).items():
        if TERMS[name].kind == COUPLE:
            (size,) = TERMS[name].size_parameters
            moment = motion.values(size.name)[..., None]
            found[name] = np.concatenate((point_at(place, joints), moment), axis=-1)
    return found


def point_at(place: str, joints: Array) -> Array:
    """Point (..., 2) at a place, as a structure names it, of a rod with these joints."""
    link, share = parse_place(place, joints.shape[-2] - 1)
    found: Array = (1 - share) * joints[..., link, :] + share * joints[..., link + 1, :]
    return found
