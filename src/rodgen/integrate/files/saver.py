"""Saving of a run to disk: samples as they come, and checkpoints beside the result, states from
which it can go on.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import time
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError
from rodgen.integrate.events import EventDetector
from rodgen.integrate.files import atomic_write
from rodgen.integrate.files.file_layout import RUNNING
from rodgen.integrate.files.reader import solution_of
from rodgen.integrate.files.result_file import ResultFile
from rodgen.integrate.files.stream import Stream
from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.integrate.recorder import Recorder
from rodgen.integrate.solution import Solution
from rodgen.integrate.stepper import ENDED, FINISHED, Stats
from rodgen.integrate.stretches import Integrator, State
from rodgen.system import System

Number = float | int | str
NUMBERS = "numbers"  # the entry that holds them, as JSON; arrays are named array_<name>
ARRAY = "array_"
DIGITS = hashlib.sha256().digest_size * 2

IN_MEMORY = 20_000  # samples of a file that a Solution has at most
ROOM = 4096  # events that a file has room for
_NOTHING = {"samples": 0, "events": 0, "seconds": 0.0}  # what a run without a checkpoint has
PATIENCE = 2.0  # seconds after which samples are written, whether a block is full or not


def checkpoint_path(result: Path) -> Path:
    """Path of the checkpoint of a result file: run.nc has run.nc.checkpoint."""
    return result.with_name(result.name + ".checkpoint")


def write_checkpoint(
    path: Path, arrays: Mapping[str, NDArray[Any]], numbers: Mapping[str, Number]
) -> None:
    """Write arrays and numbers, whole or not at all, in place of what was there.

    The file is an .npz; its comment is the SHA-256 of all before it. Raises TypeError for arrays
    of objects and values that are no numbers or text, InputError where there is no such folder.
    """
    for name, array in arrays.items():
        if array.dtype.hasobject:
            raise TypeError(f"{name} holds objects of Python")
    entries: dict[str, Any] = {ARRAY + name: array for name, array in arrays.items()}
    entries[NUMBERS] = np.array(json.dumps(dict(numbers), default=_to_python))
    buffer = io.BytesIO()
    np.savez(buffer, **entries)
    with zipfile.ZipFile(buffer, "a") as archive:
        archive.comment = b"-" * DIGITS
    content = buffer.getvalue()[:-DIGITS]
    with atomic_write(path, "checkpoint") as part:
        part.write_bytes(content + _digest(content))


def read_checkpoint(path: Path) -> tuple[dict[str, NDArray[Any]], dict[str, Number]]:
    """Read the arrays and numbers that `write_checkpoint` was given; raises InputError for damaged
    and for other files."""
    try:
        stored = path.read_bytes()
    except OSError as error:
        allowed = f"a file that can be read ({error.strerror})"
        raise InputError("checkpoint", str(path), allowed) from None
    content, digest = stored[:-DIGITS], stored[-DIGITS:]
    if digest != _digest(content):
        raise InputError("checkpoint", str(path), "one of rodgen's, and as it was written")
    with np.load(io.BytesIO(stored), allow_pickle=False) as entries:
        arrays = {name[len(ARRAY) :]: entries[name] for name in entries if name != NUMBERS}
        return arrays, json.loads(str(entries[NUMBERS]))


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


def _to_python(value: object) -> object:
    """Convert a number of NumPy's to one of Python's."""
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{value!r} is no number")


def check_interval(seconds: float | None, field: str = "checkpoint") -> None:
    """Raise InputError unless checkpoints can be kept every so many seconds, or are not wanted."""
    if seconds is not None and not 0 < seconds < math.inf:
        raise InputError(field, seconds, "a positive number of seconds")


class Saver:
    """Writer of the file and the checkpoints of a run; writes nothing for a run without a file.

    samples, seconds: what a run that is taken up has behind it.
    """

    def __init__(
        self,
        system: System,
        model: ModuleType,
        stream: Stream | None = None,
        every: float | None = None,
    ):
        self.system, self.model, self.stream, self._every = system, model, stream, every
        self.samples, self.seconds, self.resumed = 0, 0.0, False
        self._state: State = {}
        self._written = self._saved = time.perf_counter()

    @classmethod
    def begin(
        cls, system: System, model: ModuleType, out: str | Path | None, every: float | None
    ) -> Saver:
        """Create a new file, if one is asked for. Raises InputError where it cannot be."""
        check_interval(every)
        if out is None:
            if every is not None:
                raise InputError("checkpoint", every, "given with out, beside which it is kept")
            return cls(system, model)
        works = loads_at_work(model)
        room = ROOM if system.events else 0
        # First: a state of another run beside a file would be taken for its own.
        checkpoint_path(Path(out)).unlink(missing_ok=True)
        stream = Stream.create(Path(out), system, model, works, room)
        return cls(system, model, stream, every)

    @classmethod
    def resume(cls, path: Path, every: float | None) -> Saver:
        """Open a file to go on with, from its last checkpoint; from its start if it has none.

        Raises InputError for a run that has ended, and for a checkpoint that is not of this file or
        of another module.
        """
        with ResultFile(path) as file:
            if file.run.status in ENDED:
                ended = "is finished" if file.run.status == FINISHED else file.run.message
                raise InputError("file", str(path), f"of a run to go on with; this one {ended}")
        at = checkpoint_path(path)
        state, numbers = read_checkpoint(at) if at.exists() else ({}, _NOTHING)
        try:
            samples, events = int(numbers["samples"]), int(numbers["events"])
            # What is behind them is computed again, whether it is damaged or not.
            stream = Stream.reopen(path, most=samples)
            try:
                if state and numbers["module"] != _module_key(stream.model):
                    raise InputError("checkpoint", str(at), "of this version of rodgen")
                stream.truncate(samples, events)
            except BaseException:
                stream.close()
                raise
            saver = cls(stream.system, stream.model, stream, every)
            saver.samples, saver.seconds = samples, float(numbers["seconds"])
        except (KeyError, ValueError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError("checkpoint", str(at), f"of {path.name} ({error})") from None
        saver._state, saver.resumed = state, True
        return saver

    def restore(self, machine: Integrator) -> None:
        """Restore an integrator from the checkpoint, where there is one."""
        if not self._state:
            return
        try:
            machine.restore(self._state)
        except (KeyError, ValueError) as error:
            path = str(self.stream and self.stream.path)
            raise InputError("checkpoint", path, str(error)) from None

    def attach(
        self,
        recorder: Recorder,
        machine: Integrator,
        watch: EventDetector,
        stats: Callable[[], Stats],
    ) -> None:
        """Set what is to be written from now on."""
        self._recorder, self._machine, self._watch, self._stats = recorder, machine, watch, stats

    def tick(self, now: float) -> None:
        """Write what is due."""
        if self.stream is None:
            return
        if self._every is not None and now - self._saved >= self._every:
            self._checkpoint()
            self._saved = self._written = time.perf_counter()
        elif now - self._written >= PATIENCE:
            self._write()
            self._written = time.perf_counter()

    def _write(self) -> None:
        assert self.stream is not None
        self._recorder.write()
        for number, t, y in self._watch.happened:
            self.stream.add_event(number, t, y)
        self._watch.happened.clear()  # memory is not to grow with the span
        self.stream.write_status(RUNNING, "", self._stats())

    def _checkpoint(self) -> None:
        assert self.stream is not None
        try:
            state = self._machine.state()
        except ValueError:  # it starts again where it is resumed
            self._write()
            return
        self._write()
        numbers: dict[str, Number] = {
            "samples": self.stream.count,
            "events": self.stream.events,
            "seconds": self._stats().wall_seconds,
            "module": _module_key(self.model),
        }
        write_checkpoint(checkpoint_path(self.stream.path), state, numbers)

    def finish(self, status: str, message: str, stats: Stats) -> Solution:
        """Write the last samples and how the run ended; return the Solution, thinned if long."""
        assert self.stream is not None
        path = self.stream.path
        if status not in ENDED and self._every is not None:
            self._checkpoint()
        self._write()
        self.stream.finish(status, message, stats)
        if status in ENDED:
            checkpoint_path(path).unlink(missing_ok=True)
        with ResultFile(path) as file:
            records, good = file.unchecked_samples()
            solution = solution_of(file, records, good, IN_MEMORY)
        solution.model = self.model
        return solution


def _module_key(model: ModuleType) -> str:
    """Key of the module that a state belongs to: another text of the module has another memory."""
    p = model.PROVENANCE
    return f"{p['rodgen']} {p['structure_hash']} {p['template_hash']}"
