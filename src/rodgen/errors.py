"""Errors that users meet: of their input, of an analysis, of a study; and words of messages."""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray

LONGEST = 200  # characters of a field in a message
UNKNOWN = "absent: not a known key"  # how a key is refused
VERSIONS = "version", "format", "schema"  # keys by which files tell of which version they are


class InputError(ValueError):
    """A field of a scene, an option or a file cannot be used.

    Examples
    --------
    >>> import rodgen
    >>> try:
    ...     rodgen.Scene.example("missile").replace({"rod.mass": -1})
    ... except rodgen.InputError as error:
    ...     print(error)
    rod.mass = -1: must be greater than 0
    """

    def __init__(self, field: str, value: object, allowed: str):
        self.field, self.value, self.allowed = field, value, allowed
        shown = field if len(field) <= LONGEST else field[:LONGEST] + "..."
        super().__init__(
            _escape_control_characters(f"{shown} = {shorten(value)}: must be {allowed}")
        )

    def __reduce__(self) -> tuple[Any, ...]:
        # What reaches another process is the error, whatever the value was.
        return type(self), (self.field, _make_picklable(self.value), self.allowed)


class EmptyPictureError(InputError):
    """A picture in which there is nothing to draw."""


class ShownText(str):
    """Text that stands for a value in messages, without quotes."""

    __slots__ = ()
    __repr__ = str.__str__


def _make_picklable(value: object) -> object:
    """Return the value, or its text in messages where it cannot be pickled."""
    try:
        pickle.dumps(value)
    except Exception:  # a value of any class, whose pickling may raise anything
        return ShownText(shorten(value))
    return value


def check_type(name: str, value: object, *kinds: type, see: str = "") -> None:
    """Raise TypeError unless the argument `name` is of one of these classes; see: what makes
    one."""
    if not isinstance(value, kinds):
        wanted = " or a ".join(kind.__name__ for kind in kinds)
        hint = f" (see {see})" if see else ""
        raise TypeError(f"{name} must be a {wanted}{hint}, not {type(value).__name__}")


def shorten(value: object, longest: int = 80) -> str:
    """Text of a value for a message, cut to `longest` characters."""
    try:
        text = repr(value)
    except ValueError:  # Python does not write whole numbers of thousands of digits
        text = "(a number of thousands of digits)"
    return text if len(text) <= longest else text[: longest - 3] + "..."


def unknown_key_message(key: object, known: Iterable[str], hint: str = "") -> str:
    """Message on a key that a table does not have; hint: where it may belong, by default the known
    key most like it."""
    known = list(known)
    if key in VERSIONS:
        hint = "; is the file of a newer rodgen? Files of this one name no version"
    return f"{UNKNOWN} (known: {', '.join(known)}){hint or did_you_mean(key, known)}"


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """End of a message that suggests the known word most like this one; empty if none is."""
    found = get_close_matches(str(word), list(known), 1)
    return f"; did you mean {found[0]}?" if found else ""


def _escape_control_characters(text: str) -> str:
    """Escape control characters, which a key of a file may hold."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def install_command(extra: str) -> str:
    """The command that installs an extra, such as "study", as messages name it."""
    return f'pip install ".[{extra}]" in a clone of rodgen'


class Missing:
    """Placeholder for a missing value in messages."""

    def __repr__(self) -> str:
        return "(missing)"


class AnalysisError(ArithmeticError):
    """An analysis has no result; the message says what was searched.

    Examples
    --------
    >>> import rodgen
    >>> try:
    ...     rodgen.critical_load(rodgen.Scene.example("ziegler"), bounds=(0.0, 1.0))
    ... except rodgen.AnalysisError as error:
    ...     print("none below 1 N")
    none below 1 N
    """


class BranchInterrupted(KeyboardInterrupt):
    """Ctrl-C while a branch, a boundary or a family of motions was followed.

    found: the Dataset of the points so far. Give it as ``resume`` to continue.

    Examples
    --------
    >>> import rodgen
    >>> scene, key = rodgen.Scene.example("euler_column"), "loads.tip.y"
    >>> try:
    ...     branch = rodgen.continue_equilibria(scene, key, (0, -5))
    ... except rodgen.BranchInterrupted as stopped:
    ...     branch = rodgen.continue_equilibria(scene, key, (0, -5), resume=stopped.found)
    """

    def __init__(self, found: xarray.Dataset):
        super().__init__(f"interrupted after {found.sizes['point']} points")
        self.found = found

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.found,)


class DoubtWarning(UserWarning):
    """A number that is computed is not to be trusted as it stands.

    figures: the numbers that the doubt rests on, by name.

    Examples
    --------
    >>> import warnings, rodgen
    >>> tilted = rodgen.Scene.example("missile").replace({"loads.follower.angle": 30.0})
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     solution = rodgen.simulate(tilted, span=(0, 0.01), progress=False)
    >>> caught[0].category.__name__, solution.notes[0].figures
    ('DoubtWarning', {'turns': 4.77...})
    """

    def __init__(self, text: str = "", figures: Mapping[str, float] | None = None):
        super().__init__(text)
        self.figures = dict(figures or {})


class StudyError(RuntimeError):
    """A study could not be finished. Its store keeps the points that are done.

    Examples
    --------
    >>> import rodgen
    >>> scene, vary = rodgen.Scene.example("ziegler"), {"loads.follower.force": [1.5, 3.0]}
    >>> try:
    ...     data = rodgen.study(scene, vary, analysis="modes", keep=["stable"], workers=1)
    ... except rodgen.StudyError as error:
    ...     print(error)  # the store, if one was given, has what was done
    """
