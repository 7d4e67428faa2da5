"""Films of the gallery: what encodes them, and those that move as thumbnails.

python docs/site/films.py draws the latter anew, into docs/pictures.
"""

from __future__ import annotations

import runpy
from pathlib import Path

import imageio_ffmpeg
import matplotlib
from matplotlib.animation import PillowWriter

DOCS = Path(__file__).parents[1]
DOTS, PICTURES = 50, 20  # an inch, and a second


def encode(_: object = None, __: str = "") -> None:
    """Have films encoded by the program that comes with imageio-ffmpeg."""
    matplotlib.rcParams["animation.ffmpeg_path"] = imageio_ffmpeg.get_ffmpeg_exe()


def thumbnails() -> None:
    """Write a GIF of every example that has a film."""
    matplotlib.use("agg")
    for example in sorted((DOCS / "gallery").glob("plot_*.py")):
        if "\nfilm = " in example.read_text():
            film = runpy.run_path(str(example))["film"]
            path = DOCS / "pictures" / f"film_{example.stem.removeprefix('plot_')}.gif"
            film.save(path, PillowWriter(PICTURES), dpi=DOTS)
            print(path.relative_to(DOCS.parent), path.stat().st_size)


if __name__ == "__main__":
    thumbnails()
