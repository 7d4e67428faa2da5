"""What the page loads, and what is left out of NiceGUI's files for it."""

from __future__ import annotations

from typing import Any

import pytest

from rodgen.live.page.elements import LIBRARY
from rodgen.live.page.lean import ABSENT, replacements
from tests.live.test_accessibility import states

pytestmark = pytest.mark.nightly  # in a browser
View = Any  # see conftest.py
MOST = 1.2e6  # bytes of all files, without compression
LOADED = """["navigation", "resource"].flatMap(kind => performance.getEntriesByType(kind))
    .reduce((sum, { decodedBodySize }) => sum + decodedBodySize, 0)"""
# What sheets name: classes of all elements, and weights of fonts.
NAMED = """[...new Set([...document.querySelectorAll("*")].flatMap(element => [
    ...[...element.classList].map(name => `.${name}`),
    `font-weight: ${getComputedStyle(element).fontWeight};`]))]"""


def test_page_loads_little(view: View) -> None:
    assert view.page.evaluate(LOADED) < MOST


def test_no_rule_for_what_is_on_the_page_is_left_out(view: View) -> None:
    """In any of its states; rules of other components are."""
    found: set[str] = set()
    for _ in states(view):
        found |= {*view.page.evaluate(NAMED)}
    assert {".q-btn", ".q-dialog", ".q-item", "font-weight: 400;"} <= found
    assert [name for name in sorted(found) if ABSENT.search(name)] == []
    name = "quasar.unimportant.prod.css"
    before, sheet = (LIBRARY / name).read_text("utf-8"), replacements()[name].decode()
    for rule in (".q-table th{", ".q-btn{"):
        assert rule in before
        assert (rule in sheet) is (rule == ".q-btn{")
    assert sheet.count("{") == sheet.count("}")


def test_html_of_others_would_be_text(view: View) -> None:
    """In place of what DOMPurify leaves of it."""
    text = "<img src=x onerror='window.failed = 1'>"
    shown = "text => { const p = document.createElement('p'); p.setHTML(text); return p.innerHTML }"
    assert view.page.evaluate(shown, text) == "&lt;img src=x onerror='window.failed = 1'&gt;"
