"""Plots in the page: the dialog that adds them, their axes, keys and files."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.scene import Scene
from tests.live.conftest import ROD
from tests.live.view import expect

SCENES = Path(__file__).parents[2] / "scenes"
View = Any  # see conftest.py
KINDS = {
    "over time": {"quantities": "omega_3"},
    "one over another": {"quantity": "omega_4", "over": "phi_4"},
    "Poincaré": {"quantity": "omega_4", "over": "phi_4", "points_where": "omega_0"},
    "all of a kind": {},
    "spectrum": {"quantity": "omega_4"},
}


# The dialog ------------------------------------------------------------------------------------


def said(view: View, label: str) -> str:
    """What stands below a field."""
    field = view.page.get_by_role("dialog").locator(".q-field", has_text=label)
    return "".join(field.locator(".q-field__messages").all_text_contents()).strip()


@pytest.mark.nightly
def test_every_kind_of_plot_gets_rows(view: View) -> None:
    view.run()
    for at, (kind, chosen) in enumerate(KINDS.items(), 3):
        dialog = view.plot_dialog(kind, **chosen)
        if not chosen:
            dialog.get_by_role("combobox", name="kind of quantity").fill("bending")
            view.page.get_by_role("option").filter(has_text="bending").first.click()
        dialog.get_by_role("button", name="Add").click()
        expect(dialog).to_have_count(0)
        rows = f"rodgenLive.plots.p{at}?.rows"
        view.sees(rows, lambda count: (count or 0) >= 1, f"{kind}: no rows")
        view.button("Remove").last.click()
        view.sees(rows, None, f"{kind}: not removed")


@pytest.mark.nightly
def test_what_is_missing_or_refused_is_said_beside_its_field(view: View) -> None:
    """And only what this kind of plot has is in the page."""
    dialog = view.plot_dialog("Poincaré", over="phi_3")
    add = dialog.get_by_role("button", name="Add")
    add.click()
    asked = "points where", "quantity", "over", "while it is", "title"
    missing = ["not chosen", "not chosen", "", "", ""]
    view.until(lambda: [said(view, label) for label in asked], missing, "another is not chosen")
    for label, name in (("quantity", "omega"), ("points where", "tip_x")):
        dialog.get_by_role("combobox", name=label, exact=True).fill(name)
        view.page.get_by_role("option").filter(has_text=f"({name})").click()
        view.until(lambda label=label: said(view, label), "", "it still stands there")
    for label, text, expected, good in (
        ("reaches the value", "abc", "must be a number", "0"),
        ("reaches the value", "1e999", "must be a number", "0"),
        ("and again", "-1", "must be a number from 0", ""),
        ("title", "x" * 81, "must be at most 80", ""),
        ("which rates of the links", "5", "must be one of 0 to 4", "3"),
    ):
        field = dialog.get_by_role("textbox", name=label)
        field.fill(text)
        add.click()
        expect(dialog.locator(".q-field--error")).to_have_count(1)
        expect(dialog.locator(".q-field--error").filter(has_text=label)).to_contain_text(expected)
        expect(dialog.locator(".rg-failed")).to_have_text("")
        field.fill(good)
    dialog.get_by_role("button", name="Cancel").click()
    expect(dialog).to_have_count(0)
    dialog = view.plot_dialog("spectrum")
    labels = dialog.locator(".q-field__label")
    fields = ["kind of plot", "quantity", "window", "axes", re.compile("^title")]
    expect(labels).to_have_text(fields)
    dialog.get_by_role("textbox", name="window").fill("7")
    dialog.get_by_role("combobox", name="kind of plot").click()
    view.page.get_by_role("option").filter(has_text="phase plot").click()
    expect(dialog.get_by_role("combobox", name="over")).to_be_visible()
    expect(dialog.get_by_role("textbox", name="window")).to_have_value("7")


@pytest.mark.nightly
def test_kinds_are_offered_first_and_then_which(
    serve: Callable[..., Any], blank: View, scene_file: Callable[..., Path]
) -> None:
    """So that the list of a long rod is as short as any; and "cg" finds the centre of gravity."""
    view = blank.open(serve(str(scene_file("long", links=200)), "--port", "0").address)
    dialog = view.plot_dialog("over time")
    field = dialog.get_by_role("combobox", name="quantities", exact=True)
    options = view.page.get_by_role("option")
    field.fill("cg")
    expect(options.filter(has_text="(centre_of_gravity_x)")).to_be_visible()
    expect(options.filter(has_text="(tip_x)")).to_have_count(0)
    field.fill("omega")
    expect(options).to_have_count(1)
    options.filter(has_text="(omega)").click()
    view.page.keyboard.press("Escape")
    asked = dialog.get_by_role("textbox", name="which rates of the links, of 0 to 199")
    expect(asked).to_have_value("199")
    asked.fill("0, 2-4")
    dialog.get_by_role("button", name="Add").click()
    expect(dialog).to_have_count(0)
    expect(view.page.locator(".rodgen-plot").last).to_contain_text("ω₀, ω₂, ω₃, ω₄")


@pytest.mark.nightly
def test_a_stroboscope_with_a_title(view: View) -> None:
    """Points at t = 0.105, 0.305, 0.505, ... s."""
    dialog = view.plot_dialog("Poincaré", quantity="omega_3", over="t", points_where="t")
    dialog.get_by_role("textbox", name="reaches the value").fill("0.105")
    dialog.get_by_role("textbox", name="and again").fill("0.2")
    units = dialog.locator(".q-field__suffix")
    expect(units).to_have_text(["s", "s"])
    dialog.get_by_role("textbox", name="title").fill("stroboscope")
    dialog.get_by_role("button", name="Add").click()
    expect(view.page.locator(".rodgen-plot", has_text="stroboscope")).to_be_visible()
    view.pause_after(0.8)
    # The last is known two samples late.
    rows = view.until(lambda: view.csv(2)[1], lambda rows: len(rows) >= 3, "too few points")
    t = rows[:, 0]
    # Rounding alone: t is a straight line through the samples.
    np.testing.assert_allclose(t, 0.105 + 0.2 * np.arange(len(t)), atol=1e-12)


# Axes ------------------------------------------------------------------------------------------


def scales(view: View, body: str) -> Any:
    """What comes of a function of the named exports of scales.js."""
    return view.page.evaluate(f"import('rodgen-live/scales.js').then(({body}))")


@pytest.mark.nightly
def test_axes_and_keys(view: View) -> None:
    """A constant lies within them, and they are far from the smallest doubles; they follow as soon
    as it moves; what is zero but for rounding is written so."""
    for low, high, ends in (
        (0.0, 0.0, [-1, 1]),
        (5.0, 5.0, [4.4, 5.6]),  # steps of 0.1 beyond 10 %
        (-2e-310, -2e-310, [-1e-290, 1e-290]),
        (4.366234567891, 4.366234567891003, [3.9, 4.9]),  # a constant but for rounding
        (0.0, 1.0, [-0.2, 1.2]),
    ):
        follow = f"const r = new Range(); r.follow({low}, {high}, 0)"
        found = scales(view, f"({{ Range }}) => {{ {follow}; return r.ends; }}")
        assert found[0] < low <= high < found[1]
        assert found == pytest.approx(ends, rel=0.05, abs=0.0)
    follow = "const r = new Range(); r.follow(0, 0, 0); r.follow(0, 0.01, 1)"
    low, high = scales(view, f"({{ Range }}) => {{ {follow}; return r.ends; }}")
    assert -0.01 < low < 0.0 < 0.01 < high < 0.02
    for value, step, text in (
        (1e-18, 1e-5, "0"),
        (-1e-17, 0.1, "0.0"),
        (2e-5, 1e-5, "2e−5"),
        (7.5, 2.5, "7.5"),
        (7.5e-5, 2.5e-5, "7.5e−5"),
        (12500.0, 2500.0, "12500"),
    ):
        assert scales(view, f"({{ written }}) => written({value}, {step})") == text
    # A time has the decimals in which a step of it is seen.
    for times, text in (([0, 0.02, 0.04], "0.04"), ([0, 1e-4], "0.0001"), ([0, 1 / 60], "0.02")):
        of = "const w = new Written(); let said; for (const t of {0}) said = w.of(t); return said"
        assert scales(view, f"({{ Written }}) => {{ {of.format(times)}; }}") == text
    # Units that differ stand in the key.
    view.add_plot("over time", quantities="omega_0 kinetic_energy")
    plots = view.page.locator(".rodgen-plot")
    expect(plots.nth(2).locator(".rodgen-key")).to_have_text("ω₀ [rad/s]kinetic energy [J]")
    for at in (0, 1):
        expect(plots.nth(at).locator(".rodgen-key")).not_to_contain_text("[")  # the axis says it


# Texts that are drawn from now on, and the box of each in its canvas.
TEXTS = """() => {
    window.texts = [];
    const draw = CanvasRenderingContext2D.prototype.fillText;
    CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
        const to = this.getTransform(), size = this.measureText(text);
        const corners = [-size.actualBoundingBoxLeft, size.actualBoundingBoxRight].flatMap(dx =>
            [-size.actualBoundingBoxAscent, size.actualBoundingBoxDescent].map(dy =>
                to.transformPoint(new DOMPoint(x + dx, y + dy))));
        const [xs, ys] = ["x", "y"].map(k => corners.map(corner => corner[k]));
        texts.push([text, Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)]);
        draw.apply(this, arguments);
    };
}"""


@pytest.mark.nightly
def test_base_of_large_numbers_is_within_the_picture(
    serve: Callable[..., Any], blank: View, tmp_path: Path
) -> None:
    """x of a rod at 43 662 123 m: what the axis counts from stands with the name of the axis."""
    text = (SCENES / "missile.toml").read_text(encoding="utf-8")
    far = tmp_path / "far.toml"
    far.write_text(text.replace("position = [0.0,", "position = [43662123.4,"))
    view = blank.open(serve(str(far), "--port", "0").address)
    view.add_plot("over time", quantities="x0")
    view.run()
    view.page.evaluate(TEXTS)
    wanted = "texts.filter(([text]) => text.startsWith('x₀ from')).slice(-1)"
    view.sees("rodgenLive.plots.p3?.draws ?? 0", lambda draws: draws > 3, "nothing is drawn")
    [[text, left, top, right, bottom]] = view.sees(wanted, lambda found: len(found) == 1, "no base")
    assert text.startswith("x₀ from 4.366")
    assert text.endswith("e7 [m]")
    width, height = view.page.evaluate(
        "(({ width, height }) => [width, height])"
        "(document.querySelectorAll('.rodgen-chart canvas')[2])"
    )
    assert 0 <= left < right <= width
    assert 0 <= top < bottom <= height


# Files -----------------------------------------------------------------------------------------


@pytest.mark.nightly
def test_csv_ends_where_the_plot_is_paused_and_has_times(view: View) -> None:
    """Angles against a run without a page; and the picture of a plot."""
    view.add_plot("phase plot", quantity="omega_0", over="phi_0")
    plots = view.page.locator(".rodgen-plot")
    expect(plots.nth(2)).to_be_visible()
    before = view.run().passes(0.3).live("t")
    for at in (0, 2):
        plots.nth(at).get_by_role("button", name="Pause").click()
        expect(plots.nth(at).get_by_role("button", name="Resume")).to_be_visible()
    after = view.live("t")
    view.passes(0.5)
    sol = rodgen.simulate(Scene.from_dict(ROD), rtol=1e-10, span=[0.0, after + 1.0])
    head, rows = view.csv(0)
    assert head[0] == "t [s]"
    assert before - 0.1 < rows[-1, 0] < after + 0.2
    expected = np.interp(rows[:, 0], sol.t, sol.phi[:, -1])
    assert rows[:, 2] == pytest.approx(expected, abs=1e-3)  # interpolated over 0.01 s
    head, rows = view.csv(2)
    assert head == ["t [s]", "φ₀ [rad]", "ω₀ [rad/s]"]
    assert before - 0.1 < rows[-1, 0] < after + 0.2
    expected = np.interp(rows[:, 0], sol.t, sol.phi[:, 0])
    assert rows[:, 1] == pytest.approx(expected, abs=1e-3)
    assert view.csv(1)[1][-1, 0] > after + 0.4
    picture = view.download(view.page.get_by_role("button", name="PNG").last)
    assert picture.read_bytes()[:4] == b"\x89PNG"
