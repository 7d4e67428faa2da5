"""The forces in the joints of a rod that moves, by derivation 3.

The equations that keep the joint forces as unknowns (`implicit` of a generated module) are linear
in them and in the angular accelerations, block by block from link to link: in every state both
follow from one solve of O(n).
"""

from __future__ import annotations

from types import ModuleType

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate.blocks import solve


def forces_per_mass(model: ModuleType, t: Array, y: Array, p: Array) -> Array:
    """Forces with which every moving link pulls at the joint before it, over the mass of a link of
    an even rod, (..., cells, 2) [m/s^2]; not a number where a state is not.

    t: times [s], (...); y: states, (..., states); p: parameters. What loads do on a joint is done
    on the link before it, and in joint 0 of a free rod, which has none, the force is minus that;
    `start_loads` of a module is what they do on the link after it.
    """
    size = (y.shape[-1] - len(getattr(model, "STATES", ()))) // 2
    cells = size - 2 * ("x0" in model.STATE)
    times = np.broadcast_to(t, y.shape[:-1]).ravel()
    found = np.full((len(times), cells, 2), np.nan)
    at_rest, free = np.zeros(cells), np.zeros((cells, 2))
    for row, (at, state) in enumerate(zip(times, y.reshape(len(times), -1), strict=True)):
        residual, _, _, by_unknown, *_ = model.implicit(float(at), state, p, at_rest, free)
        if np.isfinite(residual).all() and np.isfinite(by_unknown).all():
            found[row] = -solve(by_unknown, residual.ravel()).reshape(cells, 3)[:, 1:]
    return found.reshape(*y.shape[:-1], cells, 2)
