"""What a program says: the numbers of a text, and why a thing is refused."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import takewhile
from typing import Any, NamedTuple

import pytest

from rodgen.errors import InputError, Missing


def numbers(text: object) -> list[float]:
    """All numbers in a text, but those in names such as rk4."""
    found = re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?!\w)", str(text))
    return [float(number) for number in found]


class Refusal(NamedTuple):
    """What is refused, the class in place of a value that is missing, and what is allowed."""

    field: str
    value: object
    allowed: str

    @property
    def numbers(self) -> list[float]:
        """Those which are named in what is allowed."""
        return numbers(self.allowed)


def refused(make: Callable[..., object], *given: Any, **named: Any) -> Refusal:
    """Why a thing cannot be made, which is said in one line that begins with the field and is not
    endless."""
    try:
        made = make(*given, **named)
    except InputError as error:
        told = error
    else:
        pytest.fail(f"{given or named} is taken: {made!r}")
    message = str(told)
    assert len(message.splitlines()) == 1, message
    assert len(message) < 1000, message
    assert message.startswith("".join(takewhile(str.isprintable, told.field[:100]))), message
    value = Missing if isinstance(told.value, Missing) else told.value
    return Refusal(told.field, value, told.allowed)
