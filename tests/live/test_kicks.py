"""Kicks that are asked for in the page: by a click on a link, and by the keyboard alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.live.view import expect

pytestmark = pytest.mark.nightly
View = Any  # see conftest.py


def test_click_on_a_link_asks_in_kick_mode_alone(view: View) -> None:
    def click() -> None:
        """The rod is straight but for a little, and its centre of gravity is in the middle."""
        box = view.page.get_by_role("img", name="dart").bounding_box()
        view.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)

    view.sent()
    click()
    assert view.sent() == []
    view.page.get_by_role("switch", name="kick").click()
    expect(view.field("N s per metre")).to_be_visible()
    click()
    expect(view.field("link")).to_have_value("2")


def test_kick_by_the_keyboard(
    serve: Callable[..., Any], blank: View, scene_file: Callable[..., Path]
) -> None:
    """A rigid rod at rest, M = 2 kg, L = 1 m, is given J = (4, 2) N s at its end: Jx^2/2M = 4 J,
    Jy^2/2M = 1 J, and (Jy L/2)^2/2I = 3 J with I = M L^2/12."""
    path = scene_file("rigid", links=1)
    blank.open(serve(str(path), "--port", "0").address).tab("Values")
    keyboard = blank.page.keyboard
    blank.button("Kick").focus()
    keyboard.press("Enter")
    dialog = blank.page.get_by_role("dialog")
    fields = dialog.locator("input")
    expect(fields.first).to_be_focused()
    for at, text in enumerate(("3", "1", "4", "nan")):
        expect(fields.nth(at)).to_be_focused()
        keyboard.press("Control+a")
        keyboard.type(text)
        keyboard.press("Tab")
    refused = dialog.locator(".q-field__messages")
    dialog.get_by_role("button", name="Kick").press("Enter")
    expect(refused.filter(has_text="must be a number")).to_be_visible()
    blank.fill("impulse along y", "2")
    expect(refused.filter(has_text="from 0 to 0")).to_be_visible()
    blank.fill("link", "0")
    expect(dialog).to_have_count(0)
    energy = pytest.approx(8.0)
    blank.until(lambda: float(blank.text("kinetic_energy")), energy, "another kick")
