"""Lyapunov exponents that are zero for every motion, by symmetries and conserved quantities.

A change of the state along the motion itself, or by a displacement or a turn that the equations do
not see, neither grows nor dies out; nor does a change of what is kept (energy, momentum).
"""

from __future__ import annotations

from types import ModuleType

from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.model.term import ANCHOR, DRAG
from rodgen.model.terms import TERMS
from rodgen.scene import Scene

ALIKE = ("external_damping",)  # drag that does not depend on the direction of the ground


def is_autonomous(scene: Scene) -> bool:
    """Whether no load, state, mass or spring of a scene depends on the time."""
    return not any(e.has_variable for e in scene.time_functions.all)


def is_conservative(scene: Scene, model: ModuleType) -> bool:
    """Whether a scene conserves its energy."""
    return is_autonomous(scene) and not loads_at_work(model) and not scene.states


def zero_exponents(scene: Scene, model: ModuleType) -> dict[str, int]:
    """Number of zero exponents of a scene, by reason; where it comes to rest there may be fewer
    that are due to the time. Sensors are taken to see every place."""
    found = {"time": 1} if is_autonomous(scene) else {}
    conservative = is_conservative(scene, model)
    if conservative:
        found["energy"] = 1
    if scene.time_functions.fed or scene.states:
        return found
    terms = [TERMS[name] for name in scene.structure.terms]
    anchored = any(term.kind == ANCHOR for term in terms)
    directed = [
        t for t in terms if not (t.follows or t.is_damping or t.name == "distributed_follower")
    ]
    blind = not (anchored or directed or any(t.kind == DRAG and t.name not in ALIKE for t in terms))
    moves = scene.boundary_condition.translates
    if moves and not anchored:
        found["place"] = 2
        # The centre falls freely beside all other motion.
        if conservative and not any(term.name == "tip_load" for term in terms):
            found["momentum"] = 2
    turns = moves or scene.rod.boundary == "pinned"
    if blind and turns:
        found["direction"] = 1
        if conservative:
            found["angular momentum"] = 1
    return found
