"""What one link and one spring have of the rod: m, l, k.

The length and the stiffness are asked of the generated module: how far apart its joints are, and
which moment an angle of 1 rad makes. The mass of the rod is spread evenly over its links.
"""

from __future__ import annotations

from functools import lru_cache
from types import ModuleType
from typing import NamedTuple

import numpy as np

from rodgen.integrate.stepper import Array
from rodgen.scene.structure import BOUNDARIES


class PerLink(NamedTuple):
    """mass [kg] and length [m] of a link; stiffness of the spring in every joint [N m/rad], (n+1,),
    zero where there is none."""

    mass: float
    length: float
    stiffness: Array


def per_link(model: ModuleType, p: Array) -> PerLink:
    """For the parameters p of a generated module."""
    return _kept(model, p.tobytes())


@lru_cache(maxsize=16)
def _kept(model: ModuleType, parameters: bytes) -> PerLink:
    """Asked for again and again with the same parameters."""
    p, hold = np.frombuffer(parameters), BOUNDARIES[model.BOUNDARY]
    clamp = p[model.PARAMETERS.index("clamp_angle")] if "clamp_angle" in model.PARAMETERS else 0.0
    # Every link turned by 1 rad from the one before; the first from a clamp with a spring.
    turned = np.zeros(len(model.STATE))
    first = 2 * hold.translates
    turned[first : len(turned) // 2] = np.arange(hold.first, model.N) + hold.root_spring + clamp
    joints = model.joints(turned, p)[-2:]
    return PerLink(
        mass=float(p[model.PARAMETERS.index("mass")]) / model.N,
        length=float(np.linalg.norm(joints[1] - joints[0])),
        stiffness=model.bending_moments(turned, p),
    )
