"""Errors of the user's input: each names the field, the value and what is allowed."""

from __future__ import annotations

import pickle
from typing import Any

LONGEST = 200  # characters of a field in a message


class SceneError(ValueError):
    """A field of a scene, an option or a file that cannot be used as it is."""

    def __init__(self, field: str, value: object, allowed: str):
        self.field, self.value, self.allowed = field, value, allowed
        shown = field if len(field) <= LONGEST else field[:LONGEST] + "..."
        super().__init__(_one_line(f"{shown} = {short(value)}: must be {allowed}"))

    def __reduce__(self) -> tuple[Any, ...]:
        # What reaches another process is the error, whatever the value was.
        return type(self), (self.field, _portable(self.value), self.allowed)


class _Shown(str):
    """A value that cannot be pickled, as it is shown in a message."""

    __slots__ = ()
    __repr__ = str.__str__


def _portable(value: object) -> object:
    """The value, or what is shown of it where it cannot be pickled."""
    try:
        pickle.dumps(value)
    except Exception:  # a value of any class, whose pickling may raise anything
        return _Shown(short(value))
    return value


def check_type(name: str, value: object, *kinds: type, see: str = "") -> None:
    """Raise TypeError unless the argument of this name is of one of these classes; see: what makes
    one."""
    if not isinstance(value, kinds):
        wanted = " or a ".join(kind.__name__ for kind in kinds)
        hint = f" (see {see})" if see else ""
        raise TypeError(f"{name} must be a {wanted}{hint}, not {type(value).__name__}")


def short(value: object, longest: int = 80) -> str:
    """A value as it is shown in a message."""
    try:
        text = repr(value)
    except ValueError:  # Python does not write whole numbers of thousands of digits
        text = "(a number of thousands of digits)"
    return text if len(text) <= longest else text[: longest - 3] + "..."


def _one_line(text: str) -> str:
    """Control characters, which a key of a file may hold, as escapes."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
