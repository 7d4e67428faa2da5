"""Immutable lists and dictionaries of scenes, which have a hash."""

from __future__ import annotations

from typing import Any, NoReturn

AGAIN = 'Make another: scene.replace({"rod.length": 3.0}), by the dotted name of the key'
OF_LISTS = "append clear extend insert pop remove reverse sort __iadd__ __imul__"
OF_DICTS = "clear pop popitem setdefault update __ior__"
OF_BOTH = "__setitem__ __delitem__"


def _refuse(self: object, *_: object, **__: object) -> NoReturn:
    kind = "list" if isinstance(self, list) else "dictionary"
    raise TypeError(f"a {kind} of a scene cannot be changed: scenes do not change. {AGAIN}")


class FrozenList(list[Any]):
    """A list that raises TypeError when it is to be changed; copies by `list` can be."""

    vars().update(dict.fromkeys(f"{OF_LISTS} {OF_BOTH}".split(), _refuse))

    def __reduce__(self) -> tuple[Any, ...]:  # else it would be unpickled item by item
        return FrozenList, (list(self),)

    # Lists have no hash, as they change; this one does not.
    def __hash__(self) -> int:  # type: ignore[override]
        return hash(tuple(self))


class FrozenDict(dict[str, Any]):
    """A dictionary that raises TypeError when it is to be changed; copies by `dict` can be."""

    vars().update(dict.fromkeys(f"{OF_DICTS} {OF_BOTH}".split(), _refuse))

    def __reduce__(self) -> tuple[Any, ...]:
        return FrozenDict, (dict(self),)

    # Dictionaries have no hash, as they change; this one does not.
    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))


def make_immutable(value: Any) -> Any:
    """Make a list or a dictionary immutable; anything else is returned as it is."""
    if isinstance(value, list):
        return FrozenList(value)
    return FrozenDict(value) if isinstance(value, dict) else value
