"""What a result file and a Dataset hold: names, dimensions, units."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.changes import Changes
from rodgen.integrate.solution import Solution
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene

UNITS = {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s", "phi_": "rad", "omega_": "rad/s"}
WORK = "work_"  # and the name of the term
PARAMETERS, GIVEN = "parameters", "energy_given"  # of a run that was changed while it went on


class Quantity(NamedTuple):
    """Values over dimensions, with their attributes: units, long_name."""

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, str]


def quantities(solution: Solution) -> dict[str, Quantity]:
    """All of a solution that changes with time, by name; work by load as work_<term>."""
    energy, inertia = solution.energy, solution.inertia
    in_time, by_link = over_time(), over_time("link")
    found = {
        "time": Quantity(("time",), solution.t, {"units": "s"}),
        "y": Quantity(("time", "state"), solution.y, {"long_name": "state"}),
        "phi": by_link(solution.phi, "rad", "angles of the links"),
        "omega": by_link(solution.omega, "rad/s", "rates of the links"),
        "joints": over_time("joint", "axis")(solution.joints, "m", "positions of the joints"),
        "centre_of_gravity": over_time("axis")(
            solution.centre_of_gravity, "m", "centre of gravity"
        ),
        "kinetic_energy": in_time(energy.kinetic, "J", "kinetic energy"),
        "spring_energy": in_time(energy.spring, "J", "energy of the springs"),
        "gravity_energy": in_time(energy.gravity, "J", "energy in gravity"),
        "energy_balance": in_time(solution.energy_balance, "J", "energy gained less work done"),
        "inertia_x": in_time(inertia.x, "kg m2", "moment of inertia about x"),
        "inertia_y": in_time(inertia.y, "kg m2", "moment of inertia about y"),
        "product_xy": in_time(inertia.xy, "kg m2", "product of inertia"),
    }
    for term, values in solution.work.items():
        found[WORK + term] = in_time(values, "J", f"work of {term.replace('_', ' ')}")
    if solution.changes is not None:
        changes = solution.changes
        held = {"long_name": "parameters that held"}
        found[PARAMETERS] = Quantity(("time", "parameter"), changes.p, held)
        found[GIVEN] = in_time(changes.given, "J", "energy that changes and kicks have put in")
    return found


def derived(solution: Solution) -> dict[str, Quantity]:
    """What a Dataset has beside these, and no file, since it follows from what is there."""
    axes, in_time = solution.principal_axes, over_time()
    forces = {
        f"force_{term}": over_time("joint", "axis")(
            values, "N", f"force of {term.replace('_', ' ')} on the joints"
        )
        for term, values in solution.forces.items()
    }
    return {
        **forces,
        "bending_moments": over_time("joint")(
            solution.bending_moments, "N m", "bending moments in the joints"
        ),
        "tip": over_time("axis")(solution.tip, "m", "position of the tail"),
        "total_energy": in_time(solution.energy.total, "J", "energy"),
        "principal_angle": in_time(axes.angle, "rad", "axis of the smaller moment of inertia"),
        "principal_moments": over_time("principal")(
            axes.moments, "kg m2", "principal moments of inertia"
        ),
    }


def over_time(*dimensions: str) -> Callable[[Array, str, str], Quantity]:
    """Makes quantities over time and these dimensions, of values, unit and long name."""
    return lambda values, unit, name: Quantity(
        ("time", *dimensions), values, {"units": unit, "long_name": name}
    )


def state_units(states: Sequence[str]) -> list[str]:
    """Units of the states with these names."""
    return [UNITS[name.rstrip("0123456789")] for name in states]


def parameter_names(scene: Scene) -> list[str]:
    """What the columns of parameters are; fin factors by joint."""
    joints = [f"fin_factor_{joint}" for joint in range(scene.rod.links + 1)]
    names = scene.structure.parameters
    return [label for name in names for label in (joints if name == "fin_factor" else [name])]


def changes_in(
    records: NDArray[Any], kept: NDArray[np.intp] | slice = slice(None)
) -> Changes | None:
    """What was changed in the run of these records of a file, of some of them alone."""
    if PARAMETERS not in (records.dtype.names or ()):
        return None
    return Changes(plain(records[PARAMETERS][kept]), plain(records[GIVEN][kept]))


def plain(values: NDArray[Any]) -> Array:
    """A copy, C-contiguous and in the byte order of this machine."""
    return np.array(values, dtype=float, order="C")


def event_variables(number: NDArray[Any], t: Array, y: Array) -> dict[str, Quantity]:
    """Events by number of their kind in the scene, (E,), times, (E,), and states, (E, S)."""
    return {
        "event_number": Quantity(("event",), number.astype("i4"), {"long_name": "kind of event"}),
        "event_time": Quantity(("event",), t, {"units": "s", "long_name": "time of event"}),
        "event_y": Quantity(("event", "state"), y, {"long_name": "state at event"}),
    }
