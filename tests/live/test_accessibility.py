"""What axe-core finds in the page: in its states, light and dark, on a screen and on a phone."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.resources import files
from typing import Any

import pytest

from tests.live.view import expect

pytestmark = pytest.mark.long  # axe looks at every element, in eight states of four pages
View = Any  # see conftest.py
SIZES = {"wide": {"width": 1280, "height": 800}, "phone": {"width": 390, "height": 844}}
GRAVE = ("serious", "critical")
# But for buttons of dialogs: before 4.14, axe takes what lies behind the dialog for their ground.
FOUND = """axe.run({ exclude: [".q-dialog .q-btn"] }, { resultTypes: ["violations"] })
    .then(({ violations }) => violations.map(({ id, impact, nodes }) =>
        [impact, id, nodes.map(node => node.failureSummary)]))"""

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
    return [found for found in view.page.evaluate(FOUND) if found[0] in GRAVE]


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
    view.page.get_by_role("combobox", name="View").click()
    expect(view.page.get_by_role("listbox")).to_be_visible()
    yield "a list"
    view.page.keyboard.press("Escape")
    view.tab("Parameters").fill("mass M", "-3")
    expect(view.page.locator(".q-field__messages", has_text="greater than").first).to_be_visible()
    yield "refused"
    view.run()
    yield "running"


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
