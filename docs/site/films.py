"""Films of the gallery: what encodes them, and the thumbnails, which move.

An example with a film has a GIF of it: python docs/site/films.py draws those anew, into
docs/pictures. The pictures of all others come into their colours from left to right, as time
or a parameter goes on in most of them.
"""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import matplotlib
from matplotlib.animation import PillowWriter
from PIL import Image

DOCS = Path(__file__).parents[1]
DOTS, PICTURES = 50, 20  # an inch, and a second
STEPS, PALE = 40, 0.2  # of a thumbnail that moves, and how much is seen of what is to come
TIMES, REST = 3, 3000  # that it is shown, and ms for which it rests each time


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


def move(app: Any) -> None:
    """Have all thumbnails that the gallery has made as pictures move: animated PNGs, shown thrice,
    that rest on the picture."""
    for path in sorted(Path(app.srcdir).glob("examples/images/thumb/*.png")):
        with Image.open(path) as opened:
            if getattr(opened, "n_frames", 1) > 1:
                continue
            whole = opened.convert("RGB")
        pale = Image.blend(Image.new("RGB", whole.size, "white"), whole, PALE)
        frames = [pale.copy() for _ in range(STEPS)]
        for step, frame in enumerate(frames):
            frame.paste(whole.crop((0, 0, whole.width * step // STEPS, whole.height)))
        # The first picture is for programs that know no animated ones.
        each = 1000 // PICTURES
        times = [each] * (STEPS + 1) + [REST]
        film = {"append_images": [*frames, whole], "duration": times, "loop": TIMES}
        whole.save(path, save_all=True, default_image=True, **film)


def setup(app: Any) -> dict[str, bool]:
    """Thumbnails move once the gallery has made them, which it does at the same event."""
    app.connect("builder-inited", move, priority=900)
    return {"parallel_read_safe": True}


if __name__ == "__main__":
    thumbnails()
