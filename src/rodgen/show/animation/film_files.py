"""Films as files, frame by frame as they are drawn: MP4 by ffmpeg, GIF by Pillow."""

from __future__ import annotations

import importlib
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image
from scipy.spatial import KDTree

from rodgen.errors import InputError, install_command
from rodgen.show.animation.frame_times import FilmSettings

Pixels = NDArray[np.uint8]
Writer = Callable[[Pixels], None]
ENDINGS = (".mp4", ".gif")
GONE = 10.0  # seconds in which ffmpeg ends once it is told to
FASTEST = 50.0  # frames a second: browsers slow down what has less than 1/50 s a frame
COLOURS, COMMON = 255, 128  # in the palette; of them those that are taken as they are
UNCHANGED = 255  # number of the colour that is no colour: of pixels that stay as they were
BITS = 6  # of red, of green, of blue, by which the nearest colour is looked up


def check_file(path: Path, settings: FilmSettings) -> None:
    """Raise InputError where a film with this name cannot be written."""
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise InputError("--out", str(path), f"a file that ends in {' or '.join(ENDINGS)}")
    if not path.parent.is_dir():
        raise InputError("--out", str(path), "in a folder that exists")
    if path.is_dir():
        raise InputError("--out", str(path), "a file; this is a folder")
    if ending == ".gif" and settings.fps > FASTEST:
        raise InputError("fps", settings.fps, f"at most {FASTEST:g} in a GIF")
    if ending == ".mp4" and find_ffmpeg() is None:
        allowed = f"a .gif, or ffmpeg installed ({install_command('film')} brings it)"
        raise InputError("--out", str(path), allowed)


def find_ffmpeg() -> str | None:
    """Find the program ffmpeg: on PATH, or of the package imageio-ffmpeg, if there is one."""
    found = shutil.which("ffmpeg")
    if found:
        return found
    try:
        return str(importlib.import_module("imageio_ffmpeg").get_ffmpeg_exe())
    except (ImportError, RuntimeError):  # it is not there, or has no program for this machine
        return None


@contextmanager
def open_writer(
    path: Path, ending: str, settings: FilmSettings, colours: Callable[[], Pixels]
) -> Iterator[Writer]:
    """Open a film, and yield the function that adds a frame (height, width, 4); colours: returns
    some frames with the colours of the film, one above the other."""
    if ending == ".gif":
        with _open_gif(path, settings.fps, colours()) as add:
            yield add
    else:
        with _open_mp4(path, settings) as add:
            yield add


@contextmanager
def _open_mp4(path: Path, settings: FilmSettings) -> Iterator[Writer]:
    """Open a film in H.264 with 4:2:0 chroma, which every browser plays."""
    size = f"{settings.width}x{settings.height}"
    raw = ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", size, "-framerate", f"{settings.fps!r}"]
    coded = ["-c:v", "libx264", "-preset", "veryfast", "-crf", "18", "-pix_fmt", "yuv420p"]
    # Told, as players guess it from the height of the film otherwise.
    colour = ["-vf", "scale=out_color_matrix=bt709:out_range=tv", "-colorspace", "bt709"]
    colour += ["-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"]
    command = [str(find_ffmpeg()), "-loglevel", "error", "-y", *raw, "-i", "-", *colour, *coded]
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

        def add_frame(frame: Pixels) -> None:
            try:
                pipe.write(frame.data)
            except BrokenPipeError:
                process.wait(GONE)
                raise _ffmpeg_error(said) from None

        try:
            yield add_frame
            with suppress(BrokenPipeError):
                pipe.close()
            if process.wait():
                raise _ffmpeg_error(said)
        finally:
            if process.poll() is None:
                process.kill()
                process.wait(GONE)
            with suppress(BrokenPipeError):
                pipe.close()


def _ffmpeg_error(said: IO[bytes]) -> InputError:
    said.seek(0)
    lines = said.read().decode(errors="replace").split("\n")
    last = next((line for line in reversed(lines) if line.strip()), "it does not say why")
    return InputError("--out", ".mp4", f".gif, or an ffmpeg that can write it ({last.strip()})")


class Palette(NamedTuple):
    """Colours of a GIF. table: red, green, blue of each, (256, 3); nearest: number of that nearest
    to a colour by its leading BITS, (2**(3 BITS),)."""

    table: Pixels
    nearest: Pixels


@contextmanager
def _open_gif(path: Path, fps: float, colours: Pixels) -> Iterator[Writer]:
    """Open a GIF that repeats. Frames are written as they come: Pillow itself would keep all of
    them until the end."""
    palette = _make_palette(colours)
    before: Pixels | None = None
    ticks = 0.0  # hundredths of a second, the unit of GIF

    def add_frame(frame: Pixels) -> None:
        nonlocal before, ticks
        if before is None:
            blank = Image.new("P", (frame.shape[1], frame.shape[0]))
            blank.putpalette(palette.table.tobytes())
            header, _ = GifImagePlugin.getheader(blank, info={"loop": 0})
            file.write(b"".join(header))
        changed, corner = _crop_to_changes(frame, before, palette)
        shown = round(ticks + 100 / fps) - round(ticks)
        ticks += 100 / fps
        # Disposal 1: what is not painted over stays.
        how = {"duration": 10 * shown, "transparency": UNCHANGED, "disposal": 1}
        file.write(b"".join(GifImagePlugin.getdata(changed, corner, **how)))
        before = frame.copy()

    with open(path, "wb") as file:
        yield add_frame
        file.write(b";")


def _make_palette(frames: Pixels) -> Palette:
    """Choose the commonest colours of some frames, and colours that fit all others equally well,
    however few pixels have them."""
    found, counts = np.unique(_pack(frames), return_counts=True)
    order = np.argsort(-counts, kind="stable")
    colours = found[order].view(np.uint8).reshape(-1, 4)[:, :3]
    table, rest = colours[:COMMON], colours[COMMON:]
    if len(rest):
        image = Image.fromarray(np.ascontiguousarray(rest[None]))
        cut = image.quantize(COLOURS - COMMON, Image.Quantize.MEDIANCUT).getpalette() or []
        table = np.concatenate((table, np.array(cut, dtype=np.uint8).reshape(-1, 3)))
    # As many as a table has: the empty places repeat the commonest, the background.
    table = np.concatenate((table, np.broadcast_to(table[0], (256 - len(table), 3))))
    nearest = np.asarray(KDTree(table[:COLOURS]).query(_box_middles())[1], dtype=np.uint8)
    exact = np.arange(len(colours[:COMMON]), dtype=np.uint8)[::-1]
    nearest[_box_numbers(table[exact])] = exact  # the commonest last: it wins where two share a box
    return Palette(table, nearest)


def _box_numbers(colours: Pixels) -> NDArray[np.uint32]:
    """Return one number for each of the colours (..., 3 or more), of their leading bits, (...)."""
    red, green, blue = np.moveaxis(colours[..., :3].astype(np.uint32) >> (8 - BITS), -1, 0)
    number: NDArray[np.uint32] = (red << 2 * BITS) | (green << BITS) | blue
    return number


def _box_middles() -> NDArray[np.float64]:
    """Return the colour in the middle of every box, in the order of numbers, (2**(3 BITS), 3)."""
    levels = (np.arange(2**BITS) + 0.5) * 2.0 ** (8 - BITS) - 0.5
    return np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1).reshape(-1, 3)


def _crop_to_changes(
    frame: Pixels, before: Pixels | None, palette: Palette
) -> tuple[Image.Image, tuple[int, int]]:
    """Return the smallest rectangle with all changed pixels, and its upper left corner."""
    other = np.ones(frame.shape[:2], dtype=bool)
    if before is not None:
        other = _pack(frame) != _pack(before)
    rows, columns = np.flatnonzero(other.any(axis=1)), np.flatnonzero(other.any(axis=0))
    if not len(rows):  # a frame has at least a pixel
        rows = columns = np.zeros(1, dtype=int)
    inside = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    new = other[inside]
    numbers = np.full(new.shape, UNCHANGED, dtype=np.uint8)
    numbers[new] = palette.nearest[_box_numbers(frame[inside][new])]
    return Image.fromarray(numbers), (int(columns[0]), int(rows[0]))


def _pack(pixels: Pixels) -> NDArray[np.uint32]:
    """Pack pixels (height, width, 4) into one number each, (height, width)."""
    return np.ascontiguousarray(pixels).view(np.uint32)[..., 0]
