"""Shared part of the commands that follow a curve: where they resume, what Ctrl-C and a kill leave,
how the curve ends, and what is printed, written and drawn of it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rodgen.cli.console import out, picture_settings, print_result, show_work, warn, write_picture
from rodgen.cli.exits import (
    FAILED_RUN,
    INTERRUPTED,
    call_at_end,
    fail,
    ignore_ctrl_c,
    treat_signals_as_ctrl_c,
)
from rodgen.cli.options import LAST, point_number
from rodgen.cli.result_folders import output_folder
from rodgen.dataset_result import DatasetResult
from rodgen.errors import AnalysisError, BranchInterrupted, InputError
from rodgen.scene import Scene

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from rodgen.analyse.curves.journal import Journal


@dataclass(frozen=True)
class CurveStart:
    """Start of a command on a curve. journal: its own, None where it writes no file; curve: that of
    another file; at: the number of its point."""

    journal: Journal | None
    curve: xarray.Dataset | None = None
    point: int = LAST


def find_start(
    command: str,
    scene: Scene,
    options: Mapping[str, Any],
    file: Path,
    as_json: bool,
    resume: Path | None,
    point: int | None,
    read: Callable[[Path], xarray.Dataset],
) -> CurveStart:
    """Find where a command begins by --resume: in its own steps, which a kill has left beside the
    file, else on the curve in the file of --resume.

    options: all that its curve follows from beside the scene; file: that of the curve; as_json:
    that is not written, nor are its steps. Raises InputError; also without --resume where steps
    were left, which would be lost.
    """
    from rodgen.analyse.curves.journal import Journal, identity, journal_path

    number = point_number(resume, point, "--resume")
    if as_json:
        return CurveStart(None, None if resume is None else read(resume), number)
    path = journal_path(file)
    left = Journal.read(path)
    own = identity({"command": command, "scene": scene.to_dict(), **options, "resume": None})
    if resume is None:
        if left is not None:
            raise _lost_steps_error(path, file, left)
        return CurveStart(Journal(path, own))
    here = resume.absolute() == file.absolute()
    if left is not None and here and point is None and left.command == own:
        return CurveStart(left)
    if left is not None and here and not resume.exists():
        changed = [name for name in own if own[name] != left.command.get(name)]
        allowed = f"the file of the command that was stopped (changed: {', '.join(changed)})"
        raise InputError("--resume", str(resume), allowed)
    curve = read(resume)
    own |= {"resume": file_hash(resume), "point": number}
    if left is not None and left.command == own:
        return CurveStart(left, curve, number)
    if left is not None and here:
        warn(f"{path} held {left.n_unread} steps of a command with other options; it is replaced")
    elif left is not None:
        raise _lost_steps_error(path, file, left)
    return CurveStart(Journal(path, own), curve, number)


def _lost_steps_error(path: Path, file: Path, left: Journal) -> InputError:
    """Error for steps of a stopped command, which would be lost."""
    what = f"{left.n_unread} steps of a command that was stopped"
    allowed = f"given as {file}, with the options of then, or {path} away, which has {what}"
    return InputError("--resume", None, allowed)


def file_hash(file: Path) -> str:
    """Hash of the content of a file; raises InputError for one that cannot be read."""
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError("file", str(file), f"one that can be read ({error.strerror})") from None


def follow_curve(
    what: str,
    title: str,
    file: Path,
    as_json: bool,
    begun: CurveStart,
    follow: Callable[[Callable[[str], None]], xarray.Dataset],
    draw: Callable[[xarray.Dataset], Figure] | None = None,
    file_stem: Callable[[xarray.Dataset], str] | None = None,
) -> None:
    """Follow a curve and print it, as JSON or as a table, and write the file, but for JSON, and the
    picture. Ends with one line where Ctrl-C came, or where the curve ends too early.

    what: its name in messages; follow: takes a callback, which it tells of every point; draw: by
    default the picture that its Dataset has; file_stem: stem of the files that are written, by
    default that of the file.
    """
    from rodgen.analyse.curves.curve_datasets import save_curve

    with output_folder(None if as_json and picture_settings() is None else file.parent):
        data, interrupted = _follow_to_end(what, begun.journal, follow)
        print_result(title, DatasetResult(data), as_json)
        written = file if file_stem is None else file.with_stem(file_stem(data))
        count = data.sizes["point"]
        kept = f"{count} point{'s' * (count > 1)} printed"
        if not as_json:
            kept = f"{count} point{'s' * (count > 1)} in {written}; --resume {file} goes on"
            save_curve(data, written)
            out.print(f"Written: {written}")
        if not interrupted:
            _discard(begun.journal)
            write_picture(lambda: (draw or _draw_dataset)(data), written.parent, written.stem)
        if interrupted:
            fail(f"{what}: {data.attrs['end']}; {kept}", INTERRUPTED)
        if not data.attrs["complete"]:
            fail(f"{what} ends before it leaves the range: {data.attrs['end']}", FAILED_RUN)


def _follow_to_end(
    what: str,
    journal: Journal | None,
    follow: Callable[[Callable[[str], None]], xarray.Dataset],
) -> tuple[xarray.Dataset, bool]:
    """Follow a curve; returns what there is of it in the end, and whether Ctrl-C came."""
    from rodgen.analyse.curves.journal import use_journal

    treat_signals_as_ctrl_c()

    def resume_hint() -> str:
        if journal is None or not journal.path.exists():
            return ""
        return f"; --resume {journal.path.with_suffix('')} goes on"

    with show_work(f"following {what}") as said, use_journal(journal), call_at_end(resume_hint):
        try:
            return follow(said), False
        except BranchInterrupted as error:
            ignore_ctrl_c()
            return error.found, True
        except (AnalysisError, InputError):  # as it would again
            _discard(journal)
            raise


def _discard(journal: Journal | None) -> None:
    if journal is not None:
        journal.discard()


def _draw_dataset(data: xarray.Dataset) -> Figure:
    from rodgen.show.dataset_pictures import figure_of

    return figure_of(data)
