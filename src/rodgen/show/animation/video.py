"""Films in memory, which notebooks play."""

from __future__ import annotations

import base64
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from rodgen.errors import InputError
from rodgen.integrate import Solution
from rodgen.progress import show_run
from rodgen.show.animation.film import Film, write_film
from rodgen.show.animation.film_files import find_ffmpeg
from rodgen.show.animation.frame_times import FilmSettings, plan_frames


@dataclass(frozen=True, repr=False)
class Video:
    """A film in memory: data as in a file; ending: of such a file, ".mp4" or ".gif"; about: its
    frames, and notes; width [pixels]."""

    data: bytes = field(repr=False)
    ending: str
    about: Film
    width: int

    def __repr__(self) -> str:
        frames = f"{self.about.frames} frames, {self.about.seconds:.4g} s"
        return f"<Video {self.ending}: {frames}, {len(self.data) / 1e6:.3g} MB>"

    def _repr_html_(self) -> str:
        """HTML that plays it again and again in notebooks."""
        coded, width = base64.b64encode(self.data).decode(), f'width="{self.width}"'
        if self.ending == ".gif":
            words = f'alt="a film of {self.about.seconds:.4g} s"'
            return f'<img {width} {words} src="data:image/gif;base64,{coded}">'
        source = f'src="data:video/mp4;base64,{coded}"'
        return f"<video {width} controls autoplay loop muted playsinline {source}></video>"

    def save(self, path: str | Path) -> None:
        """Write it to a file with its ending. Raises InputError for another ending."""
        path = Path(path)
        if path.suffix.lower() != self.ending:
            raise InputError("path", str(path), f"a file that ends in {self.ending}")
        path.write_bytes(self.data)


def make_video(solution: Solution, settings: FilmSettings) -> Video:
    """Make a film of a run in memory, MP4 where that can be made, else GIF; behind a bar. Raises
    InputError for what cannot be used."""
    ending = ".gif" if find_ffmpeg() is None else ".mp4"
    first, last = (float(solution.t[at]) for at in (0, -1)) if len(solution.t) else (0.0, 0.0)
    with tempfile.TemporaryDirectory() as folder, show_run("drawing", first, last) as update:
        path = Path(folder) / f"film{ending}"
        planned = plan_frames(solution.t, settings)
        made = write_film(solution.isel(planned.kept), planned, path, settings, update)
        return Video(path.read_bytes(), ending, made, settings.width)
