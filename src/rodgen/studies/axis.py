"""What a study varies: keys of its scene, each with its values or its range."""

from __future__ import annotations

import hashlib
import math
from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, ValidationError

from rodgen.errors import InputError
from rodgen.scene.plain import is_number
from rodgen.scene.tables import Finite, Table
from rodgen.scene.validation import explain

Value = float | int | str
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
    """A key of the scene and its values, in order; of a sample that draws from a range, the range.

    values: plain numbers or text, none where a range is drawn from; low, high: its ends; scale:
    "linear" or "log", by which values lie between them.
    """

    name: str
    values: Sequence[Value] = ()
    low: float = math.nan
    high: float = math.nan
    scale: str = LINEAR

    @property
    def contents(self) -> list[str | int]:
        """What it consists of: equal for equal axes, and short, however many values there are."""
        values = np.array(self.values)
        digest = hashlib.sha256(values.dtype.str.encode() + values.tobytes()).hexdigest()
        return [self.name, len(self.values), digest, str(self.low), str(self.high), self.scale]

    @property
    def ends(self) -> tuple[Value, Value]:
        """Its first and last value, or those of its range."""
        return (self.values[0], self.values[-1]) if len(self.values) else (self.low, self.high)

    def drawn(self, share: float) -> Value:
        """The value that a share, from 0 to below 1, of the range or of the list stands for."""
        if self.values:
            return self.values[int(share * len(self.values))]
        if self.name in WHOLE:
            return int(self.low + math.floor(share * (self.high - self.low + 1)))
        if self.scale == LOG:
            return math.exp(math.log(self.low) * (1 - share) + math.log(self.high) * share)
        return self.low + share * (self.high - self.low)


class Range(Table):
    """Values between two ends, so many of them in a grid; or a list of values."""

    bounds: Annotated[list[Finite], Field(min_length=2, max_length=2)] | None = Field(
        None, description="the first and the last value"
    )
    count: Annotated[int, Field(gt=0, le=MOST_VALUES)] | None = Field(
        None, description="how many values there are; absent beside `[sample]`"
    )
    scale: str = Field(LINEAR, description="how they lie between both ends: `linear` or `log`")
    values: list[Any] | None = Field(
        None, description="a list of numbers or of texts instead of all that"
    )


def axis(name: str, table: Any, drawn: bool) -> Axis:
    """An axis from its table, or from a list of its values; drawn: a sample draws from it. Raises
    InputError for what is none."""
    field = f"vary.{name}"
    if isinstance(table, list):
        table = {"values": table}
    if not isinstance(table, dict):
        allowed = "a table {bounds, count} or {values = [...]}"
        raise InputError(field, table, allowed)
    try:
        read = Range.model_validate(table)
    except ValidationError as error:
        found = explain(error, table, Range)
        raise InputError(f"{field}.{found.field}", found.value, found.allowed) from None
    if read.values is not None:
        return _listed(name, field, read)
    if read.bounds is None:
        raise InputError(f"{field}.bounds", None, "two numbers, or values given instead")
    return _ranged(name, field, read, drawn)


def _listed(name: str, field: str, read: Range) -> Axis:
    values = read.values or []
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
    return Axis(name, _compact([_whole(name, field, value) for value in values]))


def _ranged(name: str, field: str, read: Range, drawn: bool) -> Axis:
    assert read.bounds is not None
    low, high = read.bounds
    if read.scale not in SCALES:
        raise InputError(f"{field}.scale", read.scale, f"one of {', '.join(SCALES)}")
    if read.scale == LOG and not (low > 0 and high > 0):
        raise InputError(f"{field}.bounds", [low, high], "above zero at both ends for scale log")
    if drawn:
        if read.count is not None:
            raise InputError(f"{field}.count", read.count, "absent: sample.count says how many")
        if not low < high:
            raise InputError(f"{field}.bounds", [low, high], f"[a, b] with b above {low:g}")
        low, high = (float(_whole(name, field, end)) for end in (low, high))
        return Axis(name, (), low, high, read.scale)
    if read.count is None:
        raise InputError(f"{field}.count", None, "a whole number, or values given instead")
    if read.count > 1 and low == high:
        raise InputError(f"{field}.bounds", [low, high], f"[a, b] with b other than {low:g}")
    spaced = np.geomspace if read.scale == LOG else np.linspace
    values = spaced(low, high, read.count).tolist()
    whole = _compact([_whole(name, field, value) for value in values])
    return Axis(name, whole, low, high, read.scale)


def _compact(values: list[Value]) -> Sequence[Value]:
    """The values; as plain numbers a million of them would take four times the memory."""
    numbers = [one for one in values if isinstance(one, float)]
    return array("d", numbers) if len(numbers) == len(values) else tuple(values)


def _whole(name: str, field: str, value: Any) -> Value:
    """The value as the key takes it. Raises InputError for a part of a link."""
    if name not in WHOLE or isinstance(value, int):
        return value if isinstance(value, str | int) else float(value)
    if isinstance(value, str) or not value.is_integer():
        allowed = f"whole numbers: {name} takes no others (bounds and count may have to change)"
        raise InputError(field, value, allowed)
    return int(value)


class Sample(Table):
    """How points are drawn: by what method, how many, and from which seed."""

    method: str = Field(description="`sobol`, `latin_hypercube` or `random`")
    count: Annotated[int, Field(gt=0)] = Field(description="how many points are drawn")
    seed: Annotated[int, Field(ge=0, lt=2**63)] = Field(0, description="of the random numbers")

    @classmethod
    def read(cls, table: Any) -> Self:
        """A sample from its table. Raises InputError."""
        if not isinstance(table, dict):
            raise InputError("sample", table, "a table {method, count, seed}")
        try:
            made = cls.model_validate(table)
        except ValidationError as error:
            found = explain(error, table, cls)
            raise InputError(f"sample.{found.field}", found.value, found.allowed) from None
        if made.method not in SAMPLED:
            raise InputError("sample.method", made.method, f"one of {', '.join(SAMPLED)}")
        most = SAMPLED[made.method]
        if made.count > most:
            allowed = f"at most {most} by {made.method}"
            raise InputError("sample.count", made.count, allowed)
        return made
