"""A result file that grows while a run goes on, and that is whole at every moment."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, Self

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.files import Closing, atomic_write, file_layout
from rodgen.integrate.files.file_layout import (
    GIVEN,
    NO_STATS,
    PARAMETERS,
    RUNNING,
    WORK,
    RunState,
    check_layout,
    contents,
    variables_of,
)
from rodgen.integrate.files.netcdf import MOST, Header, RecordFile, empty_file, read_header
from rodgen.integrate.files.result_file import ResultFile, open_header
from rodgen.integrate.stepper import Stats
from rodgen.integrate.trajectory import Changes, Trajectory
from rodgen.loading import build
from rodgen.result import Note
from rodgen.system import System

BLOCK = 2**20  # bytes of records that are made at once
INPUT = "time", "y", PARAMETERS, GIVEN  # and works: all else follows from them


class Stream(Closing):
    """Samples of a run and what follows from them, in a NetCDF file that grows.

    Samples, events and the text of the run are in the file as soon as the method that writes them
    returns, and a process that is killed leaves each whole or not at all. (A power failure may
    cost all that `finish` has not made sure of.) As a context manager it closes the file, its
    status as it was.
    """

    def __init__(self, path: Path, header: Header, system: System, model: ModuleType):
        """Open a file that is there; use `create` or `reopen`."""
        self.path, self.system, self.model = path, system, model
        self._file = RecordFile(path, header)
        try:
            self._run = RunState.of(self._file.read_fixed(file_layout.RUN).tobytes(), path)
        except InputError:
            self.close()
            raise
        self._file.count = self._run.samples
        has_events = "event_number" in header.variables
        self._capacity = header.variables["event_number"].shape[0] if has_events else 0
        self._first: float | None = None  # energy [J] at the start of the run
        for record in self._file.records()[:1]:
            energies = (record[f"{kind}_energy"] for kind in ("kinetic", "spring", "gravity"))
            self._first = sum(energies, start=0.0)
            if system.settings.t_eval is not None:  # work was done before the first sample
                works = (name for name in record.dtype.names or () if name.startswith(WORK))
                self._first -= sum((record[name] for name in works), start=0.0)

    @classmethod
    def create(
        cls,
        path: Path,
        system: System,
        model: ModuleType,
        work_terms: Sequence[str],
        events: int = 0,
        changed: bool = False,
    ) -> Self:
        """Create a file without samples; events: room for so many; changed: each sample has
        parameters of its own.

        Raises InputError where there is no such folder, or for more than the format can hold.
        """
        with atomic_write(path) as part:
            parts = contents(system, model, work_terms, events, changed)
            part.write_bytes(_with_run_text(empty_file(*parts, aligned=file_layout.RUN)))
        return cls(path, open_header(path)[0], system, model)

    @classmethod
    def reopen(cls, path: Path, model: ModuleType | None = None, most: int | None = None) -> Self:
        """Open a file to go on with: its status is running again, half a record at the end cut off.

        model: the module it was made with, built if it is not given; most: samples to go back to,
        of which none may be damaged. Raises InputError for files that are not rodgen's or not as
        they were written, BuildError where the module cannot be built.
        """
        with ResultFile(path) as file:
            file.samples(most)
            file.events()
            header, system = file.header, System(file.scene)
        if model is None:
            made = (header.attributes.get(key, "") for key in ("target", "form"))
            model = build(system.structure, *made)
        check_layout(header, system, model, path)
        stream = cls(path, header, system, model)
        if stream._run.events < stream._capacity:  # it may be half written
            stream._clear_event(stream._run.events)
        stream.truncate(stream.count if most is None else min(most, stream.count))
        stream.write_status(RUNNING, "", stream._run.stats)
        return stream

    @property
    def count(self) -> int:
        """Number of samples in the file."""
        return self._file.count

    @property
    def events(self) -> int:
        """Number of events added so far, with those for which there was no room."""
        return self._run.events + self._run.lost

    def append(
        self, t: Array, y: Array, work: Mapping[str, Array], changes: Changes | None = None
    ) -> None:
        """Append samples at times t (K,) [s]: states y (K, S), work [J] by term, each (K,);
        parameters and energy given then, if the file was created for changes.

        Raises ValueError for other shapes or terms, InputError where no more samples fit in.
        """
        record, count = self._file.header.record, len(t)
        given = {"time": t, "y": y, **{WORK + term: values for term, values in work.items()}}
        if changes is not None:
            given |= {PARAMETERS: changes.p, GIVEN: changes.given}
        shapes = {name: values.shape for name, values in given.items()}
        names = [name for name in record.names or () if name in INPUT or name.startswith(WORK)]
        due = {name: (count, *record[name].shape) for name in names}
        if shapes != due:
            raise ValueError(f"samples of shapes {shapes}, not {due}")
        if self.count + count > MOST:
            raise InputError("samples", self.count + count, f"at most {MOST} in a file")
        more: dict[str, Any] = {"model": self.model, "changes": changes}
        whole = Trajectory(self.system, t, y, dict(work), NO_STATS, **more)
        at_once = max(1, BLOCK // record.itemsize)
        for at in range(0, count, at_once):
            self._append(whole.isel(slice(at, at + at_once)))

    def _append(self, block: Trajectory) -> None:
        with np.errstate(all="ignore"):  # of a run that blew up
            if self._first is None:
                self._first = block.start_energy
            block.start_energy = self._first
            found = variables_of(block)
        records = np.zeros(len(block.t), self._file.header.record)
        for name, quantity in found.items():
            records[name] = quantity.values
        first = self.count
        sums = file_layout.checksums_of_records(records, first, self._run.fixed)
        records[file_layout.CHECKSUM] = sums
        self._file.append(records)
        self._write_run(self._run._replace(samples=first + len(records)))
        self._file.count_to(first + len(records))

    def add_event(self, number: int, t: float, y: Array) -> None:
        """Add an event, by the number of its kind in the scene, at time t [s] in state y (S,).

        One for which there is no room is counted in the text of the run, and lost.
        """
        run = self._run
        if run.events == self._capacity:
            self._write_run(run._replace(lost=run.lost + 1))
            return
        checksum = file_layout.checksum_of_event(run.events, number, t, y, run.fixed)
        self._put_event(run.events, number, t, y, checksum)
        self._write_run(run._replace(events=run.events + 1))

    def _clear_event(self, at: int) -> None:
        self._put_event(at, -1, np.nan, np.full(len(self.model.STATE), np.nan), np.int32(0))

    def _put_event(self, at: int, number: int, t: float, y: Array, checksum: np.int32) -> None:
        """Write an event; its number is there only while all that belongs to it is."""
        self._file.put("event_number", at, -1)
        self._file.put("event_time", at, t)
        self._file.put("event_y", at, y)
        self._file.put("event_checksum", at, checksum)
        self._file.put("event_number", at, number)

    def truncate(self, count: int, events: int | None = None) -> None:
        """Go back to so many samples, and to so many events as `events` counts them, if given.

        Raises ValueError where there are fewer.
        """
        events = self.events if events is None else events
        if not (0 <= count <= self.count and 0 <= events <= self.events):
            there = f"{self.count} samples and {self.events} events"
            raise ValueError(f"cannot go back from {there} to {count} and {events}")
        self._file.count_to(count)
        self._write_run(self._run._replace(samples=count))
        self._file.truncate()
        self._first = self._first if count else None
        while self._run.events > events:
            self._write_run(self._run._replace(events=self._run.events - 1))
            self._clear_event(self._run.events)
        self._write_run(self._run._replace(lost=events - self._run.events))

    def write_status(self, status: str, message: str, stats: Stats | None) -> None:
        """Write how the run goes; a message of more than some 4000 letters is cut."""
        self._write_run(self._run._replace(status=status, message=message, stats=stats))

    @property
    def notes(self) -> tuple[Note, ...]:
        """Doubts about the run."""
        return self._run.notes

    def write_notes(self, notes: tuple[Note, ...]) -> None:
        """Write the doubts about the run."""
        self._write_run(self._run._replace(notes=notes))

    def _write_run(self, run: RunState) -> None:
        self._file.put_text(file_layout.RUN, run.text())
        self._run = run

    def finish(self, status: str, message: str, stats: Stats) -> None:
        """Write how the run ended, wait until all of it is on the disk, and close the file."""
        self.write_status(status, message, stats)
        self._file.sync()
        self.close()

    def close(self) -> None:
        """Close the file; what is in it stays as it is."""
        self._file.close()


def _with_run_text(image: bytes) -> bytes:
    """Put the text of the run, with the checksum of the rest, into a file without samples."""
    header = read_header(io.BytesIO(image))
    fixed = file_layout.checksum_of_header(header, lambda at, size: image[at : at + size])
    at = header.variables[file_layout.RUN].begin
    text = RunState(fixed=fixed).text()
    return image[:at] + text + image[at + len(text) :]
