"""Reading of result files, and checks that they are such, and as they were written."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError
from rodgen.integrate.files import Closing, file_layout
from rodgen.integrate.files.file_layout import FORMAT, RUNNING, RunState, native_copy
from rodgen.integrate.files.netcdf import Header, RecordFile, read_header
from rodgen.integrate.stepper import INTERRUPTED
from rodgen.integrate.trajectory import Event
from rodgen.scene import Scene

BLOCK = 2**20  # bytes of records that are checked at once
NAMED = 3  # stretches of damaged samples that are named one by one
# What contents that are none of ours end in.
STRANGE = LookupError, TypeError, ValueError, ArithmeticError, AttributeError, RecursionError


class FileWarning(UserWarning):
    """A result file of which not all could be read.

    Examples
    --------
    >>> import rodgen, tempfile, warnings
    >>> path = tempfile.mkdtemp() + "/run.nc"
    >>> rodgen.simulate(rodgen.Scene.example("missile"), progress=False).save(path)
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("error", rodgen.FileWarning)  # what is doubtful is refused
    ...     sol = rodgen.load(path)

    """


class ResultFile(Closing):
    """Result file, open to be read. scene: that of its run; run: how that went; notes: what is
    left out of it.

    strict: raise InputError for any damage that is found. Otherwise samples, events and the text of
    the run are left out where they are damaged, and notes say so; the header, with the scene, has
    to be as it was written in any case.
    """

    def __init__(self, path: Path, strict: bool = True):
        self.path, self.strict = path, strict
        self.notes: list[str] = []
        self._guessed = False
        self.header = header_of(path)
        if file_layout.CHECKSUM not in self.header.variables:
            raise self._damage_error("its header")
        with as_input_error(path):
            self._file = RecordFile(path, self.header, "r")
        try:
            with as_input_error(path):
                self.run = self._read_run()
                self.scene = scene_of(self.header, path)
        except BaseException:
            self._file.close()
            raise
        self._file.count = self.run.samples

    def _read_run(self) -> RunState:
        """Read how the run went, where the header is as it was written."""
        fixed = file_layout.checksum_of_header(self.header, self._file.read)
        text = self._file.read_fixed(file_layout.RUN).tobytes()
        if not file_layout.is_intact(text):
            self._report_damage("how the run went")
            self._guessed = True
            return self._guess(fixed)
        run = RunState.of(text, self.path)
        if run.fixed != fixed:
            raise self._damage_error("its header, its scene or its labels")
        # The number is written after the text: what it says now, the text says, or more.
        ended = run.status != RUNNING
        if self.header.records > run.samples or (ended and self._file.read_count() != run.samples):
            self._report_damage("the number of its samples")
        return run

    def _guess(self, fixed: int) -> RunState:
        """Reconstruct how a run went whose text is lost."""
        self._file.count = 0
        samples = max(0, self._file.surplus()) // self.header.record.itemsize
        why = "how the run went is lost"
        return RunState(INTERRUPTED, why, samples=samples, events=self._count_events(), fixed=fixed)

    def _count_events(self) -> int:
        """Number of events in the file, those that have a number."""
        if "event_number" not in self.header.variables:
            return 0
        return int((self._file.read_fixed("event_number") >= 0).sum())

    def samples(self, most: int | None = None) -> tuple[NDArray[Any], NDArray[np.intp]]:
        """Records (R,), read from the disk as they are asked for, and the numbers of those that are
        good, ascending.

        most: how many from the first on are looked at; what is behind does not matter.
        """
        size = self.header.record.itemsize
        due = self.run.samples if most is None else min(most, self.run.samples)
        self._file.count = due
        surplus = self._file.surplus()
        self._file.count = there = due + min(0, surplus // size)
        if there < 0:
            raise self._damage_error("it is cut short before its first sample")
        with as_input_error(self.path):
            records = self._file.records()
        good = np.zeros(due, bool)
        good[:there] = self._good(records)
        if self._guessed and not good.any():  # then it may be the header that is not as it was
            raise self._damage_error("how the run went, and all of its samples")
        if not good.all():
            self._report_damage(_name_gaps(good, native_copy(records["time"])))
        elif most is None and surplus and self.run.status != RUNNING:
            self._report_damage("bytes behind its samples")
        return records, np.flatnonzero(good)

    def unchecked_samples(self) -> tuple[NDArray[Any], NDArray[np.intp]]:
        """Records of a file that was written just now, all of them good, and their numbers."""
        return self._file.records(), np.arange(self.run.samples)

    def _good(self, records: NDArray[Any]) -> NDArray[np.bool_]:
        """Mask of the records that are as they were written."""
        step = max(1, BLOCK // records.dtype.itemsize)
        parts = [np.empty(0, bool)]
        for at in range(0, len(records), step):
            some = records[at : at + step]
            sums = file_layout.checksums_of_records(some, at, self.run.fixed)
            parts.append(sums == some[file_layout.CHECKSUM])
        return np.concatenate(parts)

    def events(self) -> tuple[Event, ...]:
        """Events that are good."""
        if "event_number" not in self.header.variables:
            return ()
        number, t, y, found = (self._file.read_fixed(name) for name in file_layout.EVENT)
        kept = self._good_events(number, t, y, found)
        with as_input_error(self.path):
            names = [self.scene.watched_events[k].name for k in number[kept]]
        return tuple(map(Event, names, map(float, t[kept]), native_copy(y[kept])))

    def _good_events(
        self, number: NDArray[Any], t: NDArray[Any], y: NDArray[Any], found: NDArray[Any]
    ) -> NDArray[np.intp]:
        count = self.run.events
        good = np.zeros(count, bool)
        for k in range(min(count, len(number))):
            event = number[k], t[k], y[k]
            good[k] = file_layout.checksum_of_event(k, *event, self.run.fixed) == found[k]
        if not good.all():
            self._report_damage(f"{count - good.sum()} of its {count} events")
        # The one behind them may have been half written when the run was killed.
        empty = count + (self.run.status == RUNNING)
        if not file_layout.is_empty(*(values[empty:] for values in (number, t, y, found))):
            self._report_damage("what lies behind its events")
        return np.flatnonzero(good)

    def _report_damage(self, what: str) -> None:
        """Refuse the file, or note what is left out."""
        if self.strict:
            rest = "load(..., strict=False) and rodgen animate --damaged take the rest"
            raise self._damage_error(f"{what}; {rest}")
        self.notes.append(f"{self.path} is damaged, and what is left out is: {what}")

    def _damage_error(self, what: str) -> InputError:
        return InputError("file", str(self.path), f"as it was written (damaged: {what})")

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def _name_gaps(good: NDArray[np.bool_], t: NDArray[np.float64]) -> str:
    """Name samples that are not good by the times [s] of those beside them; t: in the file."""
    bad = np.flatnonzero(~good)
    stretches = np.split(bad, np.flatnonzero(np.diff(bad) > 1) + 1)
    named = []
    for some in stretches[:NAMED]:
        before, after = int(some[0]) - 1, int(some[-1]) + 1
        sides = [f"after t = {t[before]:.9g} s"] if before >= 0 else []
        sides += [f"before t = {t[after]:.9g} s"] if after < len(good) else []
        which = f"{len(some)} sample{'s' * (len(some) > 1)}"
        named.append(f"{which} {' and '.join(sides)}".rstrip())
    more = len(stretches) - NAMED
    return ", ".join(named) + (f" and {more} more such places" if more > 0 else "")


def warn_of_notes(notes: list[str]) -> None:
    """Warn of the notes of a file, for whoever reads it."""
    for note in notes:
        warnings.warn(note, FileWarning, stacklevel=3)


def open_header(path: Path) -> tuple[Header, Scene]:
    """Header of a result file, and its scene; raises InputError for other files."""
    header = header_of(path)
    return header, scene_of(header, path)


def header_of(path: Path) -> Header:
    """Header of a result file; raises InputError for other files."""
    try:
        with open(path, "rb") as file:
            header = read_header(file)
    except (OSError, ValueError) as error:
        scene = Path(path).suffix == ".toml"
        reason = "Scene.from_toml reads scenes" if scene else str(error).splitlines()[0]
        raise InputError("file", str(path), f"a NetCDF file that can be read ({reason})") from None
    if header.attributes.get("format") != FORMAT:
        raise InputError("file", str(path), f"written by rodgen (format {FORMAT!r})")
    return header


def scene_of(header: Header, path: Path) -> Scene:
    """The scene in the header of a result file; raises InputError where there is none."""
    with as_input_error(path):
        return Scene.from_dict(json.loads(header.attributes["scene"]))


@contextmanager
def as_input_error(path: Path) -> Iterator[None]:
    """Turn errors by the contents of a file that is no result into InputErrors."""
    try:
        yield
    except (*STRANGE, OSError) as error:
        if isinstance(error, InputError) and error.field == "file":
            raise
        raise InputError("file", str(path), f"written by rodgen ({error!r})") from None
