"""Films of the gallery: what encodes them, and the thumbnails, which move.

An example with a film has a GIF of it, the start page has a video, and it and the tutorial have the
pictures that their Python draws: python docs/site/films.py draws all those anew. DRAWN keeps a hash
of the code and the scenes that each was drawn from, by which a test finds those that are older. The
pictures of all other examples come into their colours from left to right, as time or a parameter
goes on in most of them.
"""

from __future__ import annotations

import ast
import contextlib
import hashlib
import json
import re
import runpy
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import matplotlib
import matplotlib.pyplot as plt
from matplotlib.animation import FFMpegWriter, PillowWriter
from PIL import Image

import rodgen

DOCS = Path(__file__).parents[1]
DRAWN = DOCS / "pictures" / "drawn.json"
# Pages whose Python draws pictures, and the size of these [inches].
PAGES = {"index": (4.6, 3.4), "tutorial": (5.8, 3.6)}
BLOCK = re.compile(r"^```(?:python|toml)\n(.*?)^```", re.DOTALL | re.MULTILINE)
START = "flutter_sets_in"  # the film of the start page
DOTS, PICTURES = 50, 20  # an inch, and a second
STEPS, PALE = 25, 0.4  # of a thumbnail that moves, and how much is seen of what is to come
TIMES, REST = 3, 300  # that it is shown, and ms between; all within five seconds


def examples() -> list[Path]:
    """The examples that have a film."""
    every = sorted(DOCS.glob("gallery/**/plot_*.py"))
    return [one for one in every if "\nfilm = " in one.read_text(encoding="utf-8")]


def sources() -> dict[str, str]:
    """A hash of what films and pictures are drawn from, by the path of the example or the page."""
    pages = (DOCS / f"{page}.md" for page in PAGES)
    return {path.relative_to(DOCS).as_posix(): _hash(path) for path in (*examples(), *pages)}


def _hash(path: Path) -> str:
    """Of the code of an example or a page, without comments, and of the scenes that it names."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        said = ast.get_docstring(ast.parse(text), clean=False) or ""
        lines = text.replace(said, "").splitlines()
        code = [line.rstrip() for line in lines if line.strip() and not line.startswith("#")]
    else:
        code = BLOCK.findall(text)
    for name in sorted(set(re.findall(r"example\(\"(\w+)\"\)", text))):
        scene = (DOCS.parent / "scenes" / f"{name}.toml").read_text(encoding="utf-8")
        code.append(json.dumps(tomllib.loads(scene), sort_keys=True))
    return hashlib.sha256("\n".join(code).encode()).hexdigest()[:16]


def prepare(_: object = None, __: str = "") -> None:
    """Have pictures in rodgen's style, and films encoded by the program of imageio-ffmpeg."""
    plt.style.use(rodgen.style | {"svg.hashsalt": "rodgen"})  # the same bytes each time
    matplotlib.rcParams["animation.ffmpeg_path"] = imageio_ffmpeg.get_ffmpeg_exe()


def thumbnails() -> None:
    """Write a GIF of every example that has a film, and the video of the start page."""
    for example in examples():
        name = example.stem.removeprefix("plot_")
        film = runpy.run_path(str(example))["film"]
        path = DOCS / "pictures" / f"film_{name}.gif"
        film.save(path, PillowWriter(PICTURES), dpi=DOTS)
        print(path.relative_to(DOCS.parent), path.stat().st_size)
        if name == START:
            path = DOCS / "static" / f"{name}.mp4"
            # Browsers play this layout of colours, and begin before they have all of it.
            kind = ["-pix_fmt", "yuv420p", "-movflags", "+faststart", "-crf", "26"]
            film.save(path, FFMpegWriter(PICTURES, "libx264", extra_args=kind), dpi=3 * DOTS)
            print(path.relative_to(DOCS.parent), path.stat().st_size)


def lines(page: str) -> None:
    """Draw what the Python of a page draws, a picture for each piece that draws one."""
    text = (DOCS / f"{page}.md").read_text()
    space: dict[str, Any] = {}
    number = 0
    for code in re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
        exec(code, space)
        if plt.get_fignums():
            plt.gcf().set_size_inches(PAGES[page])
            number += 1
            path = DOCS / "pictures" / f"{page}_{number}.svg"
            plt.savefig(path, bbox_inches="tight", metadata={"Date": None})
            plt.close("all")
            print(path.relative_to(DOCS.parent), path.stat().st_size)


def scenes(page: str) -> None:
    """Save the scenes that a page shows, as its readers do."""
    text = (DOCS / f"{page}.md").read_text()
    for code in re.findall(r"^```toml\n(name = .*?)^```", text, re.DOTALL | re.MULTILINE):
        Path(f"{tomllib.loads(code)['name']}.toml").write_text(code)


def move(app: Any) -> None:
    """Have all thumbnails that the gallery has made as pictures move: animated PNGs, shown thrice,
    that rest on the picture."""
    for path in sorted(Path(app.srcdir).glob("examples/**/images/thumb/*.png")):
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
    matplotlib.use("agg")
    prepare()
    thumbnails()
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for page in PAGES:
            scenes(page)
            lines(page)
    DRAWN.write_text(json.dumps(sources(), indent=2) + "\n", encoding="utf-8")
