"""Files of pictures: all of them, whole, or none."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

from rodgen.show.canvas import draw_into, figure_without_window
from rodgen.show.picture_settings import VECTORS, PictureSettings
from rodgen.show.style import style

# What differs from one writing to the next of the same picture.
NO_DATES: dict[str, dict[str, None]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
LOWEST = 0.62  # of its own height, that a picture keeps at least where it is narrower


def save_figures(
    figures: Iterable[tuple[str, Figure]],
    folder: Path,
    settings: PictureSettings = PictureSettings(),  # noqa: B008  it cannot be changed
) -> list[Path]:
    """Write figures by name into a folder that exists; returns the files. figures: an iterator that
    draws them, in rodgen's style and in the width that is asked for. Vector files have no title."""
    size = figure_without_window if settings.width is None else partial(_scale, settings.width)
    ending = settings.format
    with (
        tempfile.TemporaryDirectory(dir=folder, prefix=".pictures") as making,
        rc_context(style | {"svg.hashsalt": "rodgen"}),
        draw_into(size),
    ):
        made = []
        for name, figure in figures:
            made.append(Path(making) / f"{name}.{ending}")
            if ending in VECTORS:
                figure.suptitle("")
            figure.savefig(made[-1], metadata=NO_DATES.get(ending))
        return [picture.replace(folder / picture.name) for picture in made]


def _scale(across: float, figsize: tuple[float, float], **how: Any) -> Figure:
    """Make a figure of another width [inches], and as much lower as the fonts allow, which stay as
    they are."""
    width, height = figsize
    return figure_without_window(figsize=(across, height * max(across / width, LOWEST)), **how)
