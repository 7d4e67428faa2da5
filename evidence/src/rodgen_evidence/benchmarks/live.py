"""The live view in headless Chromium: frames drawn, speed, memory, and how fast the page answers.

    make bench NAME=live [ARGS="20 50 500 --against CHECKOUT"]

A free rod under thrust with four strip charts, of 50 and of 500 links. Frames are counted in the
page (window.rodgenLive); memory is that of the server and of the page's script. In the end, 20 000
samples are dragged through on the time line. AGAINST: another checkout, which has .venv/bin/rodgen:
both run by turns, and ratios are of neighbouring turns. The effect of a slider has come when a
frame is drawn with the thrust to which a step of the slider has set it, ten times a second.
"""

from __future__ import annotations

import argparse
import itertools
import os
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
[integrate]
span = [0.0, 1000.0]
output_every = {every}
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
# Milliseconds from each step of the slider of the thrust to the frame that shows it.
EFFECTS = """async ([steps, key]) => {
    const { hub } = await import("rodgen-live/hub.js");
    const wait = ms => new Promise(done => setTimeout(done, ms));
    const slider = document.querySelector(".q-slider[aria-label='follower force P']");
    const track = slider.querySelector("[tabindex]");
    const place = () => Number(track.closest("[aria-valuenow]").ariaValueNow);
    const force = () => Math.hypot(...hub.rod.forces.follower);
    const settled = async () => {
        for (let last = 0, same = 0; same < 10; last = force()) {
            await wait(100);
            same = Math.abs(force() - last) < 1e-6 * last ? same + 1 : 0;
        }
        return [place(), force()];
    };
    const [moved, drawn] = [[], []];
    const [from, least] = await settled();
    const note = () => drawn.push([performance.now(), force()]);
    const painter = { paint: (now, fresh) => fresh && note() && false };
    hub.painters.add(painter);
    for (let step = 0; step < steps; step++) {
        const at = performance.now();
        const of = { keyCode: key, ctrlKey: true, bubbles: true };
        for (const kind of ["keydown", "keyup"]) track.dispatchEvent(new KeyboardEvent(kind, of));
        await wait(0);
        moved.push([at, place()]);
        await wait(100);
    }
    const [to, most] = await settled();
    hub.painters.delete(painter);
    const near = 0.5 / steps;
    const shows = (value, force) =>
        (force - least) / (most - least) > (value - from) / (to - from) - near;
    return moved.map(([at, value]) => drawn.find(([, force]) => shows(value, force))[0] - at);
}"""
RIGHT, LEFT = 39, 37  # keys
STEPS = 30  # of the slider
# Times at which frames were drawn.
DRAWN = """async () => {
    const { hub } = await import("rodgen-live/hub.js");
    window.drawn = [];
    hub.painters.add({ paint: (now, fresh) => fresh && drawn.push(performance.now()) && false });
}"""
SAMPLES = 20_000

ROUNDS = 4  # by turns


@dataclass
class Turn:
    """Some seconds of a run: frames and simulated seconds per second, how long the page was busy
    for each frame and how long its scripts took of that, which other processes do not change much,
    and how long the effect of a slider took [ms]."""

    frames: float
    pace: float
    busy: float
    scripts: float
    effect: float


def live(seconds: float = 20.0, numbers: Sequence[int] = LINKS, samples: int = SAMPLES) -> None:
    """Print a table for each number of links, and what a drag along so many samples takes. Exits
    where no browser is installed."""
    with browsing() as browser:
        for links in numbers:
            with open_view(browser, Path(sys.executable).parent, links) as (page, process):
                watch(page, process, links, seconds)
        with open_view(browser, Path(sys.executable).parent, numbers[0], every=0.001) as (
            page,
            process,
        ):
            scrub(page, process, numbers[0], samples)


def compare(other: Path, seconds: float, numbers: Sequence[int] = LINKS) -> None:
    """Print frames, pace and busy time of this checkout and of another one, by turns. Exits where
    no browser is installed."""
    folders = {"this": Path(sys.executable).parent, "other": other / ".venv" / "bin"}
    with browsing() as browser:
        for links in numbers:
            with ExitStack() as stack:
                pages = {
                    name: stack.enter_context(open_view(browser, folder, links))[0]
                    for name, folder in folders.items()
                }
                rounds = [
                    {name: turn(page, seconds) for name, page in pages.items()}
                    for _ in range(ROUNDS)
                ]
            print(f"\nn = {links}, four charts")
            print(
                "       frames/s  of real time  busy a frame  scripts of that  effect of a slider"
            )
            for name in pages:
                found = medians([turns[name] for turns in rounds])
                print(
                    "{:5} {:9.1f} {:13.3f} {:10.2f} ms {:8.2f} ms {:16.0f} ms".format(name, *found)
                )
            ratios = [
                Turn(*(getattr(r["this"], k) / getattr(r["other"], k) for k in MEASURES))
                for r in rounds
            ]
            print(
                "ratio {:9.2f} {:13.2f} {:10.2f} {:11.2f} {:19.2f}".format(*medians(ratios)),
                flush=True,
            )


MEASURES = ("frames", "pace", "busy", "scripts", "effect")


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
    before, since = read_charts(page), time.monotonic()
    busy, scripts = (-spent(session, name) for name in SPENT)
    time.sleep(seconds)
    after, took = read_charts(page), time.monotonic() - since
    busy, scripts = busy + spent(session, SPENT[0]), scripts + spent(session, SPENT[1])
    session.detach()
    effects = [took for key in (RIGHT, LEFT) for took in page.evaluate(EFFECTS, [STEPS, key])]
    page.get_by_role("button", name="Pause (").click()
    frames = after["frames"] - before["frames"]
    pace, each = (after["t"] - before["t"]) / took, 1000 / max(frames, 1)
    return Turn(frames / took, pace, busy * each, scripts * each, statistics.median(effects))


SPENT = ("TaskDuration", "ScriptDuration")


def spent(session: CDPSession, name: str) -> float:
    """Seconds that a page has spent so far, of one of SPENT."""
    found = session.send("Performance.getMetrics")["metrics"]
    return float(next(row["value"] for row in found if row["name"] == name))


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
def open_view(
    browser: Browser, folder: Path, links: int, every: float = 0.01
) -> Iterator[tuple[Page, int]]:
    """Yield a page with four charts of the rodgen of a folder, and the process that serves it.

    every: seconds between two samples.
    """
    with tempfile.TemporaryDirectory() as place:
        path = Path(place, f"links_{links}.toml")
        path.write_text(SCENE.format(links=links, every=every))
        with serving(path, "--paused", folder=folder) as (address, process):
            page = browser.new_page(viewport={"width": 1280, "height": 1100})
            page.set_default_timeout(600_000)  # ms: it may be busy with more than this
            page.goto(address)
            page.get_by_role("tab", name="Parameters").click()
            for kind, name in CHARTS:
                add(page, kind, name)
            yield page, process
            page.close()


@contextmanager
def serving(
    scene: Path, *options: str, folder: Path = Path(sys.executable).parent
) -> Iterator[tuple[str, int]]:
    """Address and process of a live view of a scene, of the rodgen of a folder."""
    command = [str(folder / "rodgen"), "view", str(scene), "--port=0", "--no-open", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            found = re.search(r"http://\S+", server.stdout.readline())
            assert found is not None
            yield found[0], server.pid
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
        before, since = read_charts(page), time.monotonic()
        time.sleep(max(5.0, seconds / 12))
        after, took = read_charts(page), time.monotonic() - since
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


def scrub(page: Page, process: int, links: int, samples: int) -> None:
    """Drag along the time line of so many samples, there and back, and print how far apart frames
    are."""
    page.get_by_role("button", name="Run (").click()
    page.wait_for_function(f"Object.values(rodgenLive.plots)[0].rows >= {samples}")
    page.get_by_role("button", name="Pause (").click()
    page.evaluate(DRAWN)
    box = page.get_by_role("slider", name="Time that is shown").bounding_box()
    assert box is not None
    y, left, wide = box["y"] + box["height"] / 2, box["x"] + 12, box["width"] - 24
    page.mouse.move(left + wide, y)
    page.mouse.down()
    before = processor(page, process)
    for share in (0.0, 1.0) * 2:
        page.mouse.move(left + share * wide, y, steps=200)
    page.mouse.up()
    times = page.evaluate("drawn")
    apart = sorted(after - before for before, after in itertools.pairwise(times))
    most, spent = (
        apart[9 * len(apart) // 10],
        1000 * (processor(page, process) - before) / len(times),
    )
    print(
        f"\nn = {links}, {samples} samples, dragged through\n"
        f"a frame each {statistics.median(apart):.0f} ms, "
        f"nine of ten within {most:.0f} ms; server and page compute for {spent:.1f} ms a frame"
    )


def processor(page: Page, process: int) -> float:
    """Processor time of a server and of the pages of a browser [s]; nan where the system does not
    tell."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return float("nan")
    browser = page.context.browser
    assert browser is not None
    session = browser.new_browser_cdp_session()
    found = session.send("SystemInfo.getProcessInfo")["processInfo"]
    session.detach()
    pages = sum(row["cpuTime"] for row in found if row["type"] == "renderer")
    return float(pages) + sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")


def read_charts(page: Page) -> dict[str, Any]:
    """Read how much the page has drawn."""
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
