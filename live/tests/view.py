"""A page of the live view in a browser, and the ways to wait for what it does."""

from __future__ import annotations

import csv
import io
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

if TYPE_CHECKING:
    from playwright.sync_api import Locator, LocatorAssertions, Page

T = TypeVar("T")
PATIENT = 20.0  # seconds for anything that is waited for, on a busy machine too
DIGITS = 5.1e-5  # of five digits half of the last, of a number that begins with 1
# What expressions know: the state of the page, and a number of the panel of values by its text.
KNOWN = """const live = window.rodgenLive, number = text =>
    Number((text ?? "").replace(/[\\u2007\\u202f]/g, "").replace("\\u2212", "-") || NaN);"""


def until(look: Callable[[], T], wanted: T | Callable[[T], bool], what: str) -> T:
    """What is seen, once it is as wanted: equal to that, or such that it says so. If it never is,
    fail with `what`, and with what was seen last."""
    end = time.monotonic() + PATIENT
    while True:
        seen = look()
        if wanted(seen) if callable(wanted) else seen == wanted:
            return seen
        assert time.monotonic() < end, f"{what}: {seen!r}"
        time.sleep(0.02)


def expect(locator: Locator) -> LocatorAssertions:
    """Playwright's assertions, which wait for what they assert."""
    from playwright import sync_api

    return sync_api.expect(locator)


class View:
    """A page of the live view, with what went wrong in it and where it asked."""

    def __init__(self, page: Page):
        self.page = page
        self.errors: list[str] = []
        self.asked: list[str] = []
        page.set_default_timeout(1000 * PATIENT)
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))

    def open(self, address: str) -> View:
        self.page.goto(address)
        return self.ready()

    def ready(self) -> View:
        """The page is built, and the rod and all plots are drawn."""
        expect(self.button("Add plot")).to_be_visible()
        self.sees("live.connected && live.frames > 0")
        self.sees("Object.values(live.plots).length > 1")
        self.sees("Object.values(live.plots).every(({ draws }) => draws > 0)")
        return self

    # The state of the page ---------------------------------------------------------------------

    def sees(self, condition: str, given: object = None) -> Any:
        """Wait until an expression of JavaScript holds, of `live`, the state of the page (see
        hub.js), and what is `given`; returns its value."""
        from playwright.sync_api import TimeoutError as Late

        script = f"given => {{ {KNOWN} return live && ({condition}) }}"
        try:
            found = self.page.wait_for_function(script, arg=given, polling=30)
        except Late:
            state = self.page.evaluate("window.rodgenLive")
            raise AssertionError(f"never: {condition}, given {given!r}, but {state}") from None
        return found.json_value()

    def live(self, expression: str) -> Any:
        """What an expression of `live` is now."""
        return self.page.evaluate(f"() => {{ {KNOWN} return {expression} }}")

    def shows(self, key: str, value: float, near: float = DIGITS) -> View:
        """The number of that key in the panel of values is this one, but for a share of it."""
        given = [float(value), max(near * abs(value), 1e-12)]
        self.sees(f"Math.abs(number(live.texts.{key}) - given[0]) <= given[1]", given)
        return self

    def run(self) -> View:
        self.button("Run (").click()
        self.sees("live.state === 'running'")
        return self

    def pause(self) -> View:
        self.button("Pause (").click()
        self.sees("live.state === 'paused'")
        expect(self.button("Run (")).to_be_visible()
        return self

    def pause_after(self, t: float) -> View:
        """Run for so many seconds more of the scene, and hold."""
        since = self.live("live.t")
        self.run().sees("live.t > given", since + t)
        return self.pause()

    # Its parts ---------------------------------------------------------------------------------

    def button(self, name: str) -> Locator:
        """A button by the beginning of its name."""
        return self.page.get_by_role("button", name=re.compile(f"^{re.escape(name)}")).first

    def tab(self, name: str) -> View:
        self.page.get_by_role("tab", name=name).click()
        return self

    def field(self, name: str) -> Locator:
        """The field of this name; the numbers of an expression have fields below it."""
        return self.page.get_by_role("textbox", name=name).first

    def fill(self, name: str, text: str) -> None:
        """Type into a field, and Enter."""
        self.field(name).fill(text)
        self.field(name).press("Enter")

    def refuses(self, name: str) -> None:
        """The field says that it is wrong, and why; no other does."""
        wrong = self.page.locator("[aria-invalid=true]")
        expect(self.field(name).and_(wrong)).to_be_visible()
        expect(wrong).to_have_count(1)
        why = self.page.get_by_role("alert").filter(has_text=re.compile(r"\S"))
        expect(why.filter(visible=True)).to_have_count(1)

    def line(self) -> Locator:
        """The time line."""
        return self.page.get_by_role("slider", name="Time that is shown")

    def select(self, name: str, option: str) -> None:
        """Choose from a list."""
        self.page.get_by_role("combobox", name=name).click()
        self.page.get_by_role("option", name=option, exact=True).click()

    def dialog(self, button: str) -> Locator:
        """The dialog that a button opens."""
        self.button(button).click()
        opened = self.page.get_by_role("dialog")
        expect(opened).to_be_visible()
        return opened

    def add_plot(self, kind: str, **chosen: str) -> str:
        """Add a plot of quantities that are chosen by their names, once it is there; returns its
        id."""
        before = self.live("Object.keys(live.plots)")
        dialog, options = self.dialog("Add plot"), self.page.get_by_role("option")
        dialog.get_by_role("combobox", name="kind of plot").click()
        options.filter(has_text=kind).first.click()
        expect(options).to_have_count(0)
        for label, name in chosen.items():
            dialog.get_by_role("combobox", name=label.replace("_", " "), exact=True).fill(name)
            options.filter(has_text=f"({name})").first.click()
            if label == "quantities":
                self.page.keyboard.press("Escape")
            expect(options).to_have_count(0)
        dialog.get_by_role("button", name="Add", exact=True).click()
        expect(dialog).to_have_count(0)
        new = "Object.keys(live.plots).find(id => !given.includes(id) && live.plots[id].draws)"
        return str(self.sees(new, before))

    def download(self, button: Locator) -> Path:
        """The file that a button gives."""
        with self.page.expect_download() as waiting:
            button.click()
        return Path(waiting.value.path())

    def csv(self, plot: int) -> tuple[list[str], np.ndarray]:
        """Head and rows of the CSV of a plot, by its place."""
        path = self.download(self.page.get_by_role("button", name="CSV").nth(plot))
        head, *rows = csv.reader(io.StringIO(path.read_text(encoding="utf-8")))
        return head, np.array(rows, dtype=float)
