"""What the commands that follow a curve share: what Ctrl-C leaves of it, and how it ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rodgen.cli.console import finite, out, warn, working, write_picture
from rodgen.cli.errors import FAILED_RUN, INTERRUPTED, fail
from rodgen.cli.signals import end_as_by_ctrl_c, hold_back_ctrl_c

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Followed:
    """A curve that was followed, or as much of it as there was when Ctrl-C came; what: it is."""

    what: str
    data: xarray.Dataset
    interrupted: bool = False

    def write(self, folder: Path, name: str, draw: Callable[[], Figure]) -> None:
        """Write the file and, unless Ctrl-C came, the picture."""
        from rodgen.analyse.curves.files import save

        save(self.data, folder / f"{name}.nc")
        out.print(f"Written: {folder / name}.nc")
        if not self.interrupted:
            write_picture(draw, folder, name)

    def warn(self) -> None:
        """What makes it doubtful, each in a line."""
        for note in filter(None, self.data.attrs["notes"].split("\n")):
            warn(note)

    def stop(self, file: Path | None) -> None:
        """End with one line where Ctrl-C came, or where the curve ends too early. file: that was
        written, if any."""
        if not self.interrupted:
            if not self.data.attrs["complete"]:
                why = f"{self.what} ends before it leaves the range: {self.data.attrs['end']}"
                fail(why, FAILED_RUN)
            return
        count = self.data.sizes["point"]
        kept = f"{count} point{'s' * (count > 1)} printed"
        if file is not None:
            kept = f"{count} point{'s' * (count > 1)} in {file}; --resume {file} goes on with it"
        fail(f"{self.what}: {self.data.attrs['end']}; {kept}", INTERRUPTED)


def followed(what: str, follow: Callable[[Callable[[str], None]], xarray.Dataset]) -> Followed:
    """The curve that is followed by a function, which is given what to say of every point to."""
    from rodgen.analyse.errors import BranchInterrupted

    end_as_by_ctrl_c()
    with working(f"following {what}") as said:
        try:
            return Followed(what, follow(said))
        except BranchInterrupted as error:
            hold_back_ctrl_c()
            return Followed(what, error.found, True)


def numbers(option: str, text: str, mark: str) -> tuple[float, float]:
    """Two finite numbers with a mark between them. Raises SceneError."""
    from rodgen.scene import SceneError

    try:
        low, high = (float(part) for part in text.split(mark))
    except ValueError:
        raise SceneError(option, text, f"two numbers, as 0{mark}20") from None
    finite(option, low)
    finite(option, high)
    return low, high
