"""Accelerations by which loads on mass pull, as vectors."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate.quantity_formulas import Motion
from rodgen.model.term import WEIGHT, Term
from rodgen.model.terms import rows_of


def falls_of(motion: Motion, terms: Iterable[str]) -> dict[str, Array]:
    """Acceleration of free fall [m/s^2], x and y, (..., 2), by the name of each load on mass;
    terms: of the structure."""
    rows = (row for row in rows_of(terms).values() if row.kind == WEIGHT)
    return {row.name: fall_of(row, motion.values) for row in rows}


def fall_of(row: Term, value: Callable[[str], Any]) -> Array:
    """Acceleration of free fall by a load on mass, (..., 2): that of its parameters, or one
    downwards; value: of a parameter, by its name."""
    *x, y = (np.asarray(value(one.name)) for one in row.size_parameters)
    return np.stack(np.broadcast_arrays(x[0], y) if x else (0 * y, -y), axis=-1)
