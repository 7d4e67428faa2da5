"""What axe-core finds in the page: in its states, light and dark, on a screen and on a phone."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.resources import files
from typing import Any

import pytest

from tests.live.view import expect

pytestmark = pytest.mark.nightly  # axe looks at every element, in eight states of four pages
View = Any  # see conftest.py
SIZES = {"wide": {"width": 1280, "height": 800}, "phone": {"width": 390, "height": 844}}
GRAVE = ("serious", "critical")
# But for buttons of dialogs: before 4.14, axe takes what lies behind the dialog for their ground.
# These are judged by `PALE`.
FOUND = """axe.run({ exclude: [".q-dialog .q-btn"] }, { resultTypes: ["violations"] })
    .then(({ violations }) => violations.map(({ id, impact, nodes }) =>
        [impact, id, nodes.map(node => node.failureSummary)]))"""
# Buttons of dialogs whose words have too little contrast with their ground, that of the nearest
# element around them that has one, by the formula of WCAG 2.2; and how many were looked at.
PALE = """() => {
    const channels = (css) => css.match(/[\\d.]+/g).map(Number);
    const linear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
    const light = ([r, g, b]) =>
        [[0.2126, r], [0.7152, g], [0.0722, b]].reduce((l, [w, c]) => l + w * linear(c / 255), 0);
    const ground = (of) => {
        const [r, g, b, a = 1] = channels(getComputedStyle(of).backgroundColor);
        return a === 1 ? [r, g, b] : a === 0 ? ground(of.parentElement) : null;
    };
    const contrast = (of) => {
        const both = [channels(getComputedStyle(of).color), ground(of)].map(light);
        return (Math.max(...both) + 0.05) / (Math.min(...both) + 0.05);
    };
    const words = [...document.querySelectorAll(".q-dialog .q-btn .block")];
    return [words.length, words.filter((word) => !(contrast(word) >= 4.5)).map(
        (word) => ["serious", "contrast of a button", [word.textContent, contrast(word)]])];
}"""

# What is about to come or go.
FADING = "document.querySelectorAll('[class*=-enter-], [class*=-leave-]').length"


@cache
def axe() -> str:
    """The text of axe-core."""
    pytest.importorskip("axe_playwright_python", reason="axe-core is not installed")
    return files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8")


def grave(view: View) -> list[Any]:
    """What keeps somebody from using the page as it is now."""
    view.page.evaluate(axe())
    view.sees(FADING, 0, "still fading in, where no colours can be judged")
    buttons, pale = view.page.evaluate(PALE)
    assert bool(buttons) == bool(view.page.locator(".rg-dialog").count())
    return [found for found in [*view.page.evaluate(FOUND), *pale] if found[0] in GRAVE]


@contextmanager
def opened(view: View, button: str, role: str = "dialog") -> Iterator[None]:
    """What a button opens is there; and has gone, by Escape."""
    view.button(button).click()
    shown = view.page.get_by_role(role)
    expect(shown).to_be_visible()
    yield
    view.page.keyboard.press("Escape")
    expect(shown).to_have_count(0)


def states(view: View) -> Iterator[str]:
    """Brings the page from one state to the next, and tells their names."""
    for tab in ("Values", "Parameters", "Scene", "Save"):
        view.tab(tab)
        yield tab
    view.page.get_by_role("switch", name="pull").click()
    yield "pulls"
    for button in ("What is shown", "Kick", "Pull", "Add plot", "Keys"):
        if not view.button(button).is_visible():  # a phone has no keys
            continue
        with opened(view, button):
            yield button
    for chosen in ("View", "Scene"):
        view.page.get_by_role("combobox", name=chosen).click()
        expect(view.page.get_by_role("listbox")).to_be_visible()
        yield f"list: {chosen}"
        view.page.keyboard.press("Escape")
        expect(view.page.get_by_role("listbox")).to_have_count(0)
    view.select("Scene", "bad")
    expect(view.page.get_by_role("alert").filter(has_text="name")).to_be_visible()
    yield "a notification"
    view.close_notes()
    view.button("Mode shapes").click()
    expect(view.page.get_by_role("combobox", name="Mode")).to_have_value(re.compile("Hz"))
    yield "mode shapes"
    view.tab("Parameters")
    view.button("Sweep of follower force P").click()
    swept = view.page.get_by_role("group", name="sweep of follower force P")
    yield "sweeping"
    expect(swept.get_by_text("straight")).to_be_visible()
    yield "swept"
    view.button("Sweep of follower force P").click()
    view.tab("Parameters").fill("mass M", "-3")
    expect(view.page.locator(".q-field__messages", has_text="greater than").first).to_be_visible()
    yield "refused"
    view.run()
    yield "running"
    view.button("Keep each run").click()
    view.passes(0.2).pause()
    view.button("Reset to").click()
    view.page.get_by_role("slider", name="Time that is shown").press("Home")
    yield "beside a run that is kept"
    view.pause_after(0.1)
    view.page.get_by_role("slider", name="Time that is shown").press("Home")
    expect(view.button("To the present")).to_be_enabled()
    yield "looking back"


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_nothing_keeps_anybody_from_the_page(
    server: Any, blank: View, size: str, scheme: str
) -> None:
    blank.page.set_viewport_size(SIZES[size])
    blank.page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
    view = blank.open(server.address)
    found = {state: grave(view) for state in states(view)}
    assert found == {state: [] for state in found}
    expect(view.page.get_by_role("heading", level=1)).to_have_text("rodgen")


def test_slider_that_has_the_focus_says_what_it_is(view: View) -> None:
    """The element that takes the keys, after they have moved it too."""
    slider = view.tab("Parameters").page.get_by_role("slider", name="mass M")
    slider.focus()
    before = slider.get_attribute("aria-valuetext")
    view.page.keyboard.press("ArrowRight")
    view.until(
        lambda: slider.get_attribute("aria-valuetext"), lambda now: now != before, "still the same"
    )
    assert slider.get_attribute("aria-valuetext").endswith(" kg")
