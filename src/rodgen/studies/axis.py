"""Axes of a study: varied keys of its scene, each with its values or its range; and samples."""

from __future__ import annotations

import hashlib
import math
from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Self, TypeVar

import numpy as np
from pydantic import Field, ValidationError

from rodgen.errors import InputError
from rodgen.scene.number_text import NumberText
from rodgen.scene.plain_tables import is_number
from rodgen.scene.tables import Pair, Table
from rodgen.scene.validation import to_input_error

Value = float | int | str
T = TypeVar("T", bound=Table)
LINEAR, LOG = "linear", "log"
SCALES = (LINEAR, LOG)
MOST_VALUES = 10**7  # of one axis
# Methods, and how many points they can draw: the sequence of Sobol has 32 bits, and a Latin
# hypercube is drawn whole by everybody who needs a point of it.
SOBOL, LATIN, RANDOM = "sobol", "latin_hypercube", "random"
SAMPLED = {SOBOL: 2**32, LATIN: 10**7, RANDOM: 2**63}
EXTENDABLE = (SOBOL, RANDOM)
WHOLE = ("rod.links", "integrate.max_steps")  # keys of whole numbers


@dataclass(frozen=True)
class Axis:
    """A varied key of the scene with its values in order or, for a sample, the range it draws from.

    values: plain numbers or text, none for a range; low, high: ends of the range; scale: "linear"
    or "log", the spacing of values between them.
    """

    name: str
    values: Sequence[Value] = ()
    low: float = math.nan
    high: float = math.nan
    scale: str = LINEAR

    @property
    def contents(self) -> list[str | int]:
        """Short list that identifies the axis, equal for equal axes, whatever its length."""
        values = np.array(self.values)
        digest = hashlib.sha256(values.dtype.str.encode() + values.tobytes()).hexdigest()
        return [self.name, len(self.values), digest, str(self.low), str(self.high), self.scale]

    @property
    def bounds(self) -> tuple[Value, Value]:
        """First and last value, or both ends of the range."""
        return (self.values[0], self.values[-1]) if len(self.values) else (self.low, self.high)

    @property
    def extremes(self) -> tuple[Any, Any]:
        """Smallest and largest value, or both ends of the range."""
        return (min(self.values), max(self.values)) if len(self.values) else (self.low, self.high)

    def value_at(self, share: float) -> Value:
        """Return the value at a share, from 0 to below 1, of the range or of the list."""
        if self.values:
            return self.values[int(share * len(self.values))]
        if self.name in WHOLE:
            return int(self.low + math.floor(share * (self.high - self.low + 1)))
        if self.scale == LOG:
            return math.exp(math.log(self.low) * (1 - share) + math.log(self.high) * share)
        return self.low + share * (self.high - self.low)


class Range(Table):
    """Table of a varied key: bounds and how many values lie between them; or a list of values."""

    bounds: Pair | None = Field(None, description="the first and the last value")
    count: Annotated[int, Field(gt=0, le=MOST_VALUES)] | None = Field(
        None, description="how many values there are; absent beside `[sample]`"
    )
    scale: str = Field(LINEAR, description="how they lie between both ends: `linear` or `log`")
    values: list[Any] | None = Field(
        None, description="a list of numbers or of texts instead of all that"
    )


def read_axis(name: str, table: Any, drawn: bool) -> Axis:
    """Make an axis of its table, or of a list of its values; drawn: a sample draws from it. Raises
    InputError."""
    field = f"vary.{name}"
    if isinstance(table, list):
        table = {"values": table}
    if not isinstance(table, dict):
        raise InputError(field, table, "a table {bounds, count} or {values = [...]}")
    read = _validate(Range, table, field)
    if read.values is not None:
        return _axis_from_list(name, field, read)
    if read.bounds is None:
        raise InputError(f"{field}.bounds", None, "two numbers, or values given instead")
    return _axis_from_range(name, field, read, drawn)


def _validate(kind: type[T], table: dict[str, Any], field: str) -> T:
    try:
        return kind.model_validate(table)
    except ValidationError as error:
        found = to_input_error(error, kind)
        raise InputError(f"{field}.{found.field}", found.value, found.allowed) from None


def _axis_from_list(name: str, field: str, read: Range) -> Axis:
    values = [_evaluate(value) for value in read.values or []]
    for key, beside in (("bounds", read.bounds), ("count", read.count)):
        if beside is not None:
            raise InputError(f"{field}.{key}", beside, "absent beside values")
    if not 0 < len(values) <= MOST_VALUES:
        raise InputError(f"{field}.values", values, f"a list of 1 to {MOST_VALUES} values")
    for at, value in enumerate(values):
        if not isinstance(value, str) and not (is_number(value) and math.isfinite(value)):
            raise InputError(f"{field}.values[{at}]", value, "a finite number or text")
    if len({isinstance(value, str) for value in values}) > 1:
        raise InputError(f"{field}.values", values, "either all numbers or all text")
    if len(set(values)) < len(values):
        raise InputError(f"{field}.values", values, "values that are all different")
    return Axis(name, _pack([_convert(name, field, value) for value in values]))


def _evaluate(value: Any) -> Any:
    """Evaluate a text that is a number, such as "deg(30)"; anything else stays as it is."""
    try:
        return float(NumberText.parse(value, {})) if isinstance(value, str) else value
    except InputError:
        return value


def _axis_from_range(name: str, field: str, read: Range, drawn: bool) -> Axis:
    assert read.bounds is not None
    low, high = map(float, read.bounds)
    if read.scale not in SCALES:
        raise InputError(f"{field}.scale", read.scale, f"one of {', '.join(SCALES)}")
    if read.scale == LOG and not (low > 0 and high > 0):
        raise InputError(f"{field}.bounds", [low, high], "above zero at both ends for scale log")
    if drawn:
        if read.count is not None:
            raise InputError(f"{field}.count", read.count, "absent: sample.count says how many")
        if not low < high:
            raise InputError(f"{field}.bounds", [low, high], f"[a, b] with b above {low:g}")
        low, high = (float(_convert(name, field, end)) for end in (low, high))
        return Axis(name, (), low, high, read.scale)
    if read.count is None:
        raise InputError(f"{field}.count", None, "a whole number, or values given instead")
    if read.count > 1 and low == high:
        raise InputError(f"{field}.bounds", [low, high], f"[a, b] with b other than {low:g}")
    spaced = np.geomspace if read.scale == LOG else np.linspace
    values = spaced(low, high, read.count).tolist()
    whole = _pack([_convert(name, field, value) for value in values])
    return Axis(name, whole, low, high, read.scale)


def _pack(values: list[Value]) -> Sequence[Value]:
    """Pack numbers into an array, which takes a quarter of the memory of a tuple."""
    numbers = [one for one in values if isinstance(one, float)]
    return array("d", numbers) if len(numbers) == len(values) else tuple(values)


def _convert(name: str, field: str, value: Any) -> Value:
    """Convert a value to the type of its key. Raises InputError for a part of a link."""
    if name not in WHOLE or isinstance(value, int):
        return value if isinstance(value, str | int) else float(value)
    if isinstance(value, str) or not value.is_integer():
        allowed = f"whole numbers: {name} takes no others (bounds and count may have to change)"
        raise InputError(field, value, allowed)
    return int(value)


class Sample(Table):
    """Table of a sample: the method by which points are drawn, how many, and the seed."""

    method: str = Field(description="`sobol`, `latin_hypercube` or `random`")
    count: Annotated[int, Field(gt=0)] = Field(description="how many points are drawn")
    seed: Annotated[int, Field(ge=0, lt=2**63)] = Field(0, description="of the random numbers")

    @classmethod
    def read(cls, table: Any) -> Self:
        """Read a sample from its table. Raises InputError."""
        if not isinstance(table, dict):
            raise InputError("sample", table, "a table {method, count, seed}")
        made = _validate(cls, table, "sample")
        if made.method not in SAMPLED:
            raise InputError("sample.method", made.method, f"one of {', '.join(SAMPLED)}")
        most = SAMPLED[made.method]
        if made.count > most:
            allowed = f"at most {most} by {made.method}"
            raise InputError("sample.count", made.count, allowed)
        return made
