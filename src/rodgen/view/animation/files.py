"""Films as files: MP4 by ffmpeg, GIF by Pillow, frame by frame as they are drawn."""

from __future__ import annotations

import importlib
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from rodgen.scene import SceneError
from rodgen.view.animation.gif import FASTEST, gif
from rodgen.view.animation.times import Settings

Pixels = NDArray[np.uint8]
Writer = Callable[[Pixels], None]
ENDINGS = (".mp4", ".gif")
GONE = 10.0  # seconds in which ffmpeg ends once it is told to


def check_file(path: Path, settings: Settings) -> None:
    """Raise SceneError where a film with this name cannot be written."""
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise SceneError("--out", str(path), f"a file that ends in {' or '.join(ENDINGS)}")
    if not path.parent.is_dir():
        raise SceneError("--out", str(path), "in a folder that exists")
    if path.is_dir():
        raise SceneError("--out", str(path), "a file; this is a folder")
    if ending == ".gif" and settings.fps > FASTEST:
        raise SceneError("fps", settings.fps, f"at most {FASTEST:g} in a GIF")
    if ending == ".mp4" and ffmpeg() is None:
        allowed = 'a .gif, or ffmpeg installed (pip install "rodgen[view]" brings it)'
        raise SceneError("--out", str(path), allowed)


def ffmpeg() -> str | None:
    """The program: that on PATH, or that of the package imageio-ffmpeg, if there is one."""
    found = shutil.which("ffmpeg")
    if found:
        return found
    try:
        return str(importlib.import_module("imageio_ffmpeg").get_ffmpeg_exe())
    except (ImportError, RuntimeError):  # it is not there, or has no program for this machine
        return None


@contextmanager
def writer(
    path: Path, ending: str, settings: Settings, colours: Callable[[], Pixels]
) -> Iterator[Writer]:
    """A function that adds a frame (height, width, 4) to a new file; colours gives some
    frames that have the colours of the film, one above the other."""
    if ending == ".gif":
        with open(path, "wb") as file, gif(file, settings.fps, colours()) as add:
            yield add
    else:
        with _mp4(path, settings) as add:
            yield add


@contextmanager
def _mp4(path: Path, settings: Settings) -> Iterator[Writer]:
    """H.264 with 4:2:0 chroma, which every browser plays."""
    size = f"{settings.width}x{settings.height}"
    raw = ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", size, "-framerate", f"{settings.fps!r}"]
    coded = ["-c:v", "libx264", "-preset", "veryfast", "-crf", "18", "-pix_fmt", "yuv420p"]
    # Told, as players guess it from the height of the film otherwise.
    colour = ["-vf", "scale=out_color_matrix=bt709:out_range=tv", "-colorspace", "bt709"]
    colour += ["-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"]
    command = [str(ffmpeg()), "-loglevel", "error", "-y", *raw, "-i", "-", *colour, *coded]
    command += ["-movflags", "+faststart", "-f", "mp4", f"file:{path}"]
    with tempfile.TemporaryFile() as said:
        # In a session of its own: Ctrl-C is for the program that can take the file away.
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=said,
            start_new_session=True,
        )
        pipe = process.stdin
        assert pipe is not None

        def add(frame: Pixels) -> None:
            try:
                pipe.write(frame.data)
            except BrokenPipeError:
                process.wait(GONE)
                raise _refused(said) from None

        try:
            yield add
            with suppress(BrokenPipeError):
                pipe.close()
            if process.wait():
                raise _refused(said)
        finally:
            if process.poll() is None:
                process.kill()
                process.wait(GONE)
            with suppress(BrokenPipeError):
                pipe.close()


def _refused(said: IO[bytes]) -> SceneError:
    said.seek(0)
    lines = said.read().decode(errors="replace").split("\n")
    last = next((line for line in reversed(lines) if line.strip()), "it does not say why")
    return SceneError("--out", ".mp4", f".gif, or an ffmpeg that can write it ({last.strip()})")
