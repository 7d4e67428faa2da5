"""What the page of studies lists is what they compute: `pytest --update` rewrites it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from pydantic import BaseModel

from rodgen.studies.axis import Range, Sample
from rodgen.studies.findings import FINDINGS, Finding
from rodgen.studies.specification import KEYS, WHAT

PAGE = Path(__file__).parents[2] / "docs" / "studies.md"
Rows = Callable[[], Iterator[str]]


def _shown(name: str, one: Finding) -> str:
    text = f"`{name}(k)`" if one.several else f"`{name}`"
    text = f"**{text}**" if one.usual else text
    return f"{text} [{one.units}]" if one.units else text


def _rows() -> Iterator[str]:
    yield from ("| `what =` | what can be kept; **bold** is kept if none is named |", "|---|---|")
    for what, found in FINDINGS.items():
        kept = ", ".join(_shown(name, one) for name, one in found.items())
        yield f'| `"{what}"` | {kept} |'


def _fields(table: str, model: type[BaseModel]) -> Iterator[str]:
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
    yield from _fields('[vary] "KEY"', Range)
    yield from _fields("[sample]", Sample)


@pytest.mark.parametrize(("part", "rows"), [("findings", _rows), ("keys", _keys)])
def test_tables_of_the_page_are_those_of_the_code(
    part: str, rows: Rows, pytestconfig: pytest.Config
) -> None:
    before, there = PAGE.read_text().split(f"<!-- {part}: from the vocabulary -->\n")
    there, after = there.split(f"<!-- /{part} -->")
    wanted = "\n" + "\n".join(rows()) + "\n\n"
    if pytestconfig.getoption("--update"):
        begin, end = f"<!-- {part}: from the vocabulary -->\n", f"<!-- /{part} -->"
        PAGE.write_text(before + begin + wanted + end + after)
    else:
        assert there == wanted


def test_the_page_names_every_key_and_kind_of_a_study() -> None:
    page = PAGE.read_text()
    assert {*FINDINGS} == {*WHAT} - {"run"}
    for name in ("run", *FINDINGS):
        assert f'"{name}"' in page
    for keys in KEYS.values():
        assert all(f"{key}" in page for key in keys)
