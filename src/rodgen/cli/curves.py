"""What the commands that follow a curve share: what they go on with, what Ctrl-C and a kill leave
of it, and how it ends."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rodgen.cli.console import out, print_json, print_result, warn, working, write_picture
from rodgen.cli.errors import FAILED_RUN, INTERRUPTED, fail
from rodgen.cli.options import LAST, point_of
from rodgen.cli.signals import at_last, end_as_by_ctrl_c, hold_back_ctrl_c
from rodgen.dataset_result import DatasetResult

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from rodgen.analyse.curves.journal import Journal
    from rodgen.errors import InputError


@dataclass(frozen=True)
class Going:
    """What a command goes on with: its journal, which is None where it writes no file; the curve
    of another file, and the number of its point."""

    journal: Journal | None
    curve: xarray.Dataset | None = None
    at: int = LAST


def going_on(
    resume: Path | None,
    at: int | None,
    read: Callable[[Path], xarray.Dataset],
    file: Path | None,
    command: Mapping[str, Any],
) -> Going:
    """What a command that writes a file, or none, goes on with by --resume: its own steps, which a
    kill has left beside the file, else the curve in the file of --resume.

    command: all that its curve follows from. Raises InputError; also without --resume where steps
    were left, which would be lost.
    """
    from rodgen.analyse.curves.journal import Journal, beside, identity
    from rodgen.errors import InputError

    number = point_of(resume, at, "--resume")
    if file is None:
        return Going(None, None if resume is None else read(resume), number)
    path = beside(file)
    left = Journal.read(path)
    own = identity({**command, "resume": None})
    if resume is None:
        if left is not None:
            raise _left(path, file, left)
        return Going(Journal(path, own))
    here = resume.absolute() == file.absolute()
    if left is not None and here and at is None and left.command == own:
        return Going(left)
    if left is not None and here and not resume.exists():
        changed = [name for name in own if own[name] != left.command.get(name)]
        allowed = f"the file of the command that was stopped (changed: {', '.join(changed)})"
        raise InputError("--resume", str(resume), allowed)
    curve = read(resume)
    own |= {"resume": content_of(resume), "at": number}
    if left is not None and left.command == own:
        return Going(left, curve, number)
    if left is not None and here:
        warn(f"{path} held {left.steps} steps of a command with other options; it is replaced")
    elif left is not None:
        raise _left(path, file, left)
    return Going(Journal(path, own), curve, number)


def _left(path: Path, file: Path, left: Journal) -> InputError:
    """The error for steps that were left, and would be lost."""
    from rodgen.errors import InputError

    what = f"{left.steps} steps of a command that was stopped"
    allowed = f"given as {file}, with the options of then, or {path} away, which has {what}"
    return InputError("--resume", None, allowed)


def content_of(file: Path) -> str:
    """A hash of what is in a file; raises InputError for one that cannot be read."""
    from rodgen.errors import InputError

    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError("file", str(file), f"one that can be read ({error.strerror})") from None


@dataclass(frozen=True)
class Followed:
    """A curve that was followed, or as much of it as there was when Ctrl-C came; what: it is."""

    what: str
    data: xarray.Dataset
    interrupted: bool = False
    journal: Journal | None = None

    def write(self, folder: Path, name: str, draw: Callable[[], Figure]) -> None:
        """Write the file and, unless Ctrl-C came, the picture."""
        from rodgen.analyse.curves.files import save

        save(self.data, folder / f"{name}.nc")
        out.print(f"Written: {folder / name}.nc")
        if not self.interrupted:
            if self.journal is not None:
                self.journal.discard()
            write_picture(draw, folder, name)

    def tell(self, title: str, file: Path | None, draw: Callable[[], Figure]) -> None:
        """Print the curve as JSON where it goes into no file, else a table of it, and write the
        file and the picture."""
        found = DatasetResult(self.data)
        if file is None:
            print_json(found.to_dict())
        else:
            print_result(title, found)
            self.write(file.parent, file.stem, draw)

    def stop(self, file: Path | None, resume: Path | None = None) -> None:
        """End with one line where Ctrl-C came, or where the curve ends too early. file: that was
        written, if any; resume: with which the command goes on, if not with that."""
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


def followed(
    what: str,
    follow: Callable[[Callable[[str], None]], xarray.Dataset],
    journal: Journal | None = None,
) -> Followed:
    """The curve that is followed by a function, which is given what to say of every point to."""
    from rodgen.analyse.curves.journal import written
    from rodgen.errors import AnalysisError, BranchInterrupted, InputError

    end_as_by_ctrl_c()

    def kept() -> str:
        if journal is None or not journal.path.exists():
            return ""
        return f"; --resume {journal.path.with_suffix('')} goes on"

    with working(f"following {what}") as said, written(journal), at_last(kept):
        try:
            return Followed(what, follow(said), False, journal)
        except BranchInterrupted as error:
            hold_back_ctrl_c()
            return Followed(what, error.found, True, journal)
        except (AnalysisError, InputError):  # as it would again
            if journal is not None:
                journal.discard()
            raise
