"""A server of the live view and a browser, for the tests that look at its page."""

from __future__ import annotations

import asyncio
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar
from urllib.parse import urlsplit

import pytest

from tests.live.view import PATIENT, View

if TYPE_CHECKING:
    from playwright.sync_api import Browser

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
Loop = Callable[[], asyncio.AbstractEventLoop]


def runs(process: int) -> bool:
    """Whether a process is there, and not only its entry; to be asked where there is /proc."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def finished(work: Coroutine[Any, Any, T], loop: Loop | None = None) -> T:
    """What comes of it, in a thread of its own: a browser may have the loop of this one. loop:
    makes the one that is used, by default asyncio's."""

    def run() -> T:
        with asyncio.Runner(loop_factory=loop) as runner:
            return runner.run(work)

    with ThreadPoolExecutor(1) as thread:
        return thread.submit(run).result()


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
        out, err = self.process.communicate(timeout=PATIENT)
        return self.process.returncode, out + err


# rodgen that gives a page that has gone up after so many seconds.
HASTY = """
from rodgen.cli.app import app
from rodgen.live.page import server
server.RECONNECT = {}
app()
"""


def start(*arguments: str, reconnect: float | None = None) -> Server:
    """`rodgen view` with these arguments, once it has told its address; reconnect: seconds after
    which it gives a page that has gone up, where that is not to be waited for."""
    pytest.importorskip("nicegui", reason="the extra view is not installed")
    rodgen = [Path(sys.executable).with_name("rodgen")]
    if reconnect is not None:
        rodgen = [sys.executable, "-c", HASTY.format(reconnect)]
    process = subprocess.Popen(
        [*rodgen, "view", "--no-open", "--paused", *arguments],
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

    def make(*arguments: str, reconnect: float | None = None) -> Server:
        made.append(start(*arguments, reconnect=reconnect))
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
        # The page is drawn by a browser, and pip installs none.
        pytest.skip(f"no browser is installed (looked for {', '.join(NAMES)})")
    pytest.importorskip("nicegui", reason="the extra view is not installed")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    playwright.expect.set_options(timeout=1000 * PATIENT)
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(
            executable_path=path, args=ARGUMENTS, timeout=1000 * PATIENT
        )
        yield started
        started.close()


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
