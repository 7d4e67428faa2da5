"""Keys of a scene by their dotted names, such as loads.follower.force or bodies.payload.mass; and
numbers and tables that no expression names.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, get_origin

from pydantic import BaseModel

from rodgen.errors import InputError, did_you_mean, shorten
from rodgen.scene import grammar
from rodgen.scene.grammar import TABLE
from rodgen.scene.literals import literals, replace_literal
from rodgen.scene.plain_tables import to_plain
from rodgen.scene.scene_files import TABLES
from rodgen.scene.validation import check_key_exists, fields_of_tables, goes_by_names

NUMBERS = "parameters"  # the table of numbers that have names
WORD = re.compile(r"\b[^\W\d]\w*")


def keys_of(model: type[BaseModel]) -> list[str]:
    """Dotted names of all values that a scene may have, without those in arrays of tables."""
    tables = fields_of_tables(model)
    every = {f"{table}{key}": field for table, of in tables.items() for key, field in of.items()}
    arrays = tuple(f"{name}." for name, field in every.items() if goes_by_names(field))
    return [
        name
        for name, field in every.items()
        if f"{name}." not in tables
        and get_origin(field.annotation) is not dict
        and not name.startswith(arrays)
    ]


def expression_texts(table: Any) -> Iterator[str]:
    """Yield all texts in nested tables and lists, except names."""
    if isinstance(table, str):
        yield table
    elif isinstance(table, dict | list):
        inner = table.items() if isinstance(table, dict) else enumerate(table)
        for key, value in inner:
            if key != "name":
                yield from expression_texts(value)


def numbers_in_use(scene: dict[str, Any], others: Sequence[str] = ()) -> list[str]:
    """Numbers of [parameters] that an expression of the scene, or another of these texts, names."""
    words = {word for text in (*expression_texts(scene), *others) for word in WORD.findall(text)}
    return [name for name in scene.get(NUMBERS, {}) if name in words]


def check_number_in_use(
    scene: dict[str, Any],
    place: Sequence[str],
    given: tuple[str, object],
    others: Sequence[str] = (),
) -> None:
    """Raise InputError for a new value of a number that no expression names: it would change
    nothing. place: keys of tables where the value stands; given: field and value of the message;
    others: texts of expressions that the scene may get."""
    if len(place) == 2 and place[0] == NUMBERS:
        named = numbers_in_use(scene, others)
        if place[1] not in named:
            known = ", ".join(named) or "none"
            allowed = f"a number that an expression of the scene names ({known})"
            raise InputError(*given, f"{allowed}{did_you_mean(place[1], named)}")


def set_values(scene: dict[str, Any], values: Mapping[str, Any], kind: type[BaseModel]) -> None:
    """Set values in the tables of a scene by their dotted names, which may be new; None removes a
    key. A number behind the key of an expression is the index of a number in its text. kind: the
    class of the scene, which knows its keys. Raises InputError for a name that leads to no table or
    list, and for the removal of a key that no scene has."""
    left = dict(values)
    for name, value in values.items():
        if name not in left:
            continue
        keys, table = name.split("."), scene
        if value is None:
            check_key_exists(kind, keys)
        for depth, key in enumerate(keys, start=1):
            at = _key_or_index(table, key, name, keys[: depth - 1])
            if depth == len(keys):
                break
            if isinstance(table, dict):  # where there is nothing, nothing can be taken away
                inner = table.setdefault(at, {}) if value is not None else table.get(at, {})
            else:
                inner = table[at]
            if isinstance(inner, str) and value is not None and is_index(".".join(keys[depth:])):
                value = _with_literals(inner, ".".join(keys[:depth]), left)
                break
            table = inner
        if value is not None:
            table[at] = to_plain(value, name)  # a copy: other keys may change it
        elif isinstance(table, list) or at in table:
            del table[at]


def _with_literals(text: str, key: str, left: dict[str, Any]) -> str:
    """Put new numbers into the text at a key, and take them out of `left`: the last ones first,
    since one may shift the places of those behind it."""
    inside = (name.removeprefix(f"{key}.") for name in left if name.startswith(f"{key}."))
    for at in sorted(map(int, filter(is_index, inside)), reverse=True):
        name = f"{key}.{at}"
        text = replace_literal(text, at, left.pop(name), name)
    return text


def is_index(key: str) -> bool:
    """Whether a key is an index, counted from 0."""
    return key.isascii() and key.isdigit()


def number_at(text: str, key: str) -> float | None:
    """Number with an index in the text of an expression; None where there is none."""
    if not is_index(key):
        return None
    try:
        found = literals(text)
    except InputError:
        return None
    return found[int(key)].value if int(key) < len(found) else None


def _key_or_index(table: Any, key: str, name: str, outer: Sequence[str], field: str = "key") -> Any:
    """Key of a table, or index in a list, for one part of a dotted name; a table in a list may go
    by its name. outer: the parts before. Raises InputError."""
    if isinstance(table, dict):
        return key
    at = ".".join(outer)
    if not isinstance(table, list):
        raise InputError(field, name, f"a key of the scene ({at} is {shorten(table)})")
    names = [one.get("name") if isinstance(one, dict) else None for one in table]
    if key in names:
        return names.index(key)
    if is_index(key) and int(key) < len(table):
        return int(key)
    known = ", ".join(str(n or number) for number, n in enumerate(names)) or "none"
    known += ", counted from 0" if names and not any(names) else ""
    hint = did_you_mean(key, [n for n in names if n])
    raise InputError(field, name, f"a key of the scene ({at} has {known}){hint}")


def find_value(
    scene: dict[str, Any], name: str, field: str = "vary", others: Sequence[str] = ()
) -> tuple[tuple[str, ...], Any]:
    """Keys from the outermost table in to a dotted name, and the value there, None where it is left
    out; others: texts that replace the scene's expressions. Raises InputError, with the field that
    is named, for a name that is in no table, that is no single value, or that is one of a number
    which no expression names. A number in the text of an expression goes by its index there."""
    found_at: list[str] = []
    value: Any = scene
    names = name.split(".")
    for depth, key in enumerate(names, start=1):
        is_last = depth == len(names)
        if isinstance(value, list):
            at = _key_or_index(value, key, name, found_at, field)
            found_at.append(str(at))
            value = value[at]
            continue
        if isinstance(value, str) and is_last and (number := number_at(value, key)) is not None:
            return (*found_at, key), number
        known = list(value) if isinstance(value, dict) else []
        # What a table may have beside what it has, the scene itself tells when it is made.
        if not (key in known or (isinstance(value, dict) and depth > 1 and is_last)):
            at = ".".join(found_at) or "the scene"
            has = f"({at} has {', '.join(known) or 'none'})"
            allowed = f"a key of the scene {has}{did_you_mean(key, known)}"
            raise InputError(field, name, allowed)
        found_at.append(key)
        value = value.get(key)
    if isinstance(value, dict | list) or found_at == ["name"]:
        inside = f", such as {name}.{next(iter(value), 0)}" if isinstance(value, dict) else ""
        inside = f", such as {name}.0" if isinstance(value, list) else inside
        raise InputError(field, name, f"a key that has one value{inside}")
    check_number_in_use(scene, found_at, (field, name), others)
    return tuple(found_at), value


def find_unused_names(
    given: dict[str, Any], numbers: Collection[str], tables: Collection[str]
) -> Iterator[str]:
    """Yield a sentence on each number and table that no expression of a scene names."""
    named = numbers_in_use(given)
    for name in numbers:
        if name not in named:
            yield f"no expression names {NUMBERS}.{name}"
    trees = [
        grammar.parse(text, "") for text in expression_texts(given) if tables and TABLE in text
    ]
    read = {name for tree in trees if tree for name in grammar.table_names(tree)}
    for name in tables:
        if repr(name) not in read:
            yield f"no expression names {TABLES}.{name}"
