"""Plots in the page: the dialog that adds them, one cursor and zoom for all, axes and numbers."""

from __future__ import annotations

from typing import Any

import pytest

from tests.live.view import View, expect

pytestmark = pytest.mark.nightly  # in a browser
KINDS = {
    "over time": {"quantities": "kinetic_energy"},
    "one over another": {"quantity": "omega", "over": "phi"},
    "Poincaré": {"quantity": "omega", "over": "phi", "points_where": "t"},
    "all of a kind": {},
    "spectrum": {"quantity": "tip_x"},
}


def test_every_kind_of_plot_gets_rows_and_says_what_it_lacks(view: View) -> None:
    view.run()
    for kind, chosen in KINDS.items():
        dialog = view.plot_dialog(kind, **chosen)
        if not chosen:
            dialog.get_by_role("button", name="Add").click()
            wrong = dialog.get_by_role("combobox", name="kind of quantity")
            expect(wrong).to_have_attribute("aria-invalid", "true")
            wrong.fill("bending")
            view.page.get_by_role("option").filter(has_text="bending").first.click()
        if kind == "Poincaré":
            every = dialog.get_by_role("textbox", name="and again")
            for text in ("-1", "0.1"):
                every.fill(text)
                dialog.get_by_role("button", name="Add").click()
                if text == "-1":
                    expect(every).to_have_attribute("aria-invalid", "true")
        else:
            dialog.get_by_role("button", name="Add").click()
        expect(dialog).to_have_count(0)
        view.sees("Object.values(live.plots)[2]?.rows > 0")
        view.button("Remove").last.click()
        view.sees("Object.values(live.plots).length === 2")


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
    size = "live.plots.{}.x[1] - live.plots.{}.x[0]"
    # A quarter of the picture, which is a little wider than its axis.
    view.sees(f"{size.format('p1', 'p1')} < given / 2", wide[1] - wide[0])
    view.sees("live.plots.p2.x.every((end, k) => end === live.plots.p1.x[k])")
    view.page.get_by_role("button", name="Reset zoom").first.click()
    view.sees("live.plots.p1.x.every((end, k) => end === given[k])", wide)
    view.button("Reset to").click()
    view.sees("live.t === 0 && Object.values(live.plots).every(({ seen }) => seen === 1)")


def script(view: View, module: str, body: str) -> Any:
    """What comes of a function of the exports of a module of the page."""
    return view.page.evaluate(f"import('rodgen-live/{module}.js').then(({body}))")


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
