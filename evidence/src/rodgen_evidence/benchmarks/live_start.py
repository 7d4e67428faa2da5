"""How soon the live view shows a rod, and the memory that its tabs leave behind.

    make bench NAME=live_start [ARGS="--rounds 6 --tabs 100"]

Each round starts `rodgen view` in a process of its own, on a scene whose module is in the cache,
and waits in headless Chromium, which runs already, for the first frame of the rod. Then tabs are
opened and closed at one server, in groups; its memory is that after the first groups, when caches
are full, and in the end.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser

from rodgen.scene.examples import find_example
from rodgen_evidence.benchmarks.live import browsing, resident, serving

GROUP = 10  # tabs at a time, fewer than the runs that a server holds
WARM = 2  # groups whose memory is not counted
GRACE = 12.0  # seconds after which the runs of closed tabs have ended
ROD = "window.rodgenLive?.frames > 0"


def first_frame(browser: Browser, scene: Path) -> tuple[float, float]:
    """Seconds from the command to the address, and to the rod."""
    start = time.monotonic()
    with serving(scene) as (address, _):
        ready = time.monotonic() - start
        with tab(browser, address):
            return ready, time.monotonic() - start


@contextmanager
def tab(browser: Browser, address: str) -> Iterator[None]:
    """A tab that shows the rod."""
    page = browser.new_page()
    page.goto(address)
    page.wait_for_function(ROD)
    yield
    page.close()


def left_by_tabs(browser: Browser, scene: Path, tabs: int) -> list[float]:
    """Memory of a server [MB] after each group of tabs that were opened and closed."""
    found = []
    with serving(scene) as (address, process):
        for _ in range(WARM + -(-tabs // GROUP)):
            for _ in range(GROUP):
                with tab(browser, address):
                    time.sleep(0.2)
            time.sleep(GRACE)
            found.append(resident(process))
    return found[WARM - 1 :]


def main(rounds: int, tabs: int) -> None:
    """Print both. Exits where no browser is installed."""
    scene = find_example("flutter")
    with browsing() as browser:
        first_frame(browser, scene)  # fills the caches
        found = [first_frame(browser, scene) for _ in range(rounds)]
        for what, seconds in zip(("address", "rod"), zip(*found, strict=True), strict=True):
            least, middle = min(seconds), statistics.median(seconds)
            print(f"from the command to the {what}: {least:.2f} s, median {middle:.2f} s")
        memory = left_by_tabs(browser, scene, tabs)
    print("memory of the server after groups of tabs:", *(f"{one:.0f}" for one in memory), "MB")
    print(f"{tabs} tabs left {memory[-1] - memory[0]:.1f} MB")


if __name__ == "__main__":
    asked = argparse.ArgumentParser()
    asked.add_argument("--rounds", type=int, default=6)
    asked.add_argument("--tabs", type=int, default=100)
    main(**vars(asked.parse_args()))
