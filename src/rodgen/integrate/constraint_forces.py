"""Forces in the joints of a moving rod, by derivation 3.

The equations that keep the joint forces as unknowns (`implicit` of a generated module) are linear
in them and in the angular accelerations, block by block from link to link: in every state both
follow from one solve of O(n).
"""

from __future__ import annotations

from types import ModuleType

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate.block_tridiagonal import solve_blocks


def forces_per_mass(model: ModuleType, t: Array, y: Array, p: Array) -> Array:
    """Joint forces over the mass of a link of a uniform rod, (..., cells, 2) [m/s^2]: every moving
    link pulls with them at the joint before it. Not-a-number for states that are not finite.

    t: times [s], (...); y: states, (..., states); p: parameters. Loads on a joint act on the link
    before it. Joint 0 of a free rod has none, and the force there is minus the load; `start_loads`
    of a module are the forces of these loads on the link after the joint.
    """
    size = (y.shape[-1] - len(getattr(model, "STATES", ()))) // 2
    cells = size - 2 * ("x0" in model.STATE)
    times = np.broadcast_to(t, y.shape[:-1]).ravel()
    found = np.full((len(times), cells, 2), np.nan)
    at_rest, free = np.zeros(cells), np.zeros((cells, 2))
    for row, (at, state) in enumerate(zip(times, y.reshape(len(times), -1), strict=True)):
        residual, _, _, by_unknown, *_ = model.implicit(float(at), state, p, at_rest, free)
        if np.isfinite(residual).all() and np.isfinite(by_unknown).all():
            found[row] = -solve_blocks(by_unknown, residual.ravel()).reshape(cells, 3)[:, 1:]
    return found.reshape(*y.shape[:-1], cells, 2)
