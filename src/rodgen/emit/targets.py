"""Targets of generation, and the parts of their modules that can be generated alone.

Every folder beside this file is a target, known everywhere by the name of the folder.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

from rodgen.errors import InputError
from rodgen.scene.term_texts import check_choice

# The names that a part brings into the Python module; flow and newton are for compiled steps,
# VARIATIONS for those of a state with its tangents, lanes are for those of many rods side by side.
PARTS = {
    "rhs": ("rhs",),
    "batch": ("rhs_batch",),
    "jac": ("jac",),
    "inputs": ("inputs", "outputs", "INPUTS"),
    "mass": ("mass_matrix",),
    "balance": ("balance",),
    "implicit": ("implicit",),
    "power": ("power",),
    "quantities": (
        *("energy", "joints", "centre_of_gravity", "inertia"),
        *("bending_moments", "forces", "generalised_force", "contacts", "air"),
        *("signals", "velocities"),
    ),
    "kinetics": (
        *("momentum", "angular_momentum", "reaction_moment", "support_forces"),
        *("start_loads", "curvatures"),
    ),
    "tangents": ("tangents", "VARIATIONS"),
    "flow": ("Run", "WORKS"),
    "newton": ("NEWTON",),
    "lanes": ("LANES",),
}
# Written for NumPy, whatever the target.
COMMON = ("mass", "balance", "implicit", "power", "quantities", "kinetics")
STEPS = ("flow", "newton")
ASKED = (
    *STEPS,
    "inputs",
    "kinetics",
    "tangents",
    "lanes",
    "balance",
)  # what nobody has who does not ask for it
PART_OF = {name: part for part, names in PARTS.items() for name in names}
FORMS = ("chain", "dense")


@dataclass(frozen=True)
class Target:
    """A target of generation: the object TARGET of a folder.

    templates: by form, then by ending of the file, the Python module's first; parts: what it has
    besides COMMON; programs: from Functions, form and parts, its functions by name and what else
    its templates need; compiled: whether native/ builds its modules and takes their steps.
    """

    templates: Mapping[str, Mapping[str, str]]
    parts: tuple[str, ...]
    programs: Callable[..., tuple[Mapping[str, Any], Mapping[str, Any]]]
    compiled: bool = False


_FOLDERS = [found.name for found in iter_modules([str(Path(__file__).parent)]) if found.ispkg]
TARGETS = tuple(sorted(_FOLDERS, key=lambda name: (name != "numpy", name)))


@cache
def target_of(name: str) -> Target:
    """A target by its name. Raises InputError where there is none."""
    check_choice("target", name, TARGETS)
    target: Target = import_module(f"rodgen.emit.{name}").TARGET
    return target


def check_output(target: str, form: str) -> None:
    """Raise InputError unless a module can be written for this target in this form."""
    forms = target_of(target).templates
    if form not in forms:
        check_choice("form", form, FORMS)
        allowed = f"{', '.join(forms)} for target {target} (target numpy has both)"
        raise InputError("form", form, allowed)


def available_parts(target: str) -> tuple[str, ...]:
    """Parts that a target has."""
    return tuple(part for part in PARTS if part in (*target_of(target).parts, *COMMON))


def required_parts(
    target: str, parts: Iterable[str] | None = None, steps: bool = False
) -> tuple[str, ...]:
    """Parts with all that they need, in the order of PARTS; all but those of ASKED, if none are
    given. Raises InputError for a part that the target does not have."""
    allowed = available_parts(target)
    wanted = {part for part in allowed if part not in ASKED} if parts is None else set(parts)
    for part in wanted:
        if part not in allowed:
            raise InputError("parts", part, f"of {', '.join(allowed)}")
    if steps and not target_of(target).compiled:
        raise InputError("with_steps", True, "given with target c: NumPy modules take no steps")
    if "batch" in wanted:
        wanted.add("rhs")
    if "tangents" in wanted and not target_of(target).compiled:
        wanted.add("jac")
    if steps:
        wanted |= set(STEPS)
    return tuple(part for part in allowed if part in wanted)
