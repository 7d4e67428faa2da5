"""Sow the faults of `tests.mutation.faults` one at a time and tell which of them the tests find.

A fault is sown into a copy of the packages, which the tests of the fault see in place of the
sources. Ends with status 1 if a fault was missed or a text is gone.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.cache import cache
from tests.mutation.faults import FAULTS, Fault

ROOT = Path(__file__).parents[2]
PACKAGES = {"src/rodgen": "rodgen", "derive": "rodgen/derive", "templates": "rodgen/templates"}
FOUND, MISSED, GONE = "found", "MISSED", "GONE"


def lay(folder: Path) -> Path:
    """The packages as they lie in a wheel."""
    for source, target in PACKAGES.items():
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / source, folder / target, ignore=ignored, dirs_exist_ok=True)
    return folder


def place(fault: Fault, layout: Path) -> Path:
    """The one file that has the text. Raises LookupError if there is none, or if the text is
    there more than once."""
    room = layout / "rodgen" / fault.room.removeprefix("rodgen").strip("/")
    files = sorted(path for path in room.rglob("*") if path.is_file() and path.suffix != ".so")
    right = fault.right.encode()
    texts = {path: path.read_bytes() for path in files}  # some are no text
    holding = [path for path, text in texts.items() if right in text]
    count = sum(texts[path].count(right) for path in holding)
    if count != 1:
        names = ", ".join(path.relative_to(layout).as_posix() for path in holding)
        raise LookupError(f"{fault.right!r} stands {count} times in {fault.room} ({names})")
    return holding[0]


def sow(fault: Fault, number: int) -> str:
    """Whether the tests of a fault fail with it."""
    with tempfile.TemporaryDirectory(prefix="rodgen-fault-") as folder:
        layout = lay(Path(folder))
        try:
            file = place(fault, layout)
        except LookupError as error:
            print(f"{number:3} {GONE}: {error}", flush=True)
            return GONE
        text = file.read_text(encoding="utf-8")
        file.write_text(text.replace(fault.right, fault.wrong), encoding="utf-8")
        tests = [str(ROOT / "tests" / test) for test in fault.tests.split()]
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-x",
            "-q",
            "-p",
            "no:cacheprovider",
            "-p",
            "no:xdist",
        ]
        command += ["-m", "not nightly", *tests]
        env = {**os.environ, "PYTHONPATH": folder}
        ask = [sys.executable, "-c", "from tests.cache import cache; print(cache())"]
        made = subprocess.run(ask, cwd=ROOT, env=env, capture_output=True, text=True).stdout.strip()
        start = time.perf_counter()
        done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True)
        seconds = time.perf_counter() - start
        if made and Path(made) != cache():  # by a generator that nobody has
            shutil.rmtree(made, ignore_errors=True)
    # 1: tests failed; 2: they could not be collected, as the package cannot be imported.
    outcome = FOUND if done.returncode in (1, 2) else MISSED
    lines = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    by = lines[0][:90] if lines else f"status {done.returncode}"
    where = file.relative_to(layout)
    print(f"{number:3} {outcome} in {seconds:.0f} s: {where}: {fault.wrong!r}; {by}", flush=True)
    return outcome


def span(word: str) -> range:
    """Numbers of faults, from 1, as 3 and 20-25 name them."""
    low, _, high = word.partition("-")
    numbers = range(int(low), int(high or low) + 1)
    if not numbers or not 1 <= numbers[0] <= numbers[-1] <= len(FAULTS):
        raise ValueError(word)
    return numbers


def main() -> None:
    """Sow, and say how many were found."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutation.seed", description=__doc__)
    which = f"faults such as 3 or 20-25, of 1 to {len(FAULTS)}; all of them take an hour"
    parser.add_argument("faults", nargs="*", type=span, help=which)
    parser.add_argument("--check", action="store_true", help="only whether texts stand once")
    given = parser.parse_args()
    numbers = [number for span in given.faults for number in span] or range(1, len(FAULTS) + 1)
    if given.check:
        with tempfile.TemporaryDirectory() as folder:
            layout = lay(Path(folder))
            for number in numbers:
                place(FAULTS[number - 1], layout)
        return
    outcomes = [sow(FAULTS[number - 1], number) for number in numbers]
    print(f"{outcomes.count(FOUND)} of {len(outcomes)} found")
    sys.exit(outcomes.count(FOUND) < len(outcomes))


if __name__ == "__main__":
    main()
