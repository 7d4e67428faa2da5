"""A server of the live view and a browser, for the tests that look at its page."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Page

SCENES = Path(__file__).parents[2] / "scenes"
NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
# Nothing that Chromium does on its own account, such as asking for updates.
ARGUMENTS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update"),
)
WIDE = {"width": 1280, "height": 800}
PATIENT = 60_000  # ms that a busy machine may take


@dataclass
class Server:
    """A process that serves, and its address."""

    process: subprocess.Popen[str]
    address: str

    def end(self) -> tuple[int, str]:
        """By Ctrl-C; its exit status and what it wrote."""
        self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=20)
        return self.process.returncode, out + err


def start(*arguments: str) -> Server:
    """`rodgen view` with these arguments, once it has told its address."""
    pytest.importorskip("nicegui", reason="the extra view is not installed")
    process = subprocess.Popen(
        [Path(sys.executable).with_name("rodgen"), "view", *arguments, "--no-open"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    line = process.stdout.readline()
    found = re.search(r"http://\S+", line)
    if not found:
        process.kill()
        raise RuntimeError(f"no address: {line}{process.communicate()}")
    return Server(process, found[0])


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    """The missile, on a port that was free."""
    served = start(str(SCENES / "missile.toml"), "--port", "0")
    yield served
    code, text = served.end()
    assert code == 0, text
    assert "Traceback" not in text, text


@pytest.fixture
def serve() -> Iterator[Callable[..., Server]]:
    """Starts servers with arguments of one's own."""
    made: list[Server] = []

    def make(*arguments: str) -> Server:
        made.append(start(*arguments))
        return made[-1]

    yield make
    for served in made:
        code, text = served.end()
        assert (code, "Traceback" in text) == (0, False), text


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Headless Chromium."""
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip(f"no browser is installed (looked for {', '.join(NAMES)})")
    pytest.importorskip("nicegui", reason="the extra view is not installed")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield started
        started.close()


class View:
    """A page of the live view, with what went wrong in it."""

    def __init__(self, page: Page):
        self.page = page
        self.errors: list[str] = []
        self.asked: list[str] = []
        page.set_default_timeout(PATIENT)
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))

    def open(self, address: str) -> View:
        self.page.goto(address)
        return self.ready()

    def ready(self) -> View:
        """The page is built and has drawn something."""
        self.button("Run (").or_(self.button("Pause (")).first.wait_for()
        self.until(lambda: self.live("frames") >= 1, "nothing is drawn")
        return self

    def live(self, key: str) -> float:
        """A number of window.rodgenLive: t, frames, fps."""
        return float(self.page.evaluate(f"window.rodgenLive?.{key} ?? -1"))

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
        return self.page.get_by_role("textbox", name=name)

    def fill(self, name: str, text: str) -> None:
        """Type into a field, and Enter."""
        self.field(name).fill(text)
        self.field(name).press("Enter")

    def run(self) -> View:
        self.button("Run (").click()
        self.button("Pause (").wait_for()
        return self

    def pause(self) -> View:
        self.button("Pause (").click()
        self.button("Run (").wait_for()
        return self

    def until(self, true: Callable[[], bool], otherwise: str, seconds: float = 60.0) -> None:
        """Wait for something; fail with `otherwise`."""
        end = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < end, otherwise
            self.page.wait_for_timeout(50)


@pytest.fixture
def another(browser: Browser) -> Iterator[Callable[[], View]]:
    """Makes pages that are not opened yet, each in a context of its own."""
    made: list[View] = []

    def make() -> View:
        context = browser.new_context(viewport=WIDE, accept_downloads=True)
        made.append(View(context.new_page()))
        return made[-1]

    yield make
    for view in made:
        view.page.context.close()
    assert [error for view in made for error in view.errors] == []


@pytest.fixture
def blank(another: Callable[[], View]) -> View:
    """A page that is not opened yet."""
    return another()


@pytest.fixture
def view(server: Server, blank: View) -> View:
    """The page of the server."""
    return blank.open(server.address)
