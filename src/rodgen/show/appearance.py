"""Pictures and tables of every kind of result and of scenes, for `rodgen.display`."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import cache, partial
from html import escape
from importlib import import_module
from io import BytesIO
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from rodgen.display import Plottable, Tabular
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate import Solution
from rodgen.result import Note, Result, ResultTable
from rodgen.scene import Scene
from rodgen.show.animation.film import Video, make_video
from rodgen.show.canvas import draw_into
from rodgen.show.style import style
from rodgen.show.summary import scene_table

NOTEBOOK_DPI = 110  # of pictures in notebooks: letters as large as the text around them


@cache
def _all_pictures() -> dict[type[Tabular], Mapping[str, Callable[[Any], Figure]]]:
    """PICTURES_OF in the files *_pictures.py of this folder, together."""
    found: dict[type[Tabular], Mapping[str, Callable[[Any], Figure]]] = {}
    for file in iter_modules([str(Path(__file__).parent)]):
        if file.name.endswith("_pictures"):
            found |= getattr(import_module(f"rodgen.show.{file.name}"), "PICTURES_OF", {})
    return found


def pictures_of(kind: type[Tabular]) -> Mapping[str, Callable[[Any], Figure]]:
    """Pictures of a kind of result by name; the first is shown by default."""
    return _all_pictures().get(kind, {})


def plot(shown: Plottable, picture: str | None, figure: Figure | SubFigure | None) -> Axes:
    """Draw a picture of a result; returns the first axes. Raises InputError for an unknown name."""
    pictures = pictures_of(type(shown))
    return draw_picture({k: partial(draw, shown) for k, draw in pictures.items()}, picture, figure)


def draw_picture(
    pictures: Mapping[str, Callable[[], Figure]],
    picture: str | None,
    figure: Figure | SubFigure | None,
) -> Axes:
    """Draw a picture, by default the first; returns its first axes. Raises InputError."""
    name = next(iter(pictures), "") if picture is None else picture
    if name not in pictures:
        raise InputError("picture", picture, f"one of {', '.join(pictures) or 'none'}")
    from matplotlib import pyplot

    with draw_into(figure or pyplot.figure):
        return pictures[name]().axes[0]


def figure_of(shown: Tabular, picture: str | None = None) -> Figure:
    """Draw a picture of a result into a figure of its own, by default its first."""
    pictures = pictures_of(type(shown))
    return pictures[next(iter(pictures)) if picture is None else picture](shown)


def video(solution: Solution, **settings: Any) -> Video:
    """Make a film of a run; settings: those of `Solution.animate`."""
    return make_video(solution, **settings)


def html(shown: Result | Scene) -> str:
    """Return HTML: its first picture, where it can be drawn, its tables, and its notes."""
    draw = next(iter(pictures_of(type(shown)).values()), None)
    found = [scene_table(shown)] if isinstance(shown, Scene) else shown.tables()
    notes = () if isinstance(shown, Scene) else shown.notes
    return compose_html(repr(shown), draw and partial(draw, shown), found, notes)


def compose_html(
    words: str,
    draw: Callable[[], Figure] | None,
    tables: Iterable[ResultTable],
    notes: Iterable[Note],
) -> str:
    """Return HTML: a line, a picture if there is one that can be drawn, tables and notes."""
    parts = [f"<p>{escape(words)}</p>"]
    if draw is not None:
        with suppress(AnalysisError, InputError), rc_context(style):  # the tables say what there is
            parts.append(_image_html(draw(), words))
    parts += map(_table_html, tables)
    parts += (f"<p>{note.kind}: {escape(note.text)}</p>" for note in notes)
    return f"<div>{''.join(parts)}</div>"


def _image_html(figure: Figure, words: str) -> str:
    file = BytesIO()
    figure.savefig(file, format="png", dpi=NOTEBOOK_DPI)
    data = base64.b64encode(file.getvalue()).decode()
    return f'<img alt="{escape(words)}" src="data:image/png;base64,{data}">'


def _table_html(table: ResultTable) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in table.columns)
    rows = [f"<tr>{head}</tr>"] if any(table.columns) else []
    rows += [f"<tr>{''.join(f'<td>{escape(one)}</td>' for one in row)}</tr>" for row in table.rows]
    return f"<table>{''.join(rows)}</table>"
