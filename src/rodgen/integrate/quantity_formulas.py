"""Formulas of the quantities of a motion, from functions of the generated module and each other.

Their names, and who shows them, stand in model/quantities.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property, lru_cache
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import did_you_mean
from rodgen.integrate.constraint_forces import forces_per_mass
from rodgen.loading.generated_module import ModuleFunction, call_module, structure_of
from rodgen.model.quantities import (
    CONTACTS,
    FORCES,
    IN_AIR,
    JOINT_CONTACTS,
    QUANTITIES,
    Quantity,
)
from rodgen.model.rod import CLAMP_ANGLE, Boundary
from rodgen.model.terms import BASE_ANGLE, PARAMETERS, TERMS, describe
from rodgen.scene.expression import Expression

TURN = 1e-5  # rad, by which the links turn in a difference: errors are its square, and eps over it


class PrincipalAxes(NamedTuple):
    """Principal axes of inertia. angle: from the x axis to the axis of the smaller moment [rad], in
    (-pi/2, pi/2], (T,); moments: the smaller and the larger principal one [kg m^2], (T, 2)."""

    angle: Array
    moments: Array


def principal_axes(x: Array, y: Array, xy: Array) -> PrincipalAxes:
    """Principal axes of moments about x and y and the product of inertia [kg m^2], each (...)."""
    tensor = np.stack((np.stack((x, -xy), -1), np.stack((-xy, y), -1)), -2)
    moments, axes = np.linalg.eigh(tensor)
    angle = np.arctan2(axes[..., 1, 0], axes[..., 0, 0])
    # An axis has no direction: of its two angles the one in (-pi/2, pi/2].
    angle = np.where(angle > np.pi / 2, angle - np.pi, angle)
    angle = np.where(angle <= -np.pi / 2, angle + np.pi, angle)
    return PrincipalAxes(angle, moments)


class Motion:
    """States over time, and the quantities that follow from them.

    t: times [s], (...); y: states, (..., states); work: of each load without potential since the
    start [J], by term, each (...); boundary_condition: how the rod's start is held; extra_states:
    names of the states that are neither positions nor velocities; time_dependent_loads: loads that
    change with time, by the names of their parameters; has_feedback: whether the module has sensors
    or loads that follow the motion; energy_input: what changes and kicks have put in since the
    start [J], (...) or a number; start_energy: at the start [J]. Trajectory and MotionSlice have
    all of these, and `parameter`, `has_parameter` and `evaluate`.
    """

    t: Array
    y: Array
    work: Mapping[str, Array]
    boundary_condition: Boundary
    extra_states: tuple[str, ...]
    time_dependent_loads: Mapping[str, Expression]
    has_feedback: bool
    energy_input: Array | float
    start_energy: float  # subclasses may have cached properties of these names

    def parameter(self, name: str) -> Array | float:
        """A parameter of the module that is a number, (...) or one for all samples."""
        raise NotImplementedError

    def has_parameter(self, name: str) -> bool:
        """Whether the module has a parameter of this name."""
        raise NotImplementedError

    def evaluate(self, function: str | ModuleFunction, *arrays: Array) -> Any:
        """Call a function of the module (see call_module) on arrays over the samples and the
        parameters: an array, (..., parts) of several results, or a dictionary of arrays by term."""
        raise NotImplementedError

    def values(self, name: str) -> Any:
        """Values of a quantity in SI units, one row for each state; computed once.

        name: as the page of quantities in the reference has it, such as "tip", "axial_force" or
        "total_energy".

        Raises KeyError for a name that is no quantity, or none of a rod with this boundary.
        """
        found = self._cache.get(name)
        if found is None:
            only, boundary = ONLY.get(name), self.boundary_condition
            if only and not getattr(boundary, only):
                raise KeyError(f"{name} is no quantity of a rod that is {boundary.title}")
            found = self._cache[name] = _compute(self, name)
        return found

    @cached_property
    def _cache(self) -> dict[str, Any]:
        return {}

    def names(self, quantity: Quantity) -> Iterator[tuple[str, str]]:
        """Names and words of the quantities of a row: one for each load, or itself.

        quantity: a row of QUANTITIES.
        """
        if not quantity.each:
            yield quantity.name, quantity.words
            return
        for term in self._terms(quantity.each):
            yield quantity.name.format(term), quantity.words.format(describe(term))

    def _terms(self, each: str) -> Iterable[str]:
        """Names of the loads that there is a quantity for each of."""
        if each in (CONTACTS, JOINT_CONTACTS):
            depths = (name for name in self.values("contacts") if name.startswith("depth_"))
            names = (name.removeprefix("depth_") for name in depths)
            return [x for x in names if TERMS[x].at_joints == (each == JOINT_CONTACTS)]
        if each == IN_AIR:
            speeds = (name for name in self.values("air") if name.startswith("airspeed_"))
            return [name.removeprefix("airspeed_") for name in speeds]
        return self.values("forces") if each == FORCES else self.work


class MotionSlice(Motion):
    """Motion with constant parameters p; y may have any leading axes. Arguments that only some
    quantities need can be left out."""

    def __init__(
        self,
        model: ModuleType,
        p: Array,
        y: Array,
        t: Array | None = None,
        work: Mapping[str, Array] | None = None,
        given: float = 0.0,
        start_energy: float = 0.0,
        timed: Mapping[str, Expression] | None = None,
    ):
        self.model, self.p, self.y = model, p, y
        self.boundary_condition = structure_of(model).boundary_condition
        self.extra_states = tuple(getattr(model, "STATES", ()))
        self.t = np.zeros(y.shape[:-1]) if t is None else t
        self.work, self.time_dependent_loads = work or {}, timed or {}
        self.energy_input, self.start_energy = given, start_energy

    @cached_property
    def has_feedback(self) -> bool:  # type: ignore[override]
        return structure_of(self.model).has_feedback

    def parameter(self, name: str) -> float:
        """A parameter of the module that is a number; 0 for one that it does not have."""
        names = self.model.PARAMETERS
        return float(self.p[names.index(name)]) if name in names else 0.0

    def has_parameter(self, name: str) -> bool:
        return name in self.model.PARAMETERS

    def evaluate(self, function: str | ModuleFunction, *arrays: Array) -> Any:
        return stack_parts(call_module(self.model, function, self.t, *arrays, self.p))


def stack_parts(found: Any) -> Any:
    """Result of a function of a module, with several arrays joined along a last axis; one array or
    a dictionary of arrays by term stays as it is."""
    if isinstance(found, tuple):
        return np.stack(np.broadcast_arrays(*found), -1)
    return found


@lru_cache(maxsize=16)
def loads_at_work(model: ModuleType) -> tuple[str, ...]:
    """Names of the loads without potential of a module, whose work is integrated."""
    if not hasattr(model, "power"):
        return ()
    y, p = np.zeros(len(model.STATE)), np.ones(len(model.PARAMETERS))
    with np.errstate(all="ignore"):  # their names are asked for, whatever their powers are
        return tuple(call_module(model, "power", 0.0, 0.0, y, p))


def _compute(motion: Motion, name: str) -> Any:
    """Compute a quantity. Raises KeyError for a name that no motion has."""
    if name in FORMULAS:
        return FORMULAS[name](motion)
    if name in PARAMETERS:
        return _load(motion, name)
    prefix, _, term = name.partition("_")
    if prefix in OF_A_LOAD:
        return OF_A_LOAD[prefix](motion, term)
    signals = motion.values("signals")
    if name not in signals:
        raise KeyError(f"{name} is no quantity{did_you_mean(name, (*FORMULAS, *signals))}")
    return signals[name]


def _of_states(function: str) -> Callable[[Motion], Any]:
    """Formula of a function of the module on the states."""
    return lambda motion: motion.evaluate(function, motion.y)


def _of_times_and_states(function: str) -> Callable[[Motion], Any]:
    """Formula of a function of the module on the times and the states."""
    return lambda motion: motion.evaluate(function, motion.t, motion.y)


def _of_part(group: str, at: int | slice) -> Callable[[Motion], Array]:
    """Formula of one part of another quantity, or of some, along its last axis."""
    return lambda motion: motion.values(group)[..., at]


def _of_all_links(motion: Motion, half: int, before: Array | float) -> Array:
    """Angles or rates of all links, (..., n), those of held links included."""
    y, boundary = motion.y, motion.boundary_condition
    size = _n_positions(motion)
    moving: Array = y[..., half * size + 2 * boundary.translates : (half + 1) * size]
    if not boundary.first:
        return moving
    held = np.broadcast_to(np.asarray(before)[..., None], (*y.shape[:-1], boundary.first))
    return np.concatenate((held, moving), axis=-1)


def _n_positions(motion: Motion) -> int:
    """Number of the states that are positions."""
    return (int(motion.y.shape[-1]) - len(motion.extra_states)) // 2


def _clamp_angle(motion: Motion, rate: bool = False) -> Array | float:
    """Angle of the clamp [rad], or its rate [rad/s]; 0 without one."""
    if not motion.boundary_condition.is_clamped:
        return 0.0
    fixed = 0.0 if rate else motion.parameter(CLAMP_ANGLE.name)
    law = motion.time_dependent_loads.get(BASE_ANGLE)
    if law is None:
        turned = not rate and motion.has_parameter(BASE_ANGLE)
        return fixed + motion.parameter(BASE_ANGLE) if turned else fixed
    turned = law.derivative(motion.t, {}) if rate else law(motion.t)
    return fixed + np.broadcast_to(turned, motion.t.shape)


def _link_differences(motion: Motion, links: str, clamp: Array | float) -> Array:
    """Differences between neighbouring links; at a spring in the root or the tail, between a link
    and the value at which the spring holds it."""
    values, boundary = motion.values(links), motion.boundary_condition
    held = np.broadcast_to(np.asarray(clamp)[..., None], (*values.shape[:-1], 1))
    root, tail = ([held] if size else [] for size in (boundary.root, boundary.tail))
    return np.diff(np.concatenate((*root, values, *tail), axis=-1), axis=-1)


def _joint_forces(motion: Motion) -> Array:
    """Forces [N] in the joints that pass one on to a moving link, (..., sections, 2)."""
    links = motion.values("phi").shape[-1]
    per_mass, boundary = motion.evaluate(forces_per_mass, motion.y), motion.boundary_condition
    first = boundary.first_force - boundary.first  # joint 0 of a free rod passes none on
    unit = np.asarray(motion.parameter("mass"))[..., None, None] / links
    found: Array = unit * per_mass[..., first:, :]
    if (own := _call_optional(motion, "start_loads", motion.t)) is not None:
        found += own[..., first:, :]
    return found


def _call_optional(motion: Motion, function: str, *times: Array) -> Any:
    """Call a function of the module on the states; None where the module of the rod has none."""
    try:
        return motion.evaluate(function, *times, motion.y)
    except AttributeError as error:
        if error.name != function:
            raise
        return None


def _section_forces(motion: Motion) -> Array:
    """Joint forces along and across the rod there, (..., sections, 2): its direction in a joint is
    the mean of its neighbours', and at a support that of the first moving link."""
    phi, boundary = motion.values("phi"), motion.boundary_condition
    angles = (phi[..., :-1] + phi[..., 1:]) / 2
    mean = angles if boundary.first_force else np.concatenate((phi[..., :1], angles), axis=-1)
    x, y = np.moveaxis(motion.values("joint_forces"), -1, 0)
    c, s = np.cos(mean), np.sin(mean)
    return np.stack((c * x + s * y, c * y - s * x), axis=-1)


def _support_forces(motion: Motion) -> Array:
    """Forces of the supports on all links [N], and their moments [N m], (..., n, 3). Raises
    KeyError for a rod without supports."""
    moving = _call_optional(motion, "support_forces")
    if moving is None:
        raise KeyError("a rod without supports has no force or moment of them")
    held = np.zeros((*moving.shape[:-2], motion.boundary_condition.first, moving.shape[-1]))
    found: Array = np.concatenate((held, moving), axis=-2)
    return found


def _velocity(motion: Motion, function: str, *at: int) -> Array:
    """Velocity of a point, (..., 2), by a central difference of its positions, which a function of
    the module gives. Relative to joint 0, lest a rod far away lose its digits. Where the base
    moves, the module has the velocity."""
    if motion.boundary_condition.moves:
        there: Array = motion.values("velocities")[function]
        return there
    y, base = motion.y, 2 * motion.boundary_condition.translates
    half = _n_positions(motion)
    rates = y[..., half + base : 2 * half]
    fastest = np.abs(rates).max(axis=-1, initial=0.0)
    h = np.where(fastest > 0, TURN / np.where(fastest > 0, fastest, 1.0), 1.0)[..., None]
    points = []
    for turn in (h * rates, -h * rates):
        there = y.copy()
        there[..., :base] = 0.0
        there[..., base:half] += turn
        points.append(motion.evaluate(function, there)[(..., *at, slice(None))])
    found: Array = (points[0] - points[1]) / (2 * h)
    return found + y[..., half : half + 2] if base else found


def _velocities(motion: Motion) -> dict[str, Array]:
    """Velocities of the start, the tail and the centre of gravity of a rod whose base moves."""
    found = motion.evaluate("velocities", motion.y)
    names = "start", "joints", "centre_of_gravity"
    return {name: found[..., at, :] for at, name in enumerate(names)}


def _tail_deflections(motion: Motion) -> Array:
    """Distance of the tail from the line of the clamp or of the first link, and its rate, (..., 2):
    that line turns with the link."""
    boundary, joints = motion.boundary_condition, motion.values("joints")
    angle, turning = motion.values("phi")[..., 0], motion.values("omega")[..., 0]
    if boundary.is_clamped:
        angle, turning = (np.asarray(_clamp_angle(motion, rate)) for rate in (False, True))
    x, y = np.moveaxis(joints[..., -1, :] - joints[..., 0, :], -1, 0)
    velocity = motion.values("tip_velocity")
    if boundary.translates:
        velocity = velocity - motion.values("base_velocity")
    if boundary.moves:
        velocity = velocity - motion.values("velocities")["start"]
    vx, vy = np.moveaxis(velocity, -1, 0)
    c, s = np.cos(angle), np.sin(angle)
    return np.stack((y * c - x * s, vy * c - vx * s - turning * (x * c + y * s)), axis=-1)


def _balance(motion: Motion) -> Array:
    gained = motion.values("total_energy") - motion.start_energy
    balance: Array = gained - motion.values("total_work") - motion.energy_input
    return balance


def _total_energy(motion: Motion) -> Array:
    kinetic, spring, gravity = np.moveaxis(motion.values("energy"), -1, 0)
    total: Array = kinetic + spring + gravity
    return total


def _load(motion: Motion, name: str) -> Array:
    """Values of a load that may change with time, at the times of the samples."""
    if name in motion.time_dependent_loads:
        value = motion.time_dependent_loads[name](motion.t)
    elif name in motion.values("signals"):
        value = motion.values("signals")[name]
    else:
        value = motion.parameter(name)
    return np.broadcast_to(np.asarray(value, dtype=float), motion.t.shape)


def _signals(motion: Motion) -> dict[str, Array]:
    """Sensors, loads that follow the motion, and states that are added, by name."""
    found = motion.evaluate("signals", motion.t, motion.y) if motion.has_feedback else {}
    first = 2 * _n_positions(motion)
    return found | {name: motion.y[..., first + at] for at, name in enumerate(motion.extra_states)}


def _of_contact(motion: Motion, what: str, name: str) -> Array:
    """Depth or push of a contact: of a wall the largest depth and the sum of the
    pushes of all joints, or those of one, wall_7."""
    found = motion.values("contacts")
    if (whole := found.get(f"{what}_{name}")) is not None:
        value: Array = whole
        if value.shape != motion.t.shape:
            value = value.max(axis=-1) if what == "depth" else value.sum(axis=-1)
        return value
    wall, _, joint = name.rpartition("_")
    every = found.get(f"{what}_{wall}")
    at = int(joint) - motion.boundary_condition.first_joint if joint.isdecimal() else -1
    if every is None or every.shape == motion.t.shape or not 0 <= at < every.shape[-1]:
        raise KeyError(f"{what}_{name} is no quantity{did_you_mean(f'{what}_{name}', found)}")
    one: Array = every[..., at]
    return one


def _air(motion: Motion) -> dict[str, Array]:
    """Speeds against the air and angles of attack, by name."""
    flow: Mapping[str, Array] = _call_optional(motion, "air", motion.t) or {}
    found = {}
    for along in (name for name in flow if name.startswith("along_")):
        load = along.removeprefix("along_")
        ahead, left = -flow[along], flow[f"across_{load}"]
        found[f"airspeed_{load}"] = np.hypot(ahead, left)
        found[f"attack_{load}"] = np.arctan2(-left, ahead)
    return found


def _in_air(motion: Motion, what: str, name: str) -> Array:
    """Speed or angle of attack of a point that the air pushes."""
    every: dict[str, Array] = motion.values("air")
    if (found := every.get(f"{what}_{name}")) is None:
        hint = did_you_mean(f"{what}_{name}", every)
        raise KeyError(f"{what}_{name} is no quantity{hint}")
    return found


FORMULAS: dict[str, Callable[[Motion], Any]] = {
    "t": lambda motion: motion.t,
    "phi": lambda motion: _of_all_links(motion, 0, _clamp_angle(motion)),
    "omega": lambda motion: _of_all_links(motion, 1, _clamp_angle(motion, rate=True)),
    "bend": lambda motion: _link_differences(motion, "phi", _clamp_angle(motion)),
    "bend_rate": lambda motion: _link_differences(motion, "omega", _clamp_angle(motion, rate=True)),
    "base": lambda motion: motion.y[..., :2],
    "base_velocity": lambda motion: motion.y[..., _n_positions(motion) :][..., :2],
    "joints": _of_states("joints"),
    "velocities": _velocities,  # of a rod whose base moves, by what they are of
    "tip": lambda motion: motion.values("joints")[..., -1, :],
    "tip_velocity": lambda motion: _velocity(motion, "joints", -1),
    "tail_deflections": _tail_deflections,  # with its rate, (..., 2)
    "tail_deflection": _of_part("tail_deflections", 0),
    "tail_deflection_rate": _of_part("tail_deflections", 1),
    "centre_of_gravity": _of_states("centre_of_gravity"),
    "centre_velocity": lambda motion: _velocity(motion, "centre_of_gravity"),
    "bending_moments": _of_states("bending_moments"),
    "curvature": _of_states("curvatures"),
    "joint_forces": _joint_forces,
    "section_forces": _section_forces,
    "axial_force": _of_part("section_forces", 0),
    "shear_force": _of_part("section_forces", 1),
    "reaction": lambda motion: -motion.values("joint_forces")[..., 0, :],
    "reaction_moment": _of_times_and_states("reaction_moment"),
    "support_forces": _support_forces,  # with the moments, (..., n, 3)
    "support_force": _of_part("support_forces", slice(2)),
    "support_moment": _of_part("support_forces", 2),
    "momentum": _of_states("momentum"),
    "angular_momentum": _of_states("angular_momentum"),
    "energy": _of_states("energy"),  # of its parts, (..., 3)
    "kinetic_energy": _of_part("energy", 0),
    "spring_energy": _of_part("energy", 1),
    "gravity_energy": _of_part("energy", 2),
    "total_energy": _total_energy,
    "total_work": lambda motion: sum(motion.work.values(), start=np.zeros(motion.y.shape[:-1])),
    "energy_balance": _balance,
    "inertia": _of_states("inertia"),  # of its parts, (..., 3)
    "inertia_x": _of_part("inertia", 0),
    "inertia_y": _of_part("inertia", 1),
    "product_xy": _of_part("inertia", 2),
    "principal_axes": lambda motion: principal_axes(*np.moveaxis(motion.values("inertia"), -1, 0)),
    "principal_angle": lambda motion: motion.values("principal_axes").angle,
    "principal_moments": lambda motion: motion.values("principal_axes").moments,
    "signals": _signals,  # by name
    "forces": _of_times_and_states("forces"),  # by term
    "contacts": lambda motion: _call_optional(motion, "contacts", motion.t) or {},  # by name
    "air": _air,  # by name
    "power": _of_times_and_states("power"),  # by term
}
ONLY = {row.name: row.only for row in QUANTITIES}  # what a boundary must be
# What there is one of for each load, by what comes before the name of its term.
OF_A_LOAD: dict[str, Callable[[Motion, str], Array]] = {
    "work": lambda motion, term: motion.work[term],
    "power": lambda motion, term: np.broadcast_to(motion.values("power")[term], motion.t.shape),
    "force": lambda motion, term: motion.values("forces")[term],
    "depth": lambda motion, name: _of_contact(motion, "depth", name),
    "push": lambda motion, name: _of_contact(motion, "push", name),
    "airspeed": lambda motion, name: _in_air(motion, "airspeed", name),
    "attack": lambda motion, name: _in_air(motion, "attack", name),
}
