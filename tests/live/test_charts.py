"""Charts of the page: one cursor for all of them, zoom, and what a reset leaves of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rodgen.live.run.link import Link
from rodgen.scene import Scene
from tests.live.conftest import ROD
from tests.live.view import expect

pytestmark = pytest.mark.nightly  # a page that runs
View = Any  # see conftest.py


def at(view: View, plot: int, share: float) -> tuple[float, float]:
    """A point in the middle of a chart's height, in pixels of the page."""
    box = view.page.locator(".rodgen-chart .u-over").nth(plot).bounding_box()
    return box["x"] + share * box["width"], box["y"] + box["height"] / 2


def ends(view: View, plot: str) -> Any:
    """From where to where a plot shows: [x, y]."""
    return view.page.evaluate(f"(({{ x, y }}) => [x, y])(rodgenLive.plots.{plot})")


def test_the_cursor_is_linked(view: View) -> None:
    """Where the pointer is over one plot, all tell their values of that time, as the files have
    them, and the rod is as it was then; without one, none does."""
    view.add_plot("phase plot", quantity="omega_0", over="phi_0")
    view.pause_after(0.6)
    view.page.mouse.move(*at(view, 0, 0.4))
    hints = view.page.locator(".rodgen-hint")
    for plot in range(3):
        expect(hints.nth(plot)).to_be_visible()
    view.until(
        lambda: len(
            {
                next(line for line in text.split("\n") if line.startswith("t ="))
                for text in hints.all_inner_texts()
            }
        ),
        1,
        "not of one time",
    )
    told = [
        dict(line.replace("\u2212", "-").split(" = ") for line in text.split("\n"))
        for text in hints.all_inner_texts()
    ]
    t = float(told[0]["t"].split()[0])
    view.until(lambda: view.live("t"), pytest.approx(t), "the rod is of another time")
    head, rows = view.csv(0)  # by a click, for which the pointer leaves the plot
    row = rows[np.abs(rows[:, 0] - t).argmin()]
    assert 0 < t < rows[-1, 0]
    assert head[1].startswith("phi_0")
    for texts in (told[0], told[2]):  # five digits are told
        assert float(texts["φ₀"].split()[0]) == pytest.approx(row[1], rel=1e-4)
    view.page.mouse.move(5, 5)
    for plot in range(3):
        expect(hints.nth(plot)).to_be_hidden()
    view.until(lambda: view.live("t"), rows[-1, 0], "the rod is not of the present")


def test_a_part_that_is_dragged_is_shown(view: View) -> None:
    """In all plots over time, but not in one that is paused."""
    view.add_plot("over time", quantities="tip_x")
    view.pause_after(0.6)
    view.page.get_by_role("button", name="Pause x of the tail").click()
    low, high = ends(view, "p1")[0]
    view.page.mouse.move(*at(view, 0, 0.25))
    view.page.mouse.down()
    view.page.mouse.move(*at(view, 0, 0.5), steps=4)
    view.page.mouse.up()
    badges = view.page.locator(".rodgen-badge")
    expect(badges.first).to_have_text("zoomed")
    wanted = [low + share * (high - low) for share in (0.25, 0.5)]
    # Within two of some 250 pixels.
    close = pytest.approx(wanted, abs=0.01 * (high - low))
    view.until(lambda: ends(view, "p1")[0], close, "another part")
    view.until(lambda: ends(view, "p2")[0], ends(view, "p1")[0], "another part of the next plot")
    expect(badges.nth(2)).to_have_text("paused")
    view.page.locator(".rodgen-chart .u-over").first.dblclick()
    expect(badges.first).to_have_text("")
    expect(badges.nth(1)).to_have_text("")
    view.until(lambda: ends(view, "p1")[0], [low, high], "not all again")


def test_a_reset_begins_plots_anew(view: View) -> None:
    """Their ranges too. One that is paused keeps the run that it shows until it is let go."""
    view.add_plot("over time", quantities="total_energy")
    view.pause_after(0.8)
    first = view.page.locator(".rodgen-plot").first
    first.get_by_role("button", name="Pause").click()
    kept = view.csv(0)[1]
    # It may be out of sight, and drawn late.
    wide = view.until(lambda: ends(view, "p3")[0][1], lambda end: end >= 0.8, "not drawn")
    view.button("Reset to").click()
    view.until(lambda: view.live("t"), 0.0, "not reset")
    view.until(lambda: ends(view, "p3")[0][1], lambda end: end < wide, "the range stays")
    view.pause_after(0.1)
    np.testing.assert_array_equal(view.csv(0)[1], kept)
    expect(view.page.locator(".rodgen-badge").first).to_have_text("paused, run before")
    assert view.csv(2)[1][-1, 0] < kept[-1, 0]
    first.get_by_role("button", name="Resume").click()
    assert view.csv(0)[1][-1, 0] < kept[-1, 0]


def test_a_zoomed_plot_goes_on_with_its_run_alone(view: View) -> None:
    """Zoomed just after a loop has begun again, too, where next to nothing has come of it."""
    shown = view.page.evaluate("""async () => {
        const { Curves } = await import("rodgen-live/curves.js");
        const series = [{ name: "a", turn: 0 }];
        const axis = { log: false, turn: 0 };
        const curves = new Curves({ kind: "time", window: 10, series, x: axis, y: axis });
        const rows = (first) => curves.take([0, 1, 2].flatMap((k) => [first + k, k]));
        const seen = () => [...curves.now(0).across];
        rows(0);
        curves.restart();
        curves.zoom({ x: [3, 5], y: null });
        const found = [seen()];
        rows(3);
        found.push(seen());
        curves.restart();
        rows(8);
        found.push(seen());
        curves.zoom(null);
        found.push(seen());
        return found;
    }""")
    assert shown == [[], [3, 4, 5], [3, 4, 5], [8, 9, 10]]


def test_numbers_at_a_logarithmic_axis(view: View) -> None:
    for low, high, most, ticks in (
        (2.1e-3, 4.9e-3, 5, [3e-3, 4e-3]),  # less than a decade
        (0.15, 30.0, 9, [0.2, 0.5, 1, 2, 5, 10, 20]),
        (1e-3, 1e3, 7, [1e-3, 1e-2, 0.1, 1, 10, 100, 1e3]),
        (1e-9, 1.0, 4, [1e-9, 1e-6, 1e-3, 1]),
    ):
        found = view.page.evaluate(
            f"import('rodgen-live/scales.js').then(s => s.decades({low}, {high}, {most}))"
        )
        assert found == pytest.approx(ticks, rel=1e-12)


def test_one_unit_has_one_scale(view: View) -> None:
    """In a picture of 300 by 100 pixels, unless one would be more than six times as large."""
    alike = "import('rodgen-live/scales.js').then(s => s.alike({}, {{ width: 300, height: 100 }}))"
    found = view.page.evaluate(alike.format("{ x: [0, 1], y: [2, 3] }"))
    assert found == {"x": pytest.approx([-1, 2]), "y": [2, 3]}
    found = view.page.evaluate(alike.format("{ x: [0, 6], y: [-1, 1] }"))
    assert found == {"x": [0, 6], "y": pytest.approx([-1, 1])}
    unlike = {"x": [0, 1], "y": [0, 3]}
    assert view.page.evaluate(alike.format("{ x: [0, 1], y: [0, 3] }")) == unlike


def test_angles_are_shown_without_their_whole_turns(server: Any, blank: View) -> None:
    """Of a rod that turns, over time and along it, until that is switched off; files have them as
    they are."""
    turning = Scene.from_dict({**ROD, "initial": {"omega": 12.0}})
    view = blank.open(f"{server.address}?scene={Link(turning).pack()}").pause_after(0.8)
    button = view.page.get_by_role("button", name="Leave out whole turns of φ₀, φ₄")

    def height() -> float:
        low, high = ends(view, "p1")[1]
        return high - low

    view.until(height, lambda size: size <= 8.0, "more than a turn and some room")
    assert view.csv(0)[1][-1, 1] > 8.0  # 12 rad/s, which bending slows a little
    button.click()
    view.until(height, lambda size: size > 8.0, "whole turns are not shown")
    view.reload()
    expect(button).to_have_attribute("aria-pressed", "false")
