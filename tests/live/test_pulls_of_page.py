"""The rod pulled on the page: by the pointer, and by the keyboard alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.live.view import expect

pytestmark = pytest.mark.nightly  # the module of a rod that is pulled is compiled
View = Any  # see conftest.py
UP = 80  # pixels
WHERE = "import('rodgen-live/hub.js').then(({ hub }) => [...(hub.rod.pull ?? [])])"


@pytest.fixture
def middle(serve: Callable[..., Any], blank: View, scene_file: Callable[..., Path]) -> Any:
    """A rigid rod at rest, and where its middle is on the page."""
    blank.open(serve(str(scene_file("rigid", links=1)), "--port", "0").address).tab("Values")
    blank.page.get_by_role("switch", name="pull").click()
    expect(blank.field("spring")).to_have_value("20")  # M (2 pi/2)^2 = 19.7 N/m, M = 2 kg
    box = blank.page.get_by_role("img", name="rigid").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def _drag(view: View, place: tuple[float, float]) -> None:
    """Take the middle of the rod, and hold the pointer above it."""
    view.page.mouse.move(*place)
    view.page.mouse.down()
    view.page.mouse.move(place[0], place[1] - UP / 2)
    view.page.mouse.move(place[0], place[1] - UP)
    view.sees(WHERE, lambda pull: len(pull) == 6, "no pull")


def _work(view: View, wanted: Any) -> None:
    view.until(lambda: float(view.text("work_pull")), wanted, "another work of the pull")


def test_pointer_pulls_until_it_lets_go(blank: View, middle: tuple[float, float]) -> None:
    """The far end is where the pointer is: the force on the rod has the direction to it, and pulls
    it up; the spring's energy is the work of a hand that stands still."""
    _drag(blank, middle)
    blank.sees(WHERE, lambda pull: pull[3] > 0.02, "not moved to the pointer")
    link, share, x, y, fx, fy = blank.page.evaluate(WHERE)
    assert (link, share, x) == (0, pytest.approx(0.5, abs=0.05), pytest.approx(0.5, abs=0.05))
    assert fy == pytest.approx(20 * y, rel=1e-4)
    assert abs(fx) < 0.05 * fy
    _work(blank, pytest.approx(20 * y**2 / 2, rel=1e-2))
    blank.button("Run (").evaluate("button => button.click()")  # the mouse holds the rod
    blank.state("running").passes(0.1)
    blank.page.mouse.up()
    blank.sees(WHERE, [], "still pulled")
    _work(blank, lambda work: work > 0)  # that it keeps
    assert abs(float(blank.text("energy_balance"))) < 1e-3 * float(blank.text("work_pull"))
    expect(blank.button("Let go")).to_be_disabled()


def test_far_end_stays_with_shift_until_it_is_let_go(
    blank: View, middle: tuple[float, float]
) -> None:
    _drag(blank, middle)
    blank.page.keyboard.down("Shift")
    blank.page.mouse.up()
    blank.page.keyboard.up("Shift")
    blank.page.mouse.move(middle[0] + 200, middle[1])
    expect(blank.button("Let go")).to_be_enabled()
    assert len(blank.page.evaluate(WHERE)) == 6
    blank.page.keyboard.press("Escape")  # the picture has the focus
    blank.sees(WHERE, [], "still pulled")
    blank.page.keyboard.press("p")
    expect(blank.page.get_by_role("switch", name="pull")).not_to_be_checked()
    blank.page.get_by_role("switch", name="pull").click()
    blank.page.get_by_role("switch", name="stay").click()
    blank.page.get_by_role("switch", name="kick").click()
    expect(blank.page.get_by_role("switch", name="pull")).not_to_be_checked()


def test_pull_by_the_keyboard(blank: View, middle: tuple[float, float]) -> None:
    """The tail is at (1, 0), and the far end at (1, 0.5): k d^2/2 = 20/8 J are put in."""
    keyboard = blank.page.keyboard
    blank.button("Pull").focus()
    keyboard.press("Enter")
    dialog = blank.page.get_by_role("dialog")
    expect(dialog.locator("input").first).to_be_focused()
    for text in ("7", "1", "1", "0.5"):
        keyboard.press("Control+a")
        keyboard.type(text)
        keyboard.press("Tab")
    dialog.get_by_role("button", name="Pull").press("Enter")
    expect(dialog.locator(".q-field__messages").filter(has_text="from 0 to 0")).to_be_visible()
    blank.fill("link", "0")
    expect(dialog).to_have_count(0)
    _work(blank, pytest.approx(2.5))
    blank.fill("spring", "40")
    _work(blank, pytest.approx(5.0))
    blank.button("Let go").press("Enter")
    _work(blank, pytest.approx(0.0, abs=1e-12))
