"""Settings of the integration (the table [integrate], its limits, the times of samples), and
events: what is watched in a run, and what is done then.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Mapping
from inspect import Parameter
from typing import Annotated, Any, Self, TypedDict, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, ValidationError, model_validator

from rodgen.errors import InputError, did_you_mean
from rodgen.model.methods import EITHER, FIXED_STEP, METHODS
from rodgen.model.quantities import parse_number, watchable_names
from rodgen.model.rod import BOUNDARIES
from rodgen.scene.number_text import Expressed
from rodgen.scene.plain_tables import to_plain
from rodgen.scene.tables import Finite, Positive, RodTable, Table
from rodgen.scene.term_texts import check_choice
from rodgen.scene.validation import to_input_error

AUTO = "auto"
MOST_SAMPLES = 10**6
MOST_STEPS = 10**9
MOST_ADAPTIVE = 10**7
F = TypeVar("F", bound=Callable[..., Any])
LEAST_RTOL = 2.3e-14  # a hundred times the rounding of a double, below which SciPy clips

DIRECTIONS, ACTIONS = ("rising", "falling", "either"), ("record", "stop")


class IntegrationSettings(TypedDict, total=False):
    """Keyword arguments that override [integrate]; None keeps the scene's value."""

    method: str | None
    span: ArrayLike | None
    step: float | None
    rtol: float | None
    atol: float | None
    output_every: float | None
    t_eval: ArrayLike | None
    max_steps: int | None


def with_keywords(function: F) -> F:
    """Give a function a signature with the keywords of IntegrationSettings one by one, as
    notebooks and editors complete them, in place of the dictionary that holds them."""
    signature = inspect.signature(function)
    *others, last = signature.parameters.values()
    settings = [
        last.replace(
            name=name, kind=Parameter.KEYWORD_ONLY, default=None, annotation=kind.__forward_arg__
        )
        for name, kind in IntegrationSettings.__annotations__.items()
    ]
    vars(function)["__signature__"] = signature.replace(parameters=[*others, *settings])
    return function


class IntegrationTable(Table):
    """Settings of the integration of a scene."""

    method: str = Field(default=AUTO, description="`auto`, or one of [these](methods.md)")
    span: Annotated[list[Finite], Field(min_length=2, max_length=2)] = Field(
        default=[0.0, 10.0], description="`[start, end]` [s]"
    )
    step: Positive | None = Field(
        default=None,
        description="step [s] of "
        + ", ".join(f"`{name}`" for name in FIXED_STEP)
        + ", and of "
        + ", ".join(f"`{name}`" for name in EITHER)
        + " in equal steps; the other methods do not use it",
    )
    rtol: Positive = Field(
        default=1e-8, description="relative tolerance of the other methods, including `auto`"
    )
    atol: Positive = Field(default=1e-10, description="absolute tolerance of the other methods")
    output_every: Positive = Field(default=0.01, description="spacing of the samples [s]")
    t_eval: list[Finite] | None = Field(
        default=None,
        description="instead, the times of the samples [s], ascending within the span: "
        "`[0.5, 1, 3]`",
    )
    max_steps: Annotated[int, Field(gt=0)] | None = Field(
        default=None,
        description="number of steps after which the run is stopped; without it 10^7 of an "
        "adaptive method, 10^9 of equal steps",
    )

    def with_values(self, **given: Any) -> IntegrationTable:
        """Copy with other values; None keeps a value.

        A tolerance replaces a step where the method can use either, and output_every replaces
        t_eval. Raises InputError.
        """
        changes = {k: to_plain(v, f"integrate.{k}") for k, v in given.items() if v is not None}
        if not changes:
            return self
        table = self.model_dump(exclude_none=True)
        if changes.get("method", self.method) in EITHER and {"rtol", "atol"} & changes.keys():
            table.pop("step", None)
        if "output_every" in changes:
            table.pop("t_eval", None)
        return self._validate(table | changes)

    def replace(self, values: Mapping[str, Any]) -> IntegrationTable:
        """Copy with other values, and nothing else changed. Raises InputError."""
        return self._validate(self.model_dump(exclude_none=True) | dict(values))

    def _validate(self, table: dict[str, Any]) -> IntegrationTable:
        try:
            return type(self).model_validate(table)
        except ValidationError as error:
            found = to_input_error(error, type(self))
            field = f"integrate.{found.field.removeprefix('integrate.')}"
            raise InputError(field, found.value, found.allowed) from None

    @property
    def step_limit(self) -> int:
        """Largest number of steps of a run."""
        return self.max_steps or (MOST_STEPS if self.has_fixed_step else MOST_ADAPTIVE)

    @property
    def has_fixed_step(self) -> bool:
        """Whether steps are all equal: the method has a fixed step, or may have one and is given
        it."""
        return self.method in FIXED_STEP or (self.method in EITHER and self.step is not None)

    @property
    def step_tolerances(self) -> tuple[float, float]:
        """Tolerances of the estimated error of one step: relative, and absolute."""
        share = METHODS[self.method].per_step if self.method in METHODS else 1.0
        return min(self.rtol, max(share * self.rtol, LEAST_RTOL)), share * self.atol

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        check_choice("integrate.method", self.method, (AUTO, *METHODS))
        start, end = self.span
        if not start < end:
            raise InputError("integrate.span", self.span, "[start, end] with start < end")
        if self.method in FIXED_STEP and self.step is None:
            allowed = f"given in seconds: method {self.method} has a fixed step"
            raise InputError("integrate.step", None, allowed)
        if self.method in EITHER and self.has_fixed_step:
            self._check_equal_steps()
        if self.step is not None and (end - start) / self.step > MOST_STEPS:
            raise InputError("integrate.step", self.step, f"at most {MOST_STEPS} steps in the span")
        if self.t_eval is not None:
            _check_times(self.t_eval, start, end)
        elif (end - start) / self.output_every > MOST_SAMPLES:
            allowed = f"at most {MOST_SAMPLES} samples in the span"
            raise InputError("integrate.output_every", self.output_every, allowed)
        if not LEAST_RTOL <= self.rtol < 1:
            raise InputError("integrate.rtol", self.rtol, f"from {LEAST_RTOL} to below 1")
        return self

    def _check_equal_steps(self) -> None:
        """Raise InputError for a tolerance beside a step: one of them would be ignored."""
        for name in ("rtol", "atol"):
            if getattr(self, name) != type(self).model_fields[name].default:
                why = f"absent beside integrate.step, with which {self.method} takes equal steps"
                raise InputError(f"integrate.{name}", getattr(self, name), why)

    @property
    def sample_times(self) -> NDArray[np.float64]:
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


def check_settings_used(
    settings: IntegrationTable, given: Mapping[str, Any], prefix: str = ""
) -> None:
    """Raise InputError for a value that the method does not use.

    settings: all those of the run; given: those asked for beside the scene, None where not; prefix:
    of the names in messages. A scene itself may have both a step and tolerances, so that its method
    can be changed alone.
    """
    useless = ("rtol", "atol") if settings.has_fixed_step else ("step",)
    why = "has a fixed step" if settings.has_fixed_step else "chooses its own steps"
    if given.get("t_eval") is not None and given.get("output_every") is not None:
        allowed = "absent: t_eval has the times of the samples"
        raise InputError(f"{prefix}output_every", given["output_every"], allowed)
    for name in useless:
        if given.get(name) is not None:
            raise InputError(f"{prefix}{name}", given[name], f"absent: {settings.method} {why}")


def _check_times(times: list[float], start: float, end: float) -> None:
    """Raise InputError unless there are times that ascend within a span [s]."""
    if not 0 < len(times) <= MOST_SAMPLES:
        raise InputError("integrate.t_eval", times, f"1 to {MOST_SAMPLES} times")
    at = np.array(times)
    wrong = ~((at >= start) & (at <= end))
    wrong[1:] |= at[1:] <= at[:-1]
    if wrong.any():
        i = int(np.argmax(wrong))
        allowed = f"within the span, {start!r} to {end!r} s, and above the one before"
        raise InputError(f"integrate.t_eval[{i}]", times[i], allowed)


class EventTable(Table):
    """A state or a derived quantity that crosses a value: the run stops, or it is recorded."""

    quantity: str = Field(description="a state or a derived quantity, by name")
    value: Expressed[Finite] = Field(description="what it crosses, in the unit of the quantity")
    direction: str = Field(default="either", description='`"rising"`, `"falling"` or `"either"`')
    action: str = Field(
        default="record", description='`"record"` the crossing, or `"stop"` the run there'
    )
    name: str = Field(
        default_factory=lambda it: f"{it.get('quantity')} = {it.get('value')!r}",
        description="up to 64 characters, each event its own; without it `quantity = value`",
    )

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        check_choice("direction", self.direction, DIRECTIONS)
        check_choice("action", self.action, ACTIONS)
        return self


def check_events(
    events: list[EventTable], rod: RodTable, single: Iterable[str], taken: Iterable[str]
) -> None:
    """Raise InputError for an event whose quantity this rod lacks, or whose name is not its own;
    single: names of more numbers that it has; taken: names of events that it has anyway."""
    known = [
        *watchable_names(BOUNDARIES[rod.boundary], rod.links),
        *((name, range(1)) for name in single),
    ]
    first: dict[str, int] = {}
    own = {*taken}
    for i, event in enumerate(events):
        if not any(parse_number(event.quantity, name) in span for name, span in known):
            ends = [(name.format(span[0]), name.format(span[-1])) for name, span in known]
            shown = ", ".join(" to ".join(dict.fromkeys(pair)) for pair in ends)
            allowed = f"one of {shown}{did_you_mean(event.quantity, sum(ends, ()))}"
            raise InputError(f"events[{i}].quantity", event.quantity, allowed)
        name, place = event.name, f"events[{i}].name"
        if not (0 < len(name) <= 64 and name.isprintable() and name.strip()):
            raise InputError(place, name, "1 to 64 printable characters")
        if name in own:
            raise InputError(place, name, "another name: that is recorded anyway")
        if first.setdefault(name, i) != i:
            raise InputError(place, name, f"unlike that of events[{first[name]}]")
