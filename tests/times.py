"""Processor time of every test, with all that it starts; `--times NAME` keeps it.

make bench NAME=tests [ARGS=COUNT]    folders and the COUNT dearest files and tests of each run
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Generator
from operator import itemgetter
from pathlib import Path

import psutil
import pytest

FOLDER = Path(__file__).parents[1] / "build" / "test-times"
SHOWN = 40


def processor_time() -> float:
    """Seconds of processor time of this process and its descendants, ended ones included."""
    total = sum(os.times()[:4])
    for child in psutil.Process().children(recursive=True):
        try:
            total += sum(child.cpu_times()[:4])
        except psutil.Error:  # it has just ended, and is counted among those that have
            continue
    return total


class Times:
    """Plugin that writes a line for every test: its name and its seconds of processor time."""

    def __init__(self, name: str, worker: bool) -> None:
        self.file, self.seconds = FOLDER / f"{name}.jsonl", 0.0
        if not worker:
            FOLDER.mkdir(parents=True, exist_ok=True)
            self.file.unlink(missing_ok=True)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Measure a test with set-up and teardown: what several share counts for the first."""
        self.seconds = 0.0
        done = yield
        row = {"test": item.nodeid, "seconds": round(self.seconds, 3)}
        with self.file.open("a", encoding="utf-8") as lines:
            lines.write(json.dumps(row) + "\n")
        return done

    def _measured(self) -> Generator[None, object, object]:
        """Add the time of a phase: in teardown a browser ends, whose time nobody inherits."""
        before = processor_time()
        try:
            return (yield)
        finally:
            self.seconds += max(0.0, processor_time() - before)

    pytest_runtest_setup = pytest.hookimpl(wrapper=True)(_measured)
    pytest_runtest_call = pytest.hookimpl(wrapper=True)(_measured)
    pytest_runtest_teardown = pytest.hookimpl(wrapper=True)(_measured)


def _totals(rows: list[tuple[str, float]]) -> list[tuple[str, int, float]]:
    """Names with how many rows each has and their seconds, the dearest first."""
    totals: dict[str, tuple[int, float]] = {}
    for name, seconds in rows:
        count, spent = totals.get(name, (0, 0.0))
        totals[name] = count + 1, spent + seconds
    return sorted(((n, c, s) for n, (c, s) in totals.items()), key=itemgetter(2), reverse=True)


def report(file: Path, shown: int) -> str:
    """Seconds of a run of tests by folder, by file and by test."""
    lines = map(json.loads, file.read_text(encoding="utf-8").splitlines())
    rows = [(line["test"], line["seconds"]) for line in lines]
    above = [seconds for _, seconds in rows if seconds > 1]
    total = sum(seconds for _, seconds in rows)
    text = [
        f"{file.stem}: {total:.0f} s of processor time, {len(rows)} tests; "
        f"{len(above)} of them take more than 1 s each, {sum(above):.0f} s together"
    ]
    for title, key in (
        ("folder", lambda test: test.partition("::")[0].rpartition("/")[0]),
        ("file", lambda test: test.partition("::")[0]),
        ("test", lambda test: test.partition("[")[0]),
    ):
        totals = _totals([(key(test), seconds) for test, seconds in rows])[:shown]
        text += [f"\n{'seconds':>8} {'cases':>6}  {title}"]
        text += [f"{seconds:8.2f} {count:6d}  {name}" for name, count, seconds in totals]
    return "\n".join(text)


if __name__ == "__main__":
    kept = sorted(FOLDER.glob("*.jsonl"), key=os.path.getmtime)
    if not kept:
        sys.exit("no times are kept: make test, or make check, keeps them")
    shown = int(sys.argv[1]) if len(sys.argv) > 1 else SHOWN
    print("\n\n".join(report(file, shown) for file in kept))
