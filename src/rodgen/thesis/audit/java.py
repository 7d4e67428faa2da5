"""The claims of the Java listing: appendix A, lines 1-681, and section 4.1, lines 705-1002.

    java_truth      what the methods must give beyond what truth has
    java_members    the class, its arrays and its initial state, as printed
    java_state      - their claims
    java_motion     updates of angles, coordinates, velocities, centre of gravity, and claims
    java_energies   energies, and claims
    java_matrices   M, Q, K, C, and claims
    java_damping    external damping
    java_drag       - its claims
    java_forces     loads, right side, solution, and claims
    java_steps      the steppers, and what puts them right
    java_schemes    - the claims of what they are
    java_getters    what the program hands out, and claims
    java_steppers   - their orders, measured

Lines are those of the listing; where the scan has given a number to the rest of a wrapped line,
that of its beginning. Pages and wrapped lines are joined. The elimination that getSolution
(607-614) calls is of a library that is not printed, and is left out.
"""

from __future__ import annotations

from . import (
    java_drag,
    java_energies,
    java_forces,
    java_getters,
    java_matrices,
    java_motion,
    java_schemes,
    java_state,
)
from .claim import Claim
from .java_steppers import Order, stepper_orders

CLAIMS: tuple[Claim, ...] = (
    *java_state.CLAIMS,
    *java_motion.CLAIMS,
    *java_energies.CLAIMS,
    *java_matrices.CLAIMS,
    *java_forces.CLAIMS,
    *java_drag.CLAIMS,
    *java_getters.CLAIMS,
    *java_schemes.CLAIMS,
)

__all__ = ["CLAIMS", "Order", "stepper_orders"]
