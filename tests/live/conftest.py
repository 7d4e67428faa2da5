"""A server of the live view and a browser, for the tests that look at its page."""

from __future__ import annotations

import asyncio
import csv
import io
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar
from urllib.parse import urlsplit

import numpy as np
import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Page

SCENES = Path(__file__).parents[2] / "scenes"
# The rod of most tests, of a structure that others compile too (tests/palette.py).
ROD: dict[str, Any] = {
    "name": "dart",
    "rod": {"links": 5, "length": 2.0, "bending_stiffness": 5.0, "mass": 3.0},
    "loads": {
        "follower": {"force": 2.0},
        "gravity": {"g": 9.81},
        "internal_damping": {"coefficient": 0.0},
        "external_damping": {"coefficient": 0.0},
    },
    "initial": {"phi": "0.2*cos(pi*s)"},
    "integrate": {"span": [0.0, 5.0], "output_every": 0.01, "method": "dop853"},
}


def varied(**rod: Any) -> dict[str, Any]:
    """The rod with other keys of [rod]."""
    return {**ROD, "rod": {**ROD["rod"], **rod}}


NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
# Nothing that Chromium does on its own account, such as asking for updates.
ARGUMENTS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update"),
)
WIDE = {"width": 1280, "height": 800}
T = TypeVar("T")
PATIENT = 180_000  # ms that a busy machine may take, for a compilation too


def finished(work: Coroutine[Any, Any, T]) -> T:
    """What comes of it, in a thread of its own: a browser may have the loop of this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, work).result()


class Clock:
    """Seconds, moved by hand."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def scene_file(tmp_path: Path) -> Callable[..., Path]:
    """Writes a scene, a rod of 1 m and 2 kg without loads; tables: text of others."""

    def write(
        name: str = "rod", tables: str = "", *, called: str | None = None, **rod: object
    ) -> Path:
        values = {"links": 4, "length": 1.0, "bending_stiffness": 10.0, "mass": 2.0} | rod
        lines = (f"{key} = {value!r}" for key, value in values.items())
        path = tmp_path / f"{name}.toml"
        text = "\n".join([f'name = "{called or name}"', "[rod]", *lines, tables])
        path.write_text(text, encoding="utf-8")
        return path

    return write


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
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The rod, two of another mass that have one name, and a scene that is none."""
    tomli_w = pytest.importorskip("tomli_w", reason="the extra view is not installed")
    path = tmp_path_factory.mktemp("scenes")
    scenes = {"dart": ROD} | {
        name: {**varied(mass=mass), "name": "rod"} for name, mass in (("one", 2.0), ("two", 4.0))
    }
    for name, scene in scenes.items():
        (path / f"{name}.toml").write_text(tomli_w.dumps(scene))
    (path / "bad.toml").write_text("name = 3")
    return path


@pytest.fixture(scope="session")
def server(folder: Path) -> Iterator[Server]:
    """The rod, on a port that was free."""
    served = start(str(folder / "dart.toml"), "--port", "0")
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

    def pause_after(self, t: float) -> View:
        """Run for so many seconds more of the scene, and hold."""
        wanted = self.live("t") + t
        self.run()
        self.until(lambda: self.live("t") > wanted, "time does not pass")
        return self.pause()

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
        options.filter(has_text=kind).click()
        for label, names in chosen.items():
            field = dialog.get_by_role("combobox", name=label.replace("_", " "), exact=True)
            for name in names.split():
                field.fill(name)
                options.filter(has_text=f"({name})").first.click()
            if label == "quantities":
                self.page.keyboard.press("Escape")
            self.until(lambda: options.count() == 0, "the names stay")
        return dialog

    def add_plot(self, kind: str, **chosen: str) -> None:
        dialog = self.plot_dialog(kind, **chosen)
        dialog.get_by_role("button", name="Add").click()
        dialog.wait_for(state="hidden")

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

    def until(
        self, true: Callable[[], bool], otherwise: str, seconds: float = PATIENT / 1000
    ) -> None:
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
    asked = [url for view in made for url in view.asked if not url.startswith(("blob:", "data:"))]
    assert {urlsplit(url).hostname for url in asked} <= {"localhost", "127.0.0.1"}  # no other's


@pytest.fixture
def blank(another: Callable[[], View]) -> View:
    """A page that is not opened yet."""
    return another()


@pytest.fixture
def view(server: Server, blank: View) -> View:
    """The page of the server."""
    return blank.open(server.address)
