"""Units in processes of their own, so that one that crashes or hangs takes none along."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path

from rodgen.analyse.precision.contestant import Measurement
from rodgen.loading.cache import write_whole
from rodgen_evidence.report.unit import Measured, Unit

AT_ONCE = 2  # of the units that are not timed
# One thread each: a contestant is not to be faster for taking a second core.
ALONE = {
    f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMBA", "VECLIB_MAXIMUM")
}
TAIL = 200  # letters of what a process that crashed said last


class Runner:
    """Measures units into a folder, one file each.

    surroundings: versions and machine, on which all rows depend; resume: take what the folder
    has of the same unit in the same surroundings; done: told every result as it comes.
    """

    def __init__(
        self,
        folder: Path,
        surroundings: Sequence[str],
        resume: bool = False,
        done: Callable[[Measured], None] = lambda _: None,
    ):
        self.folder, self.surroundings = folder, surroundings
        self.resume, self.done = resume, done
        self.running: set[subprocess.Popen[str]] = set()
        self.stopped = False

    def run(self, units: Iterable[Unit]) -> list[Measured]:
        """Results in the order of the units: first those that are not timed, two at a time."""
        units = list(units)
        names = [unit.name for unit in units]
        assert len(set(names)) == len(names), "names of units are names of files"
        found: dict[str, Measured] = {}
        untimed = [unit for unit in units if not unit.timed]
        try:
            with ThreadPoolExecutor(max(1, min(AT_ONCE, os.cpu_count() or 1))) as pool:
                futures = [pool.submit(self._one, unit) for unit in untimed]
                try:
                    for future in as_completed(futures):
                        self._keep(found, future.result())
                except BaseException:
                    self._stop()  # before the pool waits for its threads
                    raise
            for unit in units:
                if unit.timed:
                    self._keep(found, self._one(unit))
        except BaseException:
            self._stop()
            raise
        return [found[name] for name in names]

    def held(self, units: Iterable[Unit]) -> list[Measured]:
        """Read what the folder that is resumed from has of these units; measure nothing."""
        known = (self._known(unit) for unit in units)
        return [one for one in known if one is not None]

    def _known(self, unit: Unit) -> Measured | None:
        """A result in the folder of the same unit in the same surroundings."""
        known = _read(self.folder / f"{unit.name}.json") if self.resume else None
        fits = known and known.fingerprint == unit.fingerprint(self.surroundings)
        return known if known and fits and not known.failed else None

    def _keep(self, found: dict[str, Measured], one: Measured) -> None:
        found[one.name] = one
        self.done(one)

    def _stop(self) -> None:
        """End what still runs: after Ctrl-C, nothing goes on behind the back."""
        self.stopped = True
        for process in list(self.running):
            _kill(process)

    def _one(self, unit: Unit) -> Measured:
        if known := self._known(unit):
            return known
        fingerprint = unit.fingerprint(self.surroundings)
        file = self.folder / f"{unit.name}.json"
        if self.stopped:
            return Measured(unit.section, unit.name, fingerprint, 0.0, failed="stopped")
        start = time.perf_counter()
        rows, failed, seconds = self._call(unit)
        seconds = seconds or time.perf_counter() - start
        result = Measured(unit.section, unit.name, fingerprint, seconds, rows, failed)
        write_whole(file, result.dump())
        return result

    def _call(self, unit: Unit) -> tuple[list[Measurement], str, float]:
        """Rows, why there are none, and the seconds that it took."""
        process = subprocess.Popen(
            [sys.executable, "-m", "rodgen_evidence.report.unit"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, **ALONE},
            start_new_session=True,  # its own children end with it, and Ctrl-C is ours to pass on
        )
        self.running.add(process)
        try:
            output, errors = process.communicate(json.dumps(asdict(unit)), timeout=unit.limit)
        except subprocess.TimeoutExpired:
            _kill(process)
            process.communicate()
            return [], f"stopped after {unit.limit:g} s", unit.limit
        finally:
            _kill(process)
            self.running.discard(process)
        try:
            said = json.loads(output.splitlines()[-1])
            return said["rows"], said["failed"], said["seconds"]
        except (IndexError, ValueError, TypeError, KeyError):
            return [], _crash(process.returncode, errors), 0.0


def _kill(process: subprocess.Popen[str]) -> None:
    with suppress(ProcessLookupError):
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)


def _crash(status: int, errors: str) -> str:
    """Describe how a process ended that said nothing of its own."""
    last = " ".join(errors.split())[-TAIL:]
    how = f"signal {signal.Signals(-status).name}" if status < 0 else f"exit status {status}"
    return f"crashed with {how}{f': {last}' if last else ''}"


def _read(file: Path) -> Measured | None:
    """A result that is there already; None where it cannot be read."""
    try:
        return Measured.parse(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, TypeError):
        return None
