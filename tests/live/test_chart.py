"""Axes, keys and files of plots, in the page."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen

SCENES = Path(__file__).parents[2] / "scenes"
View = Any  # see conftest.py


def module(view: View, name: str, body: str) -> Any:
    """What comes of a function of the named exports of a script of the page."""
    return view.page.evaluate(f"import('rodgen-live/{name}').then(({body}))")


def add(view: View, kind: str, **chosen: str) -> None:
    """A plot by its dialog: of each field, what is typed into it."""
    view.button("Add plot").click()
    dialog = view.page.get_by_role("dialog")
    dialog.get_by_role("combobox", name="kind of plot").click()
    view.page.get_by_role("option").filter(has_text=kind).click()
    for label, text in chosen.items():
        for one in text.split():
            name = label.replace("_", " ")
            dialog.get_by_role("combobox", name=name, exact=True).fill(one)
            view.page.get_by_role("option").filter(has_text=f"({one})").first.click()
        if label == "quantities":
            view.page.keyboard.press("Escape")
    dialog.get_by_role("button", name="Add").click()
    dialog.wait_for(state="hidden")


def saved(view: View, at: int) -> tuple[list[str], np.ndarray]:
    """Head and rows of the CSV of a plot."""
    with view.page.expect_download() as waiting:
        view.page.get_by_role("button", name="CSV").nth(at).click()
    head, *rows = csv.reader(io.StringIO(Path(waiting.value.path()).read_text(encoding="utf-8")))
    return head, np.array(rows, dtype=float)


@pytest.mark.parametrize(
    ("low", "high", "ends"),
    [
        (0.0, 0.0, [-1, 1]),
        (5.0, 5.0, [4.4, 5.6]),  # steps of 0.1 beyond 10 %
        (-2e-310, -2e-310, [-1e-290, 1e-290]),
        (4.366234567891, 4.366234567891003, [3.9, 4.9]),  # a constant but for rounding
        (0.0, 1.0, [-0.2, 1.2]),
    ],
)
def test_ends_of_an_axis(view: View, low: float, high: float, ends: list[float]) -> None:
    """A constant lies within them, and they are far from the smallest doubles."""
    found = module(
        view,
        "calm.js",
        f"({{ Range }}) => {{ const r = new Range(); r.follow({low}, {high}, 0); return r.ends; }}",
    )
    assert found[0] < low <= high < found[1]
    assert found == pytest.approx(ends, rel=0.05, abs=0.0)


def test_axis_of_a_constant_follows_as_soon_as_it_moves(view: View) -> None:
    body = """({ Range }) => { const r = new Range(); r.follow(0, 0, 0); r.follow(0, 0.01, 1);
        return r.ends; }"""
    low, high = module(view, "calm.js", body)
    assert -0.01 < low < 0.0 < 0.01 < high < 0.02


def test_label_that_is_zero_but_for_rounding(view: View) -> None:
    for value, step, text in ((1e-18, 1e-5, "0"), (-1e-17, 0.1, "0.0"), (2e-5, 1e-5, "2e−5")):
        found = module(view, "numbers.js", f"({{ written }}) => written({value}, {step})")
        assert found == text


def test_units_that_differ_stand_in_the_key(view: View) -> None:
    add(view, "over time", quantities="omega_0 kinetic_energy")
    plots = view.page.locator(".rodgen-plot")
    plots.nth(2).wait_for()
    keys = [plots.nth(at).locator(".rodgen-key").text_content() for at in range(3)]
    assert keys[2] == "ω₀ [rad/s]kinetic energy [J]"
    assert "[" not in keys[0] + keys[1]  # the axis says it


def test_csv_ends_where_the_plot_is_paused_and_has_times(view: View) -> None:
    add(view, "phase plot", quantity="omega_0", over="phi_0")
    view.page.locator(".rodgen-plot").nth(2).wait_for()
    view.run()
    view.until(lambda: view.live("t") > 0.3, "time does not pass")
    before = view.live("t")
    for at in (0, 2):
        view.page.locator(".rodgen-plot").nth(at).get_by_role("button", name="Pause").click()
    after = view.live("t")
    view.until(lambda: view.live("t") > after + 0.5, "time does not pass")
    head, rows = saved(view, 0)
    assert head[0] == "t [s]"
    assert before - 0.1 < rows[-1, 0] < after + 0.2
    head, rows = saved(view, 2)
    assert head == ["t [s]", "φ₀ [rad]", "ω₀ [rad/s]"]
    assert before - 0.1 < rows[-1, 0] < after + 0.2
    scene = rodgen.Scene.from_toml(SCENES / "missile.toml")
    sol = rodgen.simulate(scene, span=[0.0, 2.0], rtol=1e-10)
    expected = np.interp(rows[:, 0], sol.t, sol.phi[:, 0])
    assert rows[:, 1] == pytest.approx(expected, abs=1e-3)  # interpolated over 0.01 s
    assert saved(view, 1)[1][-1, 0] > after + 0.4


def test_base_of_large_numbers_is_within_the_picture(
    serve: Callable[..., Any], blank: View, tmp_path: Path
) -> None:
    """x of a rod at 43 662 123 m: what the axis counts from is drawn in a line of its own, which
    the name of the axis does not have."""
    text = (SCENES / "missile.toml").read_text(encoding="utf-8")
    far = tmp_path / "far.toml"
    far.write_text(text.replace("position = [0.0,", "position = [43662123.4,"))
    view = blank.open(serve(str(far), "--port", "0").address)
    add(view, "over time", quantities="x0")
    view.run()
    view.until(lambda: view.live("plots.p3?.draws") > 3, "nothing is drawn")
    boxes = """() => import('nicegui-echart').then(({ echarts }) => {
        const chart = echarts.getInstanceByDom(document.querySelectorAll('.rodgen-chart')[2]);
        const { yAxis } = chart.getOption();
        const found = chart.getZr().storage.getDisplayList()
            .filter(e => e.style?.text?.startsWith('from'))
            .map(e => { const r = e.getBoundingRect().clone(); r.applyTransform(e.transform);
                        return [e.style.text, r.x, r.y, r.x + r.width, r.y + r.height]; });
        return [found, yAxis[0].name, chart.getWidth(), chart.getHeight()];
    })"""
    found, name, width, height = view.page.evaluate(boxes)
    [[said, left, top, right, bottom]] = found
    assert said.startswith("from 4.366")
    assert said.endswith("e7")
    assert name == "x₀ [m]"
    assert 0 <= left < right <= width
    assert 0 <= top < bottom <= height
