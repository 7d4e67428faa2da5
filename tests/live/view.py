"""A page of the live view in a browser, and one way to wait for what it does."""

from __future__ import annotations

import csv
import io
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from rodgen.live.catalogue import KINDS

if TYPE_CHECKING:
    from playwright.sync_api import Locator, LocatorAssertions, Page

T = TypeVar("T")
NUMBERED = re.compile(r"_(\d+)")  # in the name of a quantity along the rod
PATIENT = 600.0  # seconds that a busy machine may take, for a module to be made too
# What a page sends on its own connection, in window.sent by the names of events, and the texts of
# all notes that it shows, in window.notes; both from its first moment on.
WATCHED = """
    window.sent = [];
    window.notes = [];
    let socket;
    Object.defineProperty(window, "socket", {
        get: () => socket,
        set(given) {
            socket = given;
            const emit = given.emit;
            given.emit = function (name, message, ...rest) {
                const of = name === "event" && mounted_app.elements[message.id];
                const listens = (of?.events ?? []).find(e => e.listener_id === message.listener_id);
                if (listens) sent.push(listens.type);
                return emit.call(this, name, message, ...rest);
            };
        },
    });
    new MutationObserver(changes => {
        for (const { addedNodes } of changes) for (const node of addedNodes) {
            const found = node.matches?.(".q-notification") ? [node]
                : node.querySelectorAll?.(".q-notification") ?? [];
            notes.push(...[...found].map(note => note.textContent).filter(text => text));
        }
    }).observe(document, { childList: true, subtree: true });
"""
# A question about no element of the page: the server answers it after all that came before.
ASK = """new Promise(answered =>
    socket.emit("event", { client_id: clientId, id: -1, listener_id: "", args: [] }, answered))"""


def until(
    look: Callable[[], T],
    wanted: T | Callable[[T], bool],
    what: str,
    rest: Callable[[float], object] = time.sleep,
) -> T:
    """What is seen, once it is as wanted: equal to that, or such that it says so. If it never is,
    fail with `what`, and with what was seen last."""
    end = time.monotonic() + PATIENT
    while True:
        seen = look()
        if wanted(seen) if callable(wanted) else seen == wanted:
            return seen
        assert time.monotonic() < end, f"{what}: {seen!r}"
        rest(0.03)


def expect(locator: Locator) -> LocatorAssertions:
    """Playwright's assertions, which wait for what they assert."""
    from playwright import sync_api

    return sync_api.expect(locator)


class View:
    """A page of the live view, with what went wrong in it."""

    def __init__(self, page: Page):
        self.page = page
        self.errors: list[str] = []
        self.asked: list[str] = []
        page.set_default_timeout(1000 * PATIENT)
        page.add_init_script(WATCHED)
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))

    def open(self, address: str) -> View:
        self.page.goto(address)
        return self.ready()

    def reload(self) -> View:
        """Load the page again, after all that was done on it has reached the server."""
        self.answered()
        self.page.reload()
        return self.ready()

    def ready(self) -> View:
        """The page is built, its parts stand where they will stay, and the rod and the plots are
        drawn."""
        expect(self.button("Run (").or_(self.button("Pause ("))).to_be_visible()
        self.page.evaluate("document.fonts.ready.then(() => null)")
        self.until(lambda: self.live("frames"), lambda count: count >= 1, "nothing is drawn")
        draws = "Object.values(rodgenLive.plots ?? {}).map(({ draws }) => draws)"
        self.sees(draws, lambda found: len(found) > 1 and min(found) > 0, "plots are not drawn")
        return self

    def until(self, look: Callable[[], T], wanted: T | Callable[[T], bool], what: str) -> T:
        """Wait for something, while the browser goes on (see `until` above)."""
        return until(look, wanted, what, lambda pause: self.page.wait_for_timeout(1000 * pause))

    def sees(self, script: str, wanted: Any, what: str) -> Any:
        """Wait until a piece of JavaScript gives what is wanted."""
        return self.until(lambda: self.page.evaluate(script), wanted, what)

    def answered(self) -> View:
        """The server has got all that the page has sent up to now."""
        self.page.evaluate(ASK)
        return self

    def sent(self) -> list[str]:
        """Events that the page has sent since the last question, by their names."""
        found: list[str] = self.page.evaluate("sent.splice(0)")
        return found

    def notes(self) -> list[str]:
        """All notes that the page has shown, gone or not."""
        found: list[str] = self.page.evaluate("notes")
        return found

    def noted(self, text: str, count: int = 1) -> View:
        """So many notes with a text in them are or were shown."""
        self.until(
            self.notes,
            lambda notes: sum(text in note for note in notes) == count,
            f"not noted {count} times: {text}",
        )
        return self

    def close_notes(self) -> None:
        """By their buttons, those that have not gone by themselves."""
        self.page.evaluate(
            "document.querySelectorAll('.q-notification button').forEach(b => b.click())"
        )
        expect(self.page.locator(".q-notification")).to_have_count(0)

    def live(self, key: str) -> float:
        """A number of window.rodgenLive: t, frames, fps."""
        return float(self.page.evaluate(f"window.rodgenLive?.{key} ?? -1"))

    def state(self, state: str) -> View:
        """The run is in that state, and so is what is drawn."""
        self.sees("window.rodgenLive?.state", state, f"not {state}")
        return self

    def text(self, key: str) -> str:
        """What stands in a row of the panel of values, once something does."""
        self.page.wait_for_function(
            "key => [...document.querySelectorAll(`[data-text=${key}]`)].at(-1)?.textContent",
            arg=key,
        )
        found = self.page.locator(f'[data-text="{key}"]').last.text_content() or ""
        return found.replace("\u2007", "").replace("\u2212", "-").strip()

    def button(self, name: str) -> Locator:
        """A button by the beginning of its name."""
        return self.page.get_by_role("button", name=re.compile(f"^{re.escape(name)}"))

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

    def run(self) -> View:
        self.button("Run (").click()
        expect(self.button("Pause (")).to_be_visible()
        return self.state("running")

    def pause(self) -> View:
        self.button("Pause (").click()
        expect(self.button("Run (")).to_be_visible()
        return self.state("paused")

    def passes(self, t: float) -> View:
        """So many seconds more of the scene pass."""
        since = self.live("t")
        self.until(lambda: self.live("t") - since, lambda past: past > t, "time does not pass")
        return self

    def pause_after(self, t: float) -> View:
        """Run for so many seconds more of the scene, and hold."""
        return self.run().passes(t).pause()

    def dark(self) -> bool:
        """Whether the page is dark."""
        return bool(self.page.evaluate("document.body.classList.contains('body--dark')"))

    def select(self, name: str, option: str) -> None:
        """Choose from a list."""
        self.page.get_by_role("combobox", name=name).click()
        self.page.get_by_role("option", name=option, exact=True).click()

    def plot_dialog(self, kind: str, **chosen: str) -> Locator:
        """The dialog for a kind of plot, with quantities chosen by their names."""
        self.button("Add plot").click()
        dialog = self.page.get_by_role("dialog")
        dialog.get_by_role("combobox", name="kind of plot").click()
        options = self.page.get_by_role("option")
        options.filter(has_text=kind).first.click()
        for label, names in chosen.items():
            field = dialog.get_by_role("combobox", name=label.replace("_", " "), exact=True)
            numbers: dict[str, list[str]] = {}
            for name in names.split():
                along = None if name.startswith("principal") else NUMBERED.search(name)
                kind = NUMBERED.sub("", name) if along else name
                if kind not in numbers:
                    field.fill(kind)
                    options.filter(has_text=f"({kind})").first.click()
                numbers.setdefault(kind, []).extend([along[1]] if along else [])
            if label == "quantities":
                self.page.keyboard.press("Escape")
            expect(options).to_have_count(0)
            for kind, some in numbers.items():
                if some:
                    self._which(dialog, kind).fill(", ".join(some))
        return dialog

    def _which(self, dialog: Locator, kind: str) -> Locator:
        """The last field that asks which of a kind."""
        return dialog.get_by_role("textbox", name=f"which {KINDS[kind].title}").last

    def add_plot(self, kind: str, **chosen: str) -> None:
        dialog = self.plot_dialog(kind, **chosen)
        dialog.get_by_role("button", name="Add").click()
        expect(dialog).to_have_count(0)

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
