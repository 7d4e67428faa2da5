"""Pages that are loaded again, beside others: runs, views and shades that are kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from tests.live.view import expect

pytestmark = pytest.mark.nightly
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


# Hears nothing any more, and is cut off a second later, for five.
CUT_OFF = """() => {
    const manager = socket.io;
    manager.reconnectionDelay(5000);
    manager.reconnectionDelayMax(5000);
    manager.randomizationFactor(0);
    manager.engine.transport.onData = manager.engine.transport.onPacket = () => {};
    socket.on("connect", () => window.back = true);
    setTimeout(() => manager.engine.close(), 1000);
}"""


def test_page_that_was_cut_off_shows_what_is(view: View) -> None:
    """While it was, a module was made; what was said of that meanwhile comes late, and goes."""
    view.page.evaluate(CUT_OFF)
    view.page.get_by_role("switch", name="pull").click()
    view.sees("window.back", True, "not connected again")
    view.run()  # what is said of that comes behind all the rest
    expect(view.page.locator(".rg-making")).to_be_hidden()
