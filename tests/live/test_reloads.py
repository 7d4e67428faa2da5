"""Pages that are loaded again, beside others: runs, views and shades that are kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from tests.live.view import expect

pytestmark = pytest.mark.long
View = Any  # see conftest.py

GROUND = "getComputedStyle(document.body).backgroundColor"
BACKGROUNDS = f"""
    window.grounds = [];
    const look = () => {{
        const ground = document.body && {GROUND};
        if (ground && grounds.at(-1) !== ground) grounds.push(ground);
        requestAnimationFrame(look);
    }};
    look();
"""


def test_two_pages_have_their_own_runs_and_reload_keeps_them(
    view: View, server: Any, another: Callable[[], View]
) -> None:
    """With view, panel and shade as they were."""
    other = another().open(server.address)
    first = view.dark()
    view.button("Light or dark").click()
    view.until(view.dark, not first, "the shade stays")
    view.tab("Scene")
    view.select("View", "turns with the axes")
    view.run().passes(0.5)
    t = view.live("t")
    assert other.live("t") == 0.0
    view.page.add_init_script(BACKGROUNDS)
    view.reload()
    assert view.live("t") > t
    expect(view.button("Pause (")).to_be_visible()
    expect(view.page.get_by_role("tab", name="Scene", selected=True)).to_be_visible()
    expect(view.page.locator(".rg-view")).to_contain_text("turns with the axes")
    view.until(view.dark, not first, "the first shade again")
    assert view.page.evaluate("grounds") == [view.page.evaluate(GROUND)]  # nor did it flash
    assert other.live("t") == 0.0
