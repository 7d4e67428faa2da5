"""External damping as scalar expressions: at joint i the force -c_ext s_i a_i m_i v_i, where a_i is
the share of the velocity v_i across the rod, whose angle there is the mean of the links that meet.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import rodgen
from rodgen.judge.peers.chain import Function, Pair


def forces(
    scene: rodgen.Scene,
    given: Mapping[str, Any],
    phi: Sequence[Any],
    omega: Sequence[Any],
    velocity: Pair,
    functions: Mapping[str, Function],
    or_one: Callable[[Any], Any],
) -> list[Pair]:
    """At the joints of the links that move, in m l.

    velocity: of the first of these joints; functions: cos, sin, sqrt and abs; or_one: its
    argument where that is positive, else 1.
    """
    if "external_damping" not in scene.structure.terms:
        return []
    held, l = scene.held, given["length"] / scene.rod.links
    vx, vy = velocity
    found: list[Pair] = []
    for joint in range(len(phi) + 1):
        if joint:
            turn = l * omega[joint - 1]
            vx = vx - turn * functions["sin"](phi[joint - 1])
            vy = vy + turn * functions["cos"](phi[joint - 1])
        elif not scene.hold.translates:
            found.append((0.0, 0.0))
            continue
        meet = phi[max(0, joint - 1) : joint + 1]
        angle, mass = sum(meet) / len(meet), len(meet) / 2
        across = functions["abs"](vy * functions["cos"](angle) - vx * functions["sin"](angle))
        factor = given["external_damping"] * given["fin_factor"][held + joint] * mass / l
        share = -factor * across / functions["sqrt"](or_one(vx * vx + vy * vy))
        found.append((share * vx, share * vy))
    return found
