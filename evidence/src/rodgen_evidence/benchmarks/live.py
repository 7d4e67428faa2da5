"""The live view in headless Chromium: frames drawn, speed, memory, and how fast the page answers.

    make bench-live [SECONDS=20] [LINKS="50 500"] [AGAINST=CHECKOUT]

A free rod under thrust with four strip charts, of 50 and of 500 links. Frames are counted in the
page (window.rodgenLive); memory is that of the server and of the page's script. AGAINST: another
checkout, which has .venv/bin/rodgen: both run by turns, and ratios are of neighbouring turns.
"""

from __future__ import annotations

import argparse
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, CDPSession, Page, sync_playwright

SCENE = """
name = "links_{links}"
[rod]
links = {links}
length = 5.0
bending_stiffness = 100.0
mass = 50.0
[loads.follower]
force = 300.0
[loads.internal_damping]
coefficient = 0.01
[initial]
phi = "0.1*cos(pi*s)"
"""
LINKS = (50, 500)
CHARTS = (("omega", "omega_3"), ("tip_y", "tip_y"))  # beside the two that a page has at first
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
ARGUMENTS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update"),
)
ANSWER = """async ([name, other]) => {
    const find = n => [...document.querySelectorAll("button")]
        .find(b => b.getAttribute("aria-label")?.startsWith(n));
    const start = performance.now();
    find(name).click();
    while (!find(other)) await new Promise(done => setTimeout(done, 1));
    return performance.now() - start;
}"""


ROUNDS = 4  # by turns


@dataclass
class Turn:
    """Some seconds of a run: frames and simulated seconds per second, and how long the page was
    busy for each frame [ms], which other processes do not change much."""

    frames: float
    pace: float
    busy: float


def live(seconds: float = 20.0, numbers: Sequence[int] = LINKS) -> None:
    """Print a table for each number of links. Exits where no browser is installed."""
    with browsing() as browser:
        for links in numbers:
            with viewed(browser, Path(sys.executable).parent, links) as (page, process):
                watch(page, process, links, seconds)


def compare(other: Path, seconds: float, numbers: Sequence[int] = LINKS) -> None:
    """Print frames, pace and busy time of this checkout and of another one, by turns. Exits where
    no browser is installed."""
    folders = {"this": Path(sys.executable).parent, "other": other / ".venv" / "bin"}
    with browsing() as browser:
        for links in numbers:
            with ExitStack() as stack:
                pages = {
                    name: stack.enter_context(viewed(browser, folder, links))[0]
                    for name, folder in folders.items()
                }
                rounds = [
                    {name: turn(page, seconds) for name, page in pages.items()}
                    for _ in range(ROUNDS)
                ]
            print(f"\nn = {links}, four charts\n       frames/s  of real time  busy a frame")
            for name in pages:
                frames, pace, busy = medians([turns[name] for turns in rounds])
                print(f"{name:5}  {frames:8.1f} {pace:13.3f} {busy:10.2f} ms")
            ratios = [
                Turn(*(getattr(r["this"], k) / getattr(r["other"], k) for k in MEASURES))
                for r in rounds
            ]
            frames, pace, busy = medians(ratios)
            print(f"ratio  {frames:8.2f} {pace:13.2f} {busy:10.2f}", flush=True)


MEASURES = ("frames", "pace", "busy")


def medians(turns: Sequence[Turn]) -> tuple[float, ...]:
    """The median of each measure."""
    return tuple(
        statistics.median(getattr(turn, measure) for turn in turns) for measure in MEASURES
    )


def turn(page: Page, seconds: float) -> Turn:
    """Let a page run for a while, and then rest."""
    page.get_by_role("button", name="Run (").click()
    time.sleep(1.0)
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")
    before, busy, since = shown(page), tasks(session), time.monotonic()
    time.sleep(seconds)
    after, took = shown(page), time.monotonic() - since
    spent = tasks(session) - busy
    session.detach()
    page.get_by_role("button", name="Pause (").click()
    frames = after["frames"] - before["frames"]
    return Turn(frames / took, (after["t"] - before["t"]) / took, 1000 * spent / max(frames, 1))


def tasks(session: CDPSession) -> float:
    """Seconds for which a page has been busy."""
    found = session.send("Performance.getMetrics")["metrics"]
    return float(next(row["value"] for row in found if row["name"] == "TaskDuration"))


@contextmanager
def browsing() -> Iterator[Browser]:
    """A browser without a window. Exits where none is installed."""
    path = next(filter(None, map(shutil.which, BROWSERS)), None)
    if path is None:
        sys.exit(f"no browser is installed (looked for {', '.join(BROWSERS)})")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield browser
        browser.close()


@contextmanager
def viewed(browser: Browser, folder: Path, links: int) -> Iterator[tuple[Page, int]]:
    """A page with four charts of the rodgen of a folder, and the process that serves it."""
    with tempfile.TemporaryDirectory() as place:
        path = Path(place, f"links_{links}.toml")
        path.write_text(SCENE.format(links=links))
        view = [str(folder / "rodgen"), "view"]
        told = subprocess.run([*view, "--help"], capture_output=True, text=True, check=True).stdout
        held = ["--paused"] * ("--paused" in told)  # an older checkout begins so
        command = [*view, str(path), "--port=0", "--no-open", *held]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            try:
                assert server.stdout is not None
                found = re.search(r"http://\S+", server.stdout.readline())
                assert found is not None
                page = browser.new_page(viewport={"width": 1280, "height": 1100})
                page.set_default_timeout(600_000)  # ms: it may be busy with more than this
                page.goto(found[0])
                for kind, name in CHARTS:
                    add(page, kind, name)
                yield page, server.pid
                page.close()
            finally:
                server.terminate()


def add(page: Page, kind: str, name: str) -> None:
    """Add a plot of a quantity over time: of its kind, or by its own name where that is offered."""
    page.get_by_role("button", name="Add plot").click()
    dialog = page.get_by_role("dialog")
    field = dialog.get_by_role("combobox", name="quantities")
    options = page.get_by_role("option")
    field.fill(kind)
    options.filter(has_text=re.compile(rf"\(({kind}|{name})\)")).first.click()
    page.keyboard.press("Escape")
    dialog.get_by_role("button", name="Add").click()
    dialog.wait_for(state="detached")


def watch(page: Page, process: int, links: int, seconds: float) -> None:
    """A line every few seconds, then how long a click takes."""
    page.get_by_role("button", name="Run (").click()
    time.sleep(2.0)
    print(f"\nn = {links}, four charts\n  time  frames/s  of real time  server  page")
    start = time.monotonic()
    while time.monotonic() - start < seconds:
        before, since = shown(page), time.monotonic()
        time.sleep(max(5.0, seconds / 12))
        after, took = shown(page), time.monotonic() - since
        heap = page.evaluate("performance.memory.usedJSHeapSize") / 1e6
        print(
            f"{time.monotonic() - start:5.0f}s {(after['frames'] - before['frames']) / took:9.1f} "
            f"{(after['t'] - before['t']) / took:13.3f} {resident(process):4.0f} MB {heap:4.0f} MB",
            flush=True,
        )
    pairs = [("Pause (", "Run ("), ("Run (", "Pause (")] * 5
    answers = [page.evaluate(ANSWER, list(pair)) for pair in pairs]
    print(
        f"a click is answered in {statistics.median(answers):.0f} ms (at most {max(answers):.0f})"
    )


def shown(page: Page) -> dict[str, Any]:
    """What the page has drawn."""
    found: dict[str, Any] = page.evaluate("({...window.rodgenLive})")
    return found


def resident(process: int) -> float:
    """Memory of a process [MB]; nan where the system does not tell."""
    try:
        text = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return float("nan")
    return int(text.split("VmRSS:")[1].split()[0]) / 1024


if __name__ == "__main__":
    asked = argparse.ArgumentParser()
    asked.add_argument("seconds", type=float, nargs="?", default=20.0)
    asked.add_argument("links", type=int, nargs="*", default=LINKS)
    asked.add_argument("--against", type=Path)
    given = asked.parse_args()
    if given.against:
        compare(given.against, given.seconds, given.links)
    else:
        live(given.seconds, given.links)
