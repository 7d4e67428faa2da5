"""Shared part of the commands that follow a curve: where they resume, what Ctrl-C and a kill leave,
and how the curve ends."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rodgen.cli.console import out, print_json, print_result, show_work, warn, write_picture
from rodgen.cli.error_reports import FAILED_RUN, INTERRUPTED, fail
from rodgen.cli.options import LAST, point_number
from rodgen.cli.signals import call_at_end, ignore_ctrl_c, treat_signals_as_ctrl_c
from rodgen.dataset_result import DatasetResult

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from rodgen.analyse.curves.journal import Journal
    from rodgen.errors import InputError


@dataclass(frozen=True)
class CurveStart:
    """Where a command begins. journal: its own, None where it writes no file; curve: that of
    another file; at: the number of its point."""

    journal: Journal | None
    curve: xarray.Dataset | None = None
    at: int = LAST


def find_start(
    resume: Path | None,
    at: int | None,
    read: Callable[[Path], xarray.Dataset],
    file: Path | None,
    command: Mapping[str, Any],
) -> CurveStart:
    """Find where a command begins by --resume: in its own steps, which a kill has left beside the
    file, else on the curve in the file of --resume.

    command: all that its curve follows from. Raises InputError; also without --resume where steps
    were left, which would be lost.
    """
    from rodgen.analyse.curves.journal import Journal, identity, journal_path
    from rodgen.errors import InputError

    number = point_number(resume, at, "--resume")
    if file is None:
        return CurveStart(None, None if resume is None else read(resume), number)
    path = journal_path(file)
    left = Journal.read(path)
    own = identity({**command, "resume": None})
    if resume is None:
        if left is not None:
            raise _lost_steps_error(path, file, left)
        return CurveStart(Journal(path, own))
    here = resume.absolute() == file.absolute()
    if left is not None and here and at is None and left.command == own:
        return CurveStart(left)
    if left is not None and here and not resume.exists():
        changed = [name for name in own if own[name] != left.command.get(name)]
        allowed = f"the file of the command that was stopped (changed: {', '.join(changed)})"
        raise InputError("--resume", str(resume), allowed)
    curve = read(resume)
    own |= {"resume": file_hash(resume), "at": number}
    if left is not None and left.command == own:
        return CurveStart(left, curve, number)
    if left is not None and here:
        warn(f"{path} held {left.n_unread} steps of a command with other options; it is replaced")
    elif left is not None:
        raise _lost_steps_error(path, file, left)
    return CurveStart(Journal(path, own), curve, number)


def _lost_steps_error(path: Path, file: Path, left: Journal) -> InputError:
    """Error for steps of a stopped command, which would be lost."""
    from rodgen.errors import InputError

    what = f"{left.n_unread} steps of a command that was stopped"
    allowed = f"given as {file}, with the options of then, or {path} away, which has {what}"
    return InputError("--resume", None, allowed)


def file_hash(file: Path) -> str:
    """Hash of the content of a file; raises InputError for one that cannot be read."""
    from rodgen.errors import InputError

    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError("file", str(file), f"one that can be read ({error.strerror})") from None


@dataclass(frozen=True)
class FollowedCurve:
    """A followed curve, or as much of it as there was at Ctrl-C; what: its name in messages."""

    what: str
    data: xarray.Dataset
    interrupted: bool = False
    journal: Journal | None = None

    def write(self, folder: Path, name: str, draw: Callable[[], Figure]) -> None:
        """Write the file and, unless Ctrl-C came, the picture."""
        from rodgen.analyse.curves.curve_files import save

        save(self.data, folder / f"{name}.nc")
        out.print(f"Written: {folder / name}.nc")
        if not self.interrupted:
            if self.journal is not None:
                self.journal.discard()
            write_picture(draw, folder, name)

    def print_and_write(self, title: str, file: Path | None, draw: Callable[[], Figure]) -> None:
        """Print the curve as JSON, or a table of it where it goes into a file, and write the file
        and the picture."""
        found = DatasetResult(self.data)
        if file is None:
            print_json(found.to_dict())
        else:
            print_result(title, found)
            self.write(file.parent, file.stem, draw)

    def exit_if_incomplete(self, file: Path | None, resume: Path | None = None) -> None:
        """End with one line where Ctrl-C came, or where the curve ends too early. file: the one
        that was written, if any; resume: the file to resume from, if another."""
        if not self.interrupted:
            if not self.data.attrs["complete"]:
                why = f"{self.what} ends before it leaves the range: {self.data.attrs['end']}"
                fail(why, FAILED_RUN)
            return
        count = self.data.sizes["point"]
        kept = f"{count} point{'s' * (count > 1)} printed"
        if file is not None:
            kept = f"{count} point{'s' * (count > 1)} in {file}; --resume {resume or file} goes on"
        fail(f"{self.what}: {self.data.attrs['end']}; {kept}", INTERRUPTED)


def follow_curve(
    what: str,
    follow: Callable[[Callable[[str], None]], xarray.Dataset],
    journal: Journal | None = None,
) -> FollowedCurve:
    """Follow a curve by a function that takes a callback, which it tells of every point."""
    from rodgen.analyse.curves.journal import use_journal
    from rodgen.errors import AnalysisError, BranchInterrupted, InputError

    treat_signals_as_ctrl_c()

    def resume_hint() -> str:
        if journal is None or not journal.path.exists():
            return ""
        return f"; --resume {journal.path.with_suffix('')} goes on"

    with show_work(f"following {what}") as said, use_journal(journal), call_at_end(resume_hint):
        try:
            return FollowedCurve(what, follow(said), False, journal)
        except BranchInterrupted as error:
            ignore_ctrl_c()
            return FollowedCurve(what, error.found, True, journal)
        except (AnalysisError, InputError):  # as it would again
            if journal is not None:
                journal.discard()
            raise
