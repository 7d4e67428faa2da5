"""The tables of a scene file, each with its keys, their types, units and limits."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from functools import lru_cache
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from rodgen.scene import structure as st
from rodgen.scene.errors import SceneError
from rodgen.scene.expression import Expression

AUTO = "auto"
FIXED_STEP = ("euler", "semi_implicit_euler", "rk4", "thesis_runge_kutta")
ADAPTIVE = ("dop853", "gauss", "radau", "rk23", "rk45", "bdf", "lsoda", "cvode")
EITHER = ("gauss",)  # adaptive methods that take equal steps where a step is given
METHODS = (AUTO, *FIXED_STEP, *ADAPTIVE)
MOST_SAMPLES = 10**6
MOST_STEPS = 10**9
MOST_ADAPTIVE = 10**7
LEAST_RTOL = 2.3e-14  # a hundred times the rounding of a double, below which SciPy clips

LARGEST = 1e60  # of any value: products of several must still fit in a double


def _not_vanishing(value: float) -> float:
    if value < SMALLEST:
        raise PydanticCustomError("too_small", f"at least {SMALLEST:g}")
    return value


Finite = Annotated[float, Field(allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
SMALLEST = 1e-60  # of what others are divided by
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0, le=LARGEST)]
Size = Annotated[Positive, AfterValidator(_not_vanishing)]
NotNegative = Annotated[float, Field(allow_inf_nan=False, ge=0, le=LARGEST)]
Pair = Annotated[list[Finite], Field(min_length=2, max_length=2)]
# Of a list, which may be long, the first wrong value is enough.
Values = Annotated[list[Finite], Field(fail_fast=True)]
Factors = Annotated[list[NotNegative], Field(fail_fast=True)]
Timed = Finite | str  # a number, or an expression in t

# Where in [loads] a scene has a parameter of its module: table and key.
PLACES = {
    "follower_force": ("follower", "force"),
    "follower_angle": ("follower", "angle"),
    "gravity": ("gravity", "g"),
    "internal_damping": ("internal_damping", "coefficient"),
    "external_damping": ("external_damping", "coefficient"),
    "fin_factor": ("external_damping", "fin_factor"),
    "tip_force_x": ("tip", "x"),
    "tip_force_y": ("tip", "y"),
}
DIRECTIONS, ACTIONS = ("rising", "falling", "either"), ("record", "stop")
# What an event can watch beside the states and the joints.
DERIVED = (
    *("tip_x", "tip_y", "centre_of_gravity_x", "centre_of_gravity_y"),
    *("kinetic_energy", "spring_energy", "gravity_energy", "total_energy"),
    *("inertia_x", "inertia_y", "product_xy"),
)
# The table of a term is that of its parameters.
TABLES = {term: PLACES[names[0]][0] for term, names in st.TERM_PARAMETERS.items()}


class Table(BaseModel):
    """A table of a scene: no key that is not known, no value of another type."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Rod(Table):
    """The rod: links, length [m], bending stiffness [N m^2], mass [kg]; how its mass lies and its
    start is held; the angle of its clamp [rad], for boundaries that have one."""

    links: int
    length: Size
    bending_stiffness: NotNegative
    mass: Size
    inertia: str = "uniform"
    boundary: str = "free"
    clamp_angle: Finite | None = None

    @model_validator(mode="after")
    def _structure(self) -> Self:
        st.choose("rod.boundary", self.boundary, st.BOUNDARIES)
        st.choose("rod.inertia", self.inertia, st.INERTIAS)
        st.check_links(self.links, self.boundary, "rod.links")
        has_clamp = "clamp_angle" in st.BOUNDARY_PARAMETERS[self.boundary]
        if self.clamp_angle is not None and not has_clamp:
            allowed = f"absent: boundary {self.boundary} has no clamp"
            raise SceneError("rod.clamp_angle", self.clamp_angle, allowed)
        return self


class Follower(Table):
    """Follower force [N], a number or an expression in t, and its angle to the last link [rad]."""

    force: Timed
    angle: Finite = 0.0


class Gravity(Table):
    """Acceleration of gravity [m/s^2], downwards."""

    g: Finite = 9.81


class InternalDamping(Table):
    """Coefficient c_int [m^2/s]."""

    coefficient: NotNegative


class FinFactor(Table):
    """Fin factors of joint 0, of the joints between, and of the tail."""

    nose: NotNegative = 1.0
    body: NotNegative = 1.0
    tail: NotNegative = 1.0

    def values(self, links: int) -> list[float]:
        return [self.nose, *[self.body] * (links - 1), self.tail]


class ExternalDamping(Table):
    """Coefficient c_ext [1/s] and the fin factors s of the joints."""

    coefficient: NotNegative
    fin_factor: FinFactor | Factors = FinFactor()


class Tip(Table):
    """Dead force at the tail [N], each component a number or an expression in t."""

    x: Timed = 0.0
    y: Timed = 0.0


class Loads(Table):
    """The loads that the scene has; those that are absent are not in its equations."""

    follower: Follower | None = None
    gravity: Gravity | None = None
    internal_damping: InternalDamping | None = None
    external_damping: ExternalDamping | None = None
    tip: Tip | None = None

    @model_validator(mode="after")
    def _expressions(self) -> Self:
        for name in self.parameters:
            self.expression(name)
        return self

    @property
    def terms(self) -> tuple[str, ...]:
        """Terms whose tables are there."""
        return tuple(term for term in st.TERMS if getattr(self, TABLES[term]) is not None)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Parameters of these terms."""
        return tuple(name for term in self.terms for name in st.TERM_PARAMETERS[term])

    def value(self, name: str) -> Any:
        """Value of one of these parameters, as the scene has it."""
        table, key = PLACES[name]
        return getattr(getattr(self, table), key)

    def expression(self, name: str) -> Expression | None:
        """The expression in t that a parameter is given by, where it is given by text."""
        value = self.value(name)
        place = ".".join(("loads", *PLACES[name]))
        return _parsed(value, place) if isinstance(value, str) else None


@lru_cache(maxsize=64)
def _parsed(text: str, place: str) -> Expression:
    """An expression in t, which a scene is asked for again and again."""
    return Expression(text, "t", place)


class Initial(Table):
    """Initial state, by default straight (along the clamp) and at rest; phi and omega are a
    number, a list over the moving links, or an expression in s, the middle of the link from 0 at
    the nose to 1 at the tail."""

    position: Pair | None = None
    velocity: Pair | None = None
    phi: Finite | Values | str | None = None
    omega: Finite | Values | str | None = None

    @model_validator(mode="after")
    def _expressions(self) -> Self:
        for name in ("phi", "omega"):
            value = getattr(self, name)
            if isinstance(value, str):
                Expression(value, "s", f"initial.{name}")
        return self


class Event(Table):
    """A state or a derived quantity that crosses a value: the run stops, or it is recorded."""

    quantity: str
    value: Finite
    direction: str = "either"
    action: str = "record"
    name: str = Field(default_factory=lambda it: f"{it.get('quantity')} = {it.get('value')!r}")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        st.choose("direction", self.direction, DIRECTIONS)
        st.choose("action", self.action, ACTIONS)
        return self


def check_events(events: list[Event], rod: Rod) -> None:
    """Raise SceneError unless this rod has all quantities and every event a name of its own."""
    known = list(_quantities(rod))
    first: dict[str, int] = {}
    for i, event in enumerate(events):
        if not any(_is_one(event.quantity, *some) for some in known):
            ends = [(name.format(span[0]), name.format(span[-1])) for name, span in known]
            shown = ", ".join(" to ".join(dict.fromkeys(pair)) for pair in ends)
            raise SceneError(f"events[{i}].quantity", event.quantity, f"one of {shown}")
        name, place = event.name, f"events[{i}].name"
        if not (0 < len(name) <= 64 and name.isprintable() and name.strip()):
            raise SceneError(place, name, "1 to 64 printable characters")
        if first.setdefault(name, i) != i:
            raise SceneError(place, name, f"unlike that of events[{first[name]}]")


def _quantities(rod: Rod) -> Iterator[tuple[str, range]]:
    """Names of all quantities that move, with the numbers of those that have one."""
    hold, once = st.BOUNDARIES[rod.boundary], range(1)
    links = range(hold.first, rod.links)
    joints = range(0 if hold.translates else hold.first + 1, rod.links + 1)
    place, speed = (("x0", "y0"), ("vx0", "vy0")) if hold.translates else ((), ())
    yield from ((name, once) for name in place)
    yield "phi_{}", links
    yield from ((name, once) for name in speed)
    yield "omega_{}", links
    yield from ((name, joints) for name in ("joint_{}_x", "joint_{}_y"))
    yield from ((name, once) for name in DERIVED)


def _is_one(quantity: str, name: str, numbers: range) -> bool:
    found = re.search(r"[0-9]{1,7}", quantity) if "{}" in name else None
    number = int(found[0]) if found else 0
    return quantity == name.format(number) and number in numbers


class Integrate(Table):
    """How the scene is integrated; t_eval: times of the samples [s], ascending, instead of one at
    the start and every output_every; max_steps: after so many, a run is stopped (if not given, ten
    million of an adaptive method)."""

    method: str = AUTO
    span: Pair = [0.0, 10.0]
    step: Positive | None = None
    rtol: Positive = 1e-8
    atol: Positive = 1e-10
    output_every: Positive = 0.01
    t_eval: list[Finite] | None = None
    max_steps: Annotated[int, Field(gt=0)] | None = None

    @property
    def budget(self) -> int:
        """Steps after which a run is stopped."""
        return self.max_steps or (MOST_STEPS if self.fixed else MOST_ADAPTIVE)

    @property
    def fixed(self) -> bool:
        """Whether steps are all equal: the method has a fixed step, or may have one and is given
        it."""
        return self.method in FIXED_STEP or (self.method in EITHER and self.step is not None)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        st.choose("integrate.method", self.method, METHODS)
        start, end = self.span
        if not start < end:
            raise SceneError("integrate.span", self.span, "[start, end] with start < end")
        if self.method in FIXED_STEP and self.step is None:
            allowed = f"given in seconds: method {self.method} has a fixed step"
            raise SceneError("integrate.step", None, allowed)
        if self.method in EITHER and self.fixed:
            self._equal_steps()
        if self.step is not None and (end - start) / self.step > MOST_STEPS:
            raise SceneError("integrate.step", self.step, f"at most {MOST_STEPS} steps in the span")
        if self.t_eval is not None:
            _check_times(self.t_eval, start, end)
        elif (end - start) / self.output_every > MOST_SAMPLES:
            allowed = f"at most {MOST_SAMPLES} samples in the span"
            raise SceneError("integrate.output_every", self.output_every, allowed)
        if not LEAST_RTOL <= self.rtol < 1:
            raise SceneError("integrate.rtol", self.rtol, f"from {LEAST_RTOL} to below 1")
        return self

    def _equal_steps(self) -> None:
        """Raise SceneError for a tolerance beside a step: one of them would count for nothing."""
        for name in ("rtol", "atol"):
            if getattr(self, name) != type(self).model_fields[name].default:
                why = f"absent beside integrate.step, with which {self.method} takes equal steps"
                raise SceneError(f"integrate.{name}", getattr(self, name), why)

    @property
    def samples(self) -> NDArray[np.float64]:
        """Output times: t_eval, or the start, every output_every, and the end."""
        if self.t_eval is not None:
            return np.array(self.t_eval, dtype=float)
        start, end = self.span
        count = math.floor((end - start) / self.output_every * (1 + 1e-12))
        times: NDArray[np.float64] = start + self.output_every * np.arange(count + 1.0)
        if len(times) == 1 or end - times[-1] > 1e-9 * self.output_every:
            times = np.append(times, end)
        times[-1] = end
        return times


def _check_times(times: list[float], start: float, end: float) -> None:
    """Raise SceneError unless there are times that ascend within a span [s]."""
    if not 0 < len(times) <= MOST_SAMPLES:
        raise SceneError("integrate.t_eval", times, f"1 to {MOST_SAMPLES} times")
    at = np.array(times)
    wrong = ~((at >= start) & (at <= end))
    wrong[1:] |= at[1:] <= at[:-1]
    if wrong.any():
        i = int(np.argmax(wrong))
        allowed = f"within the span, {start!r} to {end!r} s, and above the one before"
        raise SceneError(f"integrate.t_eval[{i}]", times[i], allowed)
