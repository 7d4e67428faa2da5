"""The live view in headless Chromium: frames drawn, speed, memory, and how fast the page answers.

    make bench-live [SECONDS=20] [LINKS="50 500"]

A free rod under thrust with four strip charts, of 50 and of 500 links. Frames are counted in the
page (window.rodgenLive); memory is that of the server and of the page's script.
"""

from __future__ import annotations

import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright

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
CHARTS = ("omega_3", "tip_y")  # beside the two that a page has at first
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


def live(seconds: float = 20.0, numbers: Sequence[int] = LINKS) -> None:
    """Print a table for each number of links. Exits where no browser is installed."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        sys.exit(f"no browser is installed (looked for {', '.join(BROWSERS)})")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=browser, args=ARGUMENTS)
        for links in numbers:
            path = Path(folder, f"links_{links}.toml")
            path.write_text(SCENE.format(links=links))
            rodgen = str(Path(sys.executable).with_name("rodgen"))
            command = [rodgen, "view", str(path), "--port=0", "--no-open"]
            with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
                try:
                    assert server.stdout is not None
                    found = re.search(r"http://\S+", server.stdout.readline())
                    assert found is not None
                    page = started.new_page(viewport={"width": 1280, "height": 1100})
                    watch(page, found[0], server.pid, links, seconds)
                    page.close()
                finally:
                    server.terminate()


def watch(page: Page, address: str, process: int, links: int, seconds: float) -> None:
    """Four charts, then a line every few seconds, then how long a click takes."""
    page.set_default_timeout(600_000)  # ms: it may be busy with more than this
    page.goto(address)
    for name in CHARTS:
        page.get_by_role("button", name="Add plot").click()
        dialog = page.get_by_role("dialog")
        dialog.get_by_role("combobox", name="quantities").fill(name)
        page.get_by_role("option").filter(has_text=name).first.click()
        page.keyboard.press("Escape")
        dialog.get_by_role("button", name="Add").click()
        dialog.wait_for(state="detached")
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
    _, wanted, *counts = [*sys.argv, "20"][: max(2, len(sys.argv))]
    live(float(wanted), [int(text) for text in counts] or LINKS)
