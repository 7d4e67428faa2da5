"""What the pages say of keys and boundaries is the vocabulary: `pytest --update` rewrites it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from rodgen.model.parameter import LINKS, POSITIVE, Parameter
from rodgen.model.rod import BOUNDARIES, INERTIAS, ROD
from rodgen.model.terms import TERMS

PAGE = Path(__file__).parents[2] / "docs" / "scenes.md"
TIMED = "a number or an expression in t"
LIMITS = {"positive": ", above 0", "at least 0": ", at least 0"}


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |".replace("|  |", "| |")


def _key(one: Parameter) -> str:
    """The row of a key: its name, what it is, and its default."""
    value = one.documentation + LIMITS.get(one.rule, "")
    value += f"; {TIMED}" * (one.timed and not one.several)
    default = "required" if one.default is None else f"{one.default:g}"
    key = f"`{one.key}`" if one.part is None else f"`{one.key}`, {('first', 'second')[one.part]}"
    if one.each == LINKS:
        value += "; a number, an expression in s and t, or n values, one for every link"
    elif one.several:
        value += "; `{nose = 1, body = 1, tail = 1}` (joint 0, inner joints, joint n), or a list"
        value += " of n + 1 values"
        default = f"all {default}"
    return _row(key, value, default)


def _loads() -> Iterator[str]:
    yield from (_row("key", "value", "default"), "|---|---|---|")
    for term in (one for one in TERMS.values() if one.loads):
        several = f", or several of them, [[loads.{term.table}]]" if term.placed else ""
        yield _row(f"**[loads.{term.table}]**", term.description + several, "")
        yield from map(_key, term.parameters)
        if term.placed:
            yield _row("`at`", "s of the point where it acts, from 0 (nose) to 1 (tail)", "1")


def _boundaries() -> Iterator[str]:
    yield from (
        _row("boundary", "joint 0", "links that move", "what holds them"),
        "|---|---|---|---|",
    )
    for name, one in BOUNDARIES.items():
        joint = "moves" if one.translates else "fixed"
        links = "all but link 0" if one.first else "all"
        yield _row(f"`{name}`", joint, links, one.description)


@pytest.mark.parametrize(("name", "lines"), [("loads", _loads()), ("boundaries", _boundaries())])
def test_tables_of_the_page_are_the_vocabulary(
    name: str, lines: Iterator[str], pytestconfig: pytest.Config
) -> None:
    begin, end = f"<!-- {name}: from the vocabulary -->\n", f"<!-- /{name} -->"
    before, there = PAGE.read_text().split(begin)
    there, after = there.split(end)
    wanted = "\n" + "\n".join(lines) + "\n\n"
    if pytestconfig.getoption("--update"):
        PAGE.write_text(before + begin + wanted + end + after)
    else:
        assert there == wanted


def test_the_page_names_what_else_a_rod_has() -> None:
    page = PAGE.read_text()
    rows = page.partition("| **[rod]** |")[2].partition("\n\n")[0].splitlines()
    for one in ROD:
        limit = "above 0" if one.rule == POSITIVE else one.rule
        (row,) = (r for r in rows if f"`{one.key}`" in r.split("|")[1])
        assert limit in row
    for name, inertia in INERTIAS.items():
        assert f'`"{name}"`: {inertia.description}' in page
    for boundary in BOUNDARIES:
        assert f'`"{boundary}"`' in page
