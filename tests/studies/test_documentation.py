"""What the page of studies lists is what they compute: `pytest --update` rewrites it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from rodgen.studies.findings import FINDINGS, Finding
from rodgen.studies.specification import KEYS, WHAT

PAGE = Path(__file__).parents[2] / "docs" / "studies.md"
BEGIN, END = "<!-- findings: from the vocabulary -->\n", "<!-- /findings -->"


def _shown(name: str, one: Finding) -> str:
    text = f"`{name}(k)`" if one.several else f"`{name}`"
    text = f"**{text}**" if one.usual else text
    return f"{text} [{one.units}]" if one.units else text


def _rows() -> Iterator[str]:
    yield from ("| `what =` | there is, **at first** and to be asked for |", "|---|---|")
    for what, found in FINDINGS.items():
        kept = ", ".join(_shown(name, one) for name, one in found.items())
        yield f'| `"{what}"` | {kept} |'


def test_findings_of_the_page_are_those_of_the_analyses(pytestconfig: pytest.Config) -> None:
    before, there = PAGE.read_text().split(BEGIN)
    there, after = there.split(END)
    wanted = "\n" + "\n".join(_rows()) + "\n\n"
    if pytestconfig.getoption("--update"):
        PAGE.write_text(before + BEGIN + wanted + END + after)
    else:
        assert there == wanted


def test_the_page_names_every_key_and_kind_of_a_study() -> None:
    page = PAGE.read_text()
    assert {*FINDINGS} == {*WHAT} - {"run"}
    for name in ("run", *FINDINGS):
        assert f'"{name}"' in page
    for keys in KEYS.values():
        assert all(f"{key}" in page for key in keys)
