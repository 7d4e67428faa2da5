"""Sow the faults of `tests.mutation.faults` one at a time and tell which of them the tests find.

A fault is sown into a copy of the packages, which the tests of the fault see in place of the
sources: those that are unmarked, then the slow ones. Outcomes are kept in build/faults.jsonl, by
the fault, the sources and its tests, so that a run that was interrupted goes on. In the end the
tests that have found faults are run without any, and have to pass. Ends with status 1 if a fault
was missed, a text is gone, or such a test fails.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from pathlib import Path
from typing import Any

from rodgen.loading.cache import PACKAGES as GENERATOR
from tests.mutation.faults import FAULTS, Fault
from tests.mutation.finder import NOTE, ONLY

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "build" / "faults.jsonl"
PACKAGES = {"src/rodgen": "rodgen", "derive": "rodgen/derive", "templates": "rodgen/templates"}
PACKAGES |= {"live/src/rodgen_live": "rodgen_live"}
CACHED = (*GENERATOR, "rodgen.check")  # packages that the folder of a cache is named after
FOUND, MISSED, GONE, BROKEN = "found", "MISSED", "GONE", "BROKEN"
LIMIT = 900.0  # s of a fault's tests: with the fault there is no end
FAILED, STOPPED = 1, 2  # status of pytest: a test failed, or files could not be imported
Row = dict[str, Any]


def lay(folder: Path) -> Path:
    """The packages as they lie in a wheel."""
    for source, target in PACKAGES.items():
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / source, folder / target, ignore=ignored, dirs_exist_ok=True)
    return folder


def place(fault: Fault, layout: Path) -> Path:
    """The one file that has the text. Raises LookupError if there is none, or if the text is
    there more than once."""
    own = "" if fault.room.startswith("rodgen") else "rodgen"
    room = layout / own / fault.room
    files = sorted(path for path in room.rglob("*") if path.is_file() and path.suffix != ".so")
    right = fault.right.encode()
    texts = {path: path.read_bytes() for path in files}  # some are no text
    holding = [path for path, text in texts.items() if right in text]
    count = sum(texts[path].count(right) for path in holding)
    if count != 1:
        names = ", ".join(path.relative_to(layout).as_posix() for path in holding)
        raise LookupError(f"{fault.right!r} stands {count} times in {fault.room} ({names})")
    return holding[0]


def hash_of(fault: Fault, layout: Path) -> str:
    """A hash of what the outcome of a fault follows from: itself, the sources, its tests and all
    that tests may import."""
    digest = hashlib.sha256(repr(fault).encode())
    tests = [ROOT / "tests" / test for test in fault.tests.split()]
    every = [*(ROOT / "tests").rglob("*.py"), *(ROOT / "live" / "tests").rglob("*.py")]
    tests += [ROOT / "conftest.py", *(one for one in every if not one.name.startswith("test_"))]
    for folder in (layout, *tests):
        inside = folder.rglob("*") if folder.is_dir() else [folder]
        for file in sorted(path for path in inside if path.is_file()):
            if file.suffix != ".pyc":
                digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


class Runs:
    """Runs of pytest, which end when this one does."""

    def __init__(self, limit: float):
        self._limit, self._over = limit, False
        self._going = set[subprocess.Popen[bytes]]()

    def tested(self, tests: list[str], env: dict[str, str], *options: str) -> tuple[int, Row]:
        """The status of pytest, and what its plugin has written down. A process that dies, or does
        not end, has failed."""
        command = [sys.executable, "-m", "pytest", "-q", "-p", "tests.mutation.finder"]
        command += ["-p", "no:cacheprovider", "-p", "no:xdist", "-m", "not nightly", *options]
        with tempfile.TemporaryDirectory(prefix="rodgen-note-") as folder:
            note = Path(folder) / "note.json"
            run = self._begun([*command, *tests], {**os.environ, **env, NOTE: str(note)})
            try:
                status = run.wait(self._limit)
            except subprocess.TimeoutExpired:
                return FAILED, {"failed": [f"no end within {self._limit:g} s"]}
            finally:
                self._end(run)
            if self._over:
                raise KeyboardInterrupt
            if status < 0:
                return FAILED, {"failed": [f"the tests died of signal {-status}"]}
            return status, json.loads(note.read_text(encoding="utf-8")) if note.exists() else {}

    def _begun(self, command: list[str], env: dict[str, str]) -> subprocess.Popen[bytes]:
        if self._over:
            raise KeyboardInterrupt
        quiet = subprocess.DEVNULL
        streams = {"stdin": quiet, "stdout": quiet, "stderr": quiet}
        run = subprocess.Popen(command, cwd=ROOT, env=env, start_new_session=True, **streams)
        self._going.add(run)
        return run

    def _end(self, run: subprocess.Popen[bytes]) -> None:
        with suppress(OSError):  # it and all that it has started
            os.killpg(run.pid, signal.SIGKILL)
        run.wait()
        self._going.discard(run)

    def end(self) -> None:
        """End those that go on, and begin no others."""
        self._over = True
        for run in list(self._going):
            self._end(run)


def sow(number: int, layout: Path, runs: Runs, first: str = "") -> Row:
    """The outcome of a fault in a layout of its own; first: the test that has found it before."""
    fault = FAULTS[number - 1]
    row: Row = {"number": number, "fault": repr(fault), "hash": hash_of(fault, layout)}
    try:
        file = place(fault, layout)
    except LookupError as error:
        return row | {"outcome": GONE, "by": str(error)}
    row["file"] = file.relative_to(layout).as_posix()
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace(fault.right, fault.wrong), encoding="utf-8")
    env = {"PYTHONPATH": str(layout)}
    if any(file.is_relative_to(layout.joinpath(*name.split("."))) for name in CACHED):
        env["RODGEN_TEST_CACHES"] = str(layout / "cache")  # what nobody else has any use for
    tests = [str(ROOT / "tests" / test) for test in fault.tests.split()]
    start, status, note = time.perf_counter(), 0, Row()
    if first:
        status, note = runs.tested([first], env, "-x")
    if status not in (FAILED, STOPPED):
        status, note = runs.tested(tests, env, "-x")
    row |= {"outcome": FOUND if status in (FAILED, STOPPED) else MISSED}
    row["by"] = (note.get("failed") or [f"pytest ended with status {status}"])[0]
    row["processor"] = note.get("processor", 0.0)
    if row["by"].endswith(".py") and runs.tested(tests, {}, "--collect-only")[0]:
        row["outcome"] = BROKEN  # a file that cannot be imported without the fault as well
    return row | {"seconds": round(time.perf_counter() - start, 1)}


def sown(number: int, runs: Runs, known: list[Row], again: bool) -> Row:
    """The outcome of a fault, that which is known or a new one, which is kept."""
    fault = FAULTS[number - 1]
    before = [row for row in known if row["fault"] == repr(fault)]
    with tempfile.TemporaryDirectory(prefix="rodgen-fault-") as folder:
        layout = lay(Path(folder))
        digest = hash_of(fault, layout)
        same = [row for row in before if row["hash"] == digest and not again]
        if same and same[-1]["outcome"] == FOUND and "::" in same[-1]["by"]:
            return same[-1] | {"number": number}
        found = [row["by"] for row in before if row["outcome"] == FOUND and "::" in row["by"]]
        row = sow(number, layout, runs, found[-1] if found else "")
    keep(row)
    return row


def keep(row: Row) -> None:
    """Write an outcome down."""
    with KEPT.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps(row) + "\n")


def shown(row: Row) -> str:
    """An outcome in a line."""
    fault = FAULTS[row["number"] - 1]
    time_ = f" in {row['seconds']:.0f} s ({row.get('processor', 0):.0f} s of a processor)"
    where = f": {row.get('file', fault.room)}: {fault.wrong[:60]!r}; {row['by']}"
    return f"{row['number']:3} {row['outcome']}{time_ if 'seconds' in row else ''}{where}"


def broken(rows: list[Row], runs: Runs) -> list[Row]:
    """Of faults that were found: those whose tests fail without them as well."""
    found = [row for row in rows if row["outcome"] == FOUND and "::" in row["by"]]
    files = sorted({row["by"].partition("::")[0] for row in found})
    files = [file for file in files if (ROOT / file).exists()]  # not moved meanwhile
    if not files:
        return []
    _, note = runs.tested(files, {ONLY: "\n".join(row["by"] for row in found)})
    failed = note.get("failed", [])
    return [row | {"outcome": BROKEN} for row in found if row["by"] in failed]


def main() -> None:
    """Sow, and say how many were found."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutation.seed", description=__doc__)
    last = len(FAULTS)
    parser.add_argument("--from", dest="low", type=int, default=1, help=f"the first of 1 to {last}")
    parser.add_argument("--to", dest="high", type=int, default=last, help="the last")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="how many at a time")
    parser.add_argument("--limit", type=float, default=LIMIT, help=f"s for each, {LIMIT:g}")
    parser.add_argument("--again", action="store_true", help="also those whose outcome is known")
    given = parser.parse_args()
    if not 1 <= given.low <= given.high <= last:
        parser.error(f"--from {given.low} --to {given.high}: not within 1 to {last}")
    numbers = range(given.low, given.high + 1)
    KEPT.parent.mkdir(exist_ok=True)
    lines = KEPT.read_text(encoding="utf-8").splitlines() if KEPT.exists() else []
    known, rows, runs = [json.loads(line) for line in lines], list[Row](), Runs(given.limit)
    for one in (signal.SIGINT, signal.SIGTERM):  # also where a shell ignores the first
        signal.signal(one, signal.default_int_handler)
    pool = ThreadPoolExecutor(max(given.jobs, 1))
    try:
        going = [pool.submit(sown, number, runs, known, given.again) for number in numbers]
        for one in as_completed(going):
            rows.append(one.result())
            print(shown(rows[-1]), flush=True)
        failing = broken(rows, runs)
    except KeyboardInterrupt:
        print(f"interrupted after {len(rows)} of {len(numbers)}: the same command goes on")
        sys.exit(130)
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        runs.end()
    for row in failing:
        keep(row)
        print(f"{row['number']:3} {BROKEN}: fails without the fault as well: {row['by']}")
    count = sum(row["outcome"] == FOUND for row in rows) - len(failing)
    print(f"{count} of {len(rows)} found")
    sys.exit(count < len(rows))


if __name__ == "__main__":
    main()
