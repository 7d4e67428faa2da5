"""A rod, a server of the live view and a browser, for the tests of its page."""

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
from typing import TYPE_CHECKING, Any
from unittest.mock import Mock
from urllib.parse import urlsplit

import pytest

from live.tests.runs import prepared
from live.tests.view import PATIENT, View
from rodgen.emit.targets import STEPS, required_parts
from rodgen.loading import build_fastest
from rodgen.scene import Scene, Structure
from rodgen_live.pull import with_idle_support
from rodgen_live.run import critical_search
from rodgen_live.run.live_run import LiveRun
from rodgen_live.run.worker_process import WorkerProcess
from tests.palette import ROD

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext

SCENES = Path(__file__).parents[2] / "scenes"
SCENE = Scene.from_dict(ROD)


def varied(**rod: Any) -> dict[str, Any]:
    """The rod with other keys of [rod]."""
    return {**ROD, "rod": {**ROD["rod"], **rod}}


# Another, of a structure that others compile too.
SHORT = {
    **varied(links=3, boundary="clamped", clamp_angle=0.0),
    "loads": {**ROD["loads"], "tip": {"x": 0.0, "y": 0.0}},
}

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
# Nothing that Chromium does on its own account, such as asking for updates.
ARGUMENTS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update"),
)
WIDE = {"width": 1280, "height": 800}
PHONE = {"width": 390, "height": 844}


def runs(process: int) -> bool:
    """Whether a process is there, and not only its entry; to be asked where there is /proc."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def finished(work: Coroutine[Any, Any, Any]) -> Any:
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


@pytest.fixture(autouse=True)
def _nobody_aside(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs have no critical force computed beside them, but where a test is of that."""
    monkeypatch.setattr(critical_search, "ASIDE", Mock(spec=WorkerProcess))


@pytest.fixture
def run() -> Iterator[LiveRun]:
    """A run of the rod, paused at its start."""
    made = LiveRun(SCENE)
    yield made
    made.close()


@pytest.fixture
def other() -> Iterator[LiveRun]:
    """Another run of it."""
    made = LiveRun(SCENE)
    yield made
    made.close()


@pytest.fixture
def bar(make_scene: Callable[..., Scene]) -> Any:
    """One link of 2 m that turns about a pin: y = [phi, omega]. Its quantities, and what makes
    chunks of it."""
    return prepared(make_scene(1, "pinned"))


# Servers ---------------------------------------------------------------------------------------


@dataclass
class Server:
    """A process that serves, and its address."""

    process: subprocess.Popen[str]
    address: str

    def end(self) -> None:
        """By Ctrl-C, after which all is well."""
        self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=PATIENT)
        assert (self.process.returncode, "Traceback" in out + err) == (0, False), out + err


def start(*arguments: object) -> Server:
    """`rodgen view` with these arguments on a port that was free, once it has told its address."""
    options = ("--port", "0", "--no-open", "--paused")
    process = subprocess.Popen(
        [sys.executable, "-m", "rodgen", "view", *options, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    found = re.search(r"http://\S+", line := process.stdout.readline())
    if not found:
        process.kill()
        raise RuntimeError(f"no address: {line}{process.communicate()}")
    return Server(process, found[0])


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The rod, two of another mass that have one name, and a scene that is none."""
    path = tmp_path_factory.mktemp("scenes")
    (path / "dart.toml").write_text(SCENE.to_toml())
    for name, mass in (("one", 2.0), ("two", 4.0)):
        scene = Scene.from_dict({**varied(mass=mass), "name": "rod"})
        (path / f"{name}.toml").write_text(scene.to_toml())
    (path / "bad.toml").write_text("name = 3")
    return path


def make(structure: Structure) -> None:
    """Have a module in the cache, as a page has it made: on a busy machine that may take longer
    than anything is waited for."""
    build_fastest(structure, (*required_parts("c"), *STEPS))


@pytest.fixture(scope="session")
def server(folder: Path) -> Iterator[Server]:
    """The rod, for all tests of a worker; each has a run of its own."""
    for structure in (SCENE.structure, with_idle_support(SCENE).structure):
        make(structure)
    served = start(folder / "dart.toml")
    yield served
    served.end()


@pytest.fixture
def serve() -> Iterator[Callable[..., Server]]:
    """Starts servers with arguments of one's own."""
    made: list[Server] = []

    def make(*arguments: object) -> Server:
        made.append(start(*arguments))
        return made[-1]

    yield make
    for served in made:
        if served.process.poll() is None:
            served.end()


# The browser -----------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Headless Chromium."""
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        # The page is drawn by a browser, and pip installs none.
        pytest.skip(f"no browser is installed (looked for {', '.join(NAMES)})")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    playwright.expect.set_options(timeout=1000 * PATIENT)
    with playwright.sync_playwright() as driver:
        yield driver.chromium.launch(executable_path=path, args=ARGUMENTS)


@pytest.fixture(scope="session")
def context(browser: Browser) -> BrowserContext:
    """Shared by the pages of a worker, which so load and compile the page's scripts once."""
    return browser.new_context(viewport=WIDE, accept_downloads=True, reduced_motion="reduce")


@pytest.fixture
def another(browser: Browser, context: BrowserContext) -> Iterator[Callable[..., View]]:
    """Makes pages that are not opened yet; apart: with cookies of its own."""
    made: list[View] = []

    def make(apart: bool = False) -> View:
        shared = browser.new_context(viewport=WIDE) if apart else context
        made.append(View(shared.new_page()))
        return made[-1]

    yield make
    for view in made:
        view.page.close()
        if view.page.context is not context:
            view.page.context.close()
    assert [error for view in made for error in view.errors] == []
    asked = [url for view in made for url in view.asked if url.startswith(("http:", "https:"))]
    assert {urlsplit(url).hostname for url in asked} <= {"localhost", "127.0.0.1"}  # no other's


@pytest.fixture
def blank(another: Callable[[], View]) -> View:
    """A page that is not opened yet."""
    return another()


@pytest.fixture
def view(server: Server, blank: View) -> View:
    """The page of the server."""
    return blank.open(server.address)
