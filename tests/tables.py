"""Tables of docs/scenes.md and docs/studies.md, from the vocabulary."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args, get_origin

import annotated_types
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from rodgen.model.rod import BOUNDARIES
from rodgen.model.term import AIR, LINKS, Parameter
from rodgen.model.terms import CONTACTS, TERMS
from rodgen.result import Row
from rodgen.scene import Scene
from rodgen.scene.load_tables import GEOMETRIES
from rodgen.scene.tables import Table
from rodgen.studies.analysis_results import ANALYSES, rows_of
from rodgen.studies.axis import Range, Sample
from rodgen.studies.study import KEYS

DOCS = Path(__file__).parents[1] / "docs"
TIMED = "a number or an expression in t"
LIMITS = {"positive": ", above 0", "at least 0": ", at least 0", "at least 1": ", at least 1"}


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |".replace("|  |", "| |")


def _key(one: Parameter) -> str:
    """The row of a key: its name, what it is, and its default."""
    value, _, without = one.documentation.partition("; without it ")
    value += LIMITS.get(one.rule, "")
    value += f"; {TIMED}" * (one.timed and not one.is_array)
    absent = "none" if one.optional else "required"
    default = without or (absent if one.default is None else f"{one.default:g}")
    key = f"`{one.key}`" if one.part is None else f"`{one.key}`, {('first', 'second')[one.part]}"
    if one.each == LINKS:
        value += "; a number, an expression in s and t, or n values, one for every link"
    elif one.is_array:
        value += "; `{nose = 1, body = 1, tail = 1}` (joint 0, inner joints, joint n), or a list"
        value += " of n + 1 values"
        default = f"all {default}"
    return _row(key, value, default)


def _parts(kind: Any) -> Iterator[Any]:
    """Types and limits of which a type is made."""
    yield kind
    for one in (*get_args(kind), *getattr(kind, "__metadata__", ())):
        yield from _parts(one)


def _limit(field: FieldInfo) -> str:
    """What numbers of a key may be."""
    found = [*field.metadata, *_parts(field.annotation)]
    found += [one for info in found if isinstance(info, FieldInfo) for one in info.metadata]
    if any(isinstance(one, annotated_types.Gt) for one in found):
        return ", above 0"
    at_least = any(isinstance(one, annotated_types.Ge) and one.ge == 0 for one in found)
    bounded = any(isinstance(one, annotated_types.Le) and one.le == 1 for one in found)
    described = "at least 0" in str(field.description)
    return ", at least 0" * (at_least and not bounded and not described)


def _default(field: FieldInfo) -> str:
    """What holds where a key is absent."""
    value = field.default
    if field.is_required():
        return "required"
    if isinstance(value, list):
        return f"`[{', '.join(f'{one:g}' for one in value)}]`"
    if isinstance(value, str):
        return f'`"{value}"`'
    return "none" if value is None or field.default_factory else f"{value:g}".replace("e-0", "e-")


def _field(key: str, field: FieldInfo) -> str:
    """The row of a key of a table; what it is without it is its default."""
    assert field.description, f"{key} has no description"
    value, _, without = field.description.partition("; without it ")
    what = re.match("[^:;]*", value)
    assert what is not None
    return _row(
        f"`{key}`", what[0] + _limit(field) + value[what.end() :], without or _default(field)
    )


def _tables(*names: str) -> Iterator[str]:
    """A table of the page for every one of these tables of a scene."""
    for name in names:
        field = Scene.model_fields[name]
        kinds = [*_parts(field.annotation)]
        (table,) = {kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Table)}
        several = {list: f"[[{name}]]", dict: f"[{name}.NAME]"}
        head = next((several[kind] for kind in map(get_origin, kinds) if kind in several), None)
        text = " ".join(str(table.__doc__).rstrip(".").split())
        text = text[0].lower() + text[1:] + "; any number of these tables" * (head is not None)
        yield from (_row("key", "value", "default"), "|---|---|---|")
        yield _row(f"**{head or f'[{name}]'}**", text, "")
        yield from (_field(key, one) for key, one in table.model_fields.items())
        if name != names[-1]:
            yield ""


def _first() -> Iterator[str]:
    """The name of a scene, and the numbers and tables that its expressions name."""
    yield from (_row("key", "value", "default"), "|---|---|---|")
    fields = Scene.model_fields
    yield _field("name", fields["name"])
    yield _row("**[parameters]**", str(fields["numbers"].description), "")
    yield _row("**[tables.NAME]**", str(fields["tables"].description), "")


def _loads() -> Iterator[str]:
    yield from (_row("key", "value", "default"), "|---|---|---|")
    for term in (one for one in TERMS.values() if one.is_load):
        several = f", or several of them, [[loads.{term.table}]]" if term.placed else ""
        yield _row(f"**[loads.{term.table}]**", term.description + several, "")
        yield from (_key(one) for one in term.parameters if not one.table)
        yield from (_field(key, one) for key, (_, one) in GEOMETRIES.get(term.name, {}).items())
        if term.placed:
            place = "s of the point where it acts, from 0 (nose or root) to 1 (tail)"
            yield _row("`at`", place, "required" if term.kind == AIR else "1")


def _contacts() -> Iterator[str]:
    for term in CONTACTS:
        yield from (_row("key", "value", "default"), "|---|---|---|")
        yield _row(f"**[[{term.table}]]**", f"{term.description}; any number of these tables", "")
        if term.placed:
            what = "that of its joint" if term.at_joints else "that of its point"
            yield _row("`at`", f"s, {what}, from 0 (nose or root) to 1 (tail)", "required")
        yield from map(_key, term.parameters)
        if term != CONTACTS[-1]:
            yield ""


def _boundaries() -> Iterator[str]:
    yield from (
        _row("boundary", "joint 0", "links that move", "what holds them"),
        "|---|---|---|---|",
    )
    for name, one in BOUNDARIES.items():
        joint = "moves" if one.translates else "fixed"
        links = "all but link 0" if one.first else "all"
        yield _row(f"`{name}`", joint, links, one.description)


def _finding(row: Row) -> str:
    assert row.kept is not None
    text = f"`{row.name}(k)`" if row.kept.several else f"`{row.name}`"
    text = f"**{text}**" if row.kept.usual else text
    unit = row.unit.format(unit="that of the load")
    return f"{text} [{unit}]" if unit else text


def _findings() -> Iterator[str]:
    yield from (
        "| `analysis =` | what can be kept; **bold** is kept if none is named |",
        "|---|---|",
    )
    for what in ANALYSES:
        kept = ", ".join(map(_finding, rows_of(what).values()))
        yield f'| `"{what}"` | {kept} |'


def _fields_of(table: str, model: type[BaseModel]) -> Iterator[str]:
    for name, one in model.model_fields.items():
        default = "required" if one.is_required() else f"`{one.default}`"
        default = "absent" if one.default is None else default
        yield f"| `{table}` | `{one.alias or name}` | {one.description} | {default} |"


def _keys() -> Iterator[str]:
    yield from ("| table | key | what it is | without it |", "|---|---|---|---|")
    for table, keys in KEYS.items():
        shown = f"`[{table}]`" if table else "the file"
        for key, (what, default) in keys.items():
            yield f"| {shown} | `{key}` | {what} | {default} |"
    yield from _fields_of('[vary] "KEY"', Range)
    yield from _fields_of("[sample]", Sample)


def tables() -> dict[str, dict[str, Iterator[str]]]:
    """Lines of every table, by the page and the mark between which it stands there."""
    return {
        "scenes.md": {
            "scene": _first(),
            "rod": _tables("rod", "bodies", "supports", "foundation", "base", "air"),
            "contacts": _contacts(),
            "loads": _loads(),
            "run": _tables("states", "initial", "events", "integrate"),
            "boundaries": _boundaries(),
        },
        "studies.md": {"findings": _findings(), "keys": _keys()},
    }


def pages() -> dict[Path, str]:
    """Texts of the pages with the tables of today. Raises ValueError where a mark is gone."""
    texts = {}
    for name, parts in tables().items():
        text = (DOCS / name).read_text(encoding="utf-8")
        for mark, lines in parts.items():
            begin, end = f"<!-- {mark}: from the vocabulary -->\n", f"<!-- /{mark} -->"
            before, rest = text.split(begin)
            _, after = rest.split(end)
            text = before + begin + "\n" + "\n".join(lines) + "\n\n" + end + after
        texts[DOCS / name] = text
    return texts
