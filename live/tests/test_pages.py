"""Pages that are loaded again or cut off, and what all plots of a page have in common."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest

from live.tests.view import View, expect

pytestmark = pytest.mark.nightly  # in a browser


def test_two_pages_have_their_own_runs_and_reload_keeps_them(server: Any, another: Any) -> None:
    """With the panel and the time as they were; what differs from the file is in a link to it."""
    view, other = (another(apart=True).open(server.address) for _ in range(2))
    view.fill("mass M", "4")
    view.shows("mass", 4.0).pause_after(0.2).line().press("PageDown")
    t = view.sees("live.past")
    view.tab("Save").button("Link to what").click()
    expect(view.field("link")).to_have_value(re.compile("scene="))
    view.page.reload()
    view.ready().shows("mass", 4.0)
    assert view.live("live.t") == t
    expect(view.page.get_by_role("tab", name="Save", selected=True)).to_be_visible()
    assert other.live("[live.t, number(live.texts.mass)]") == [0.0, 3.0]


def test_page_that_was_cut_off_shows_what_is(server: Any, blank: View) -> None:
    """Its run has gone on meanwhile, and its buttons do what they say."""
    ends: list[Any] = []

    def passes(socket: Any) -> None:
        ends.extend((socket, socket.connect_to_server()))

    blank.page.route_web_socket("**", passes)
    blank.open(server.address).run()
    t = blank.live("live.t")
    for end in ends.copy():
        end.close()
    blank.sees("!live.connected")
    blank.sees("live.connected && live.t > given", t)
    blank.pause()
    blank.fill("mass M", "4")
    blank.shows("mass", 4.0)


def test_cursor_zoom_and_reset_are_of_all_plots(view: View) -> None:
    """All look at the time under the pointer, and show the part that is dragged; a reset begins
    them anew."""
    view.pause_after(0.6)
    charts = view.page.get_by_role("region", name="Plots").get_by_role("region")
    box = charts.first.locator("canvas").bounding_box()

    def point(share: float) -> tuple[float, float]:
        return box["x"] + share * box["width"], box["y"] + box["height"] / 2

    view.page.mouse.move(*point(0.5))
    view.sees("Object.values(live.plots).every(({ at }) => at !== null) && live.past !== null")
    wide = view.live("live.plots.p1.x")
    view.page.mouse.down()
    view.page.mouse.move(*point(0.75), steps=4)
    view.page.mouse.up()
    # A quarter of the picture, which is a little wider than its axis.
    view.sees("live.plots.p1.x[1] - live.plots.p1.x[0] < given / 2", wide[1] - wide[0])
    view.sees("live.plots.p2.x.every((end, k) => end === live.plots.p1.x[k])")
    view.page.get_by_role("button", name="Reset zoom").first.click()
    view.sees("live.plots.p1.x.every((end, k) => end === given[k])", wide)
    view.button("Reset to").click()
    view.sees("live.t === 0 && Object.values(live.plots).every(({ seen }) => seen === 1)")


def script(view: View, module: str, body: str) -> Any:
    """What comes of a function of the exports of a module of the page."""
    return view.page.evaluate(f"import('rodgen-live/{module}.js').then(({body}))")


def test_a_curve_loses_the_whole_turns_of_its_mean(view: View) -> None:
    """And is not cut where it is more than half a turn away: of flutter about 4 pi, by 4 rad to
    either side, as of two curves beside each other. Points of a section lose theirs one by one."""
    angle = {"turn": 2 * np.pi, "least": 0}
    now = """({ Curves }) => { const curves = new Curves(%s); curves.take(%s, true);
        return curves.now(0).up.map((values) => Array.from(values)); }"""
    t = np.arange(0.0, 10.0, 0.01)
    swing = 4 * np.sin(2 * np.pi * t)

    def drawn(kind: str, rows: list[Any], **more: Any) -> np.ndarray:
        curves = [angle] * (1 if kind == "poincare" else len(rows) - 1)
        spec = {"kind": kind, "x": {"turn": 0}, "y": angle, "series": curves, "window": 20}
        given = json.dumps({**spec, "wrapped": True, **more}), np.transpose(rows).ravel().tolist()
        return np.array(script(view, "curves", now % given))

    found = drawn("time", [t, 4 * np.pi + swing, 4 * np.pi + swing / 2 + 3.2])
    assert found == pytest.approx(np.array([swing, swing / 2 + 3.2]), abs=1e-12)
    kept = drawn("time", [t, 4 * np.pi + swing], wrapped=False)
    assert kept == pytest.approx(4 * np.pi + swing[None], abs=1e-12)
    points = drawn("poincare", [t, t, 40 * t + 1.0])
    assert np.abs(points).max() <= np.pi


def test_axes_and_their_numbers(view: View) -> None:
    """A constant lies within them, and they are far from the smallest doubles; what is zero but for
    rounding is written so."""
    for low, high, ends in (
        (0.0, 0.0, [-1, 1]),
        (5.0, 5.0, [4.4, 5.6]),  # steps of 0.1 beyond 10 %
        (-2e-310, -2e-310, [-1e-290, 1e-290]),
        (4.366234567891, 4.366234567891003, [3.9, 4.9]),  # a constant but for rounding
        (0.0, 1.0, [-0.2, 1.2]),
    ):
        follow = f"const r = new Range(); r.follow({low}, {high}, 0); return r.ends;"
        found = script(view, "scales", f"({{ Range }}) => {{ {follow} }}")
        assert found == pytest.approx(ends, rel=0.05, abs=0.0)
    for value, step, text in (
        *((1e-18, 1e-5, "0"), (-1e-17, 0.1, "0.0"), (2e-5, 1e-5, "2e−5"), (7.5, 2.5, "7.5")),
        *((7.5e-5, 2.5e-5, "7.5e−5"), (12500.0, 2500.0, "12500")),
    ):
        assert script(view, "scales", f"s => s.written({value}, {step})") == text
    for low, high, most, ticks in (
        (2.1e-3, 4.9e-3, 5, [3e-3, 4e-3]),  # less than a decade
        (0.15, 30.0, 9, [0.2, 0.5, 1, 2, 5, 10, 20]),
        (1e-9, 1.0, 4, [1e-9, 1e-6, 1e-3, 1]),
    ):
        found = script(view, "scales", f"s => s.decades({low}, {high}, {most})")
        assert found == pytest.approx(ticks, rel=1e-12)
