"""Small motions of rods with links without mass: those of what has inertia, and links that buckle
between what has, which nothing slows down.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from rodgen.analyse.eigenvalues import all_eigenvalues, all_shapes, is_regular, slow_rate
from rodgen.analyse.massless import RegularPencil, regular_pencil
from rodgen.analyse.modal import (
    NONE,
    ModalEquations,
    ModalMotions,
    NeutralMotions,
    growth_beyond_rounding,
    motions_of_matrix,
)
from rodgen.analyse.pencil import DensePencil
from rodgen.arrays import Array

RIGID = 1e-4  # of the rate of a rod that bends evenly: less is a rigid motion
EVEN = 1e6  # condition of a mass matrix by which first-order matrices keep their digits


def light_motions(
    here: RegularPencil, lowest: float, neutral: NeutralMotions = NONE
) -> ModalMotions:
    """Compute the motions of a reduced pencil; of links that buckle s and growth are infinite.
    lowest: the lowest frequency [rad/s]."""
    dense = here.pencil
    own = dense.size - dense.added
    if neutral.steps and np.linalg.cond(dense.S2[:own, :own]) < EVEN:
        found = motions_of_matrix(neutral.reduce(first_order(dense, lowest, even=False)))
    elif is_regular(dense.S0):
        squares, shapes = all_shapes(dense, light=True)
        K, C, M = (part[None] for part in dense.project(shapes).parts)
        frequencies = np.maximum(np.sqrt(np.abs(squares)), lowest)
        modal = ModalEquations(K, C, M, frequencies, NONE, dense.added, by_inverse=True)
        (found,) = modal.motions().split()
    else:
        s = all_eigenvalues(dense, zeros=sum(neutral.steps)).s
        found = ModalMotions(s, growth_beyond_rounding(s, lowest))
    at_once = np.full(here.n_buckled, np.inf)
    return ModalMotions(np.append(found.s, at_once), np.append(found.growth, at_once))


def shapes_with_inertia(whole: DensePencil, inertia: float) -> tuple[Array, Array]:
    """Squared frequencies [1/s^2] and shapes, in columns, of the motions with inertia, without
    damping; inertia: a size of that of the rod."""
    return all_shapes(regular_pencil(whole.without_damping, inertia).pencil, light=True)


def lowest_light_rate(whole: DensePencil, inertia: float) -> float:
    """Lowest of the frequencies that are none of a rigid motion [rad/s], or the rate at which a rod
    with all of this inertia would bend evenly."""
    rates = np.sqrt(np.abs(shapes_with_inertia(whole, inertia)[0]))
    even = slow_rate(whole.without_damping)  # beside rates that are as fast as you like
    return float(rates[rates > RIGID * even].min(initial=even))


def first_order(dense: DensePencil, rate: float, even: bool = True) -> Array:
    """First-order matrix of a dense pencil, with its coordinates in units of rate [1/s]. even: with
    another mass matrix, which has no part in what has a rate of zero."""
    K, C, M = (part[None] for part in dense.parts)
    own = dense.size - dense.added
    rates = np.full(own, rate)
    if even:
        M = np.zeros_like(M)
        M[:, range(own), range(own)] = np.trace(dense.S2) / own
    return np.asarray(ModalEquations(K, C, M, rates, NONE, dense.added).first_order_matrices()[0])


def neutral_motions_of(pencils: Iterable[DensePencil], rate: float) -> NeutralMotions:
    """Neutral motions common to dense pencils, where these are of one size."""
    found = list(pencils)
    if len({one.size for one in found}) != 1:
        return NONE
    return NeutralMotions.of(first_order(one, rate) for one in found)
