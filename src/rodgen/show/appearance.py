"""Pictures and tables of every kind of result and of scenes, for `rodgen.display`."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from html import escape
from io import BytesIO
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from rodgen.analyse.chaos.lyapunov import Exponents
from rodgen.analyse.critical import Critical
from rodgen.analyse.cycles.cycle_result import Cycle
from rodgen.analyse.cycles.floquet import Floquet
from rodgen.analyse.load_family import load_family
from rodgen.analyse.modes import Modes
from rodgen.analyse.precision.work_precision import WorkPrecision
from rodgen.analyse.spectrum import Spectrum
from rodgen.analyse.statics import Equilibrium
from rodgen.analyse.steady_rod import SteadyRod
from rodgen.display import Plottable, Tabular
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate import Solution
from rodgen.result import Note, Result, ResultTable
from rodgen.scene import Scene
from rodgen.show.analysis_pictures import equilibrium_shape, mode_shapes, stability_curves
from rodgen.show.animation.frame_times import FilmSettings
from rodgen.show.animation.video import Video, make_video
from rodgen.show.canvas import draw_into
from rodgen.show.cycle_pictures import film_strip, multiplier_plane, unit_circle
from rodgen.show.exponent_pictures import convergence
from rodgen.show.precision_pictures import work_precision
from rodgen.show.run_pictures import PICTURES, drawable_part
from rodgen.show.scene_picture import scene_at_start
from rodgen.show.spectrum_picture import spectral_density
from rodgen.show.summary import scene_table

DOTS_PER_INCH = 80  # of pictures in notebooks


def _restrict_to_drawable(draw: Callable[[Solution], Figure]) -> Callable[[Solution], Figure]:
    """Limit a picture to what can be drawn of a run. It raises InputError where that is nothing."""

    def draw_part(solution: Solution) -> Figure:
        shown = drawable_part(solution)
        if not len(shown.t):
            raise InputError("solution", solution, "a run with samples that can be drawn")
        return draw(shown)

    return draw_part


def _draw_equilibrium(rest: Equilibrium) -> Figure:
    return equilibrium_shape(rest, SteadyRod.of(rest.scene, rest.t))


def _draw_critical(found: Critical) -> Figure:
    scene = found.scene
    speed = found.speed if scene.boundary_condition.translates else None
    return stability_curves(found, load_family(scene, found.t, speed, load=found.load))


def _draw_work_precision(found: WorkPrecision) -> Figure:
    drawn = work_precision(found.rows, found.measure, found.trusted[found.measure] or 0.0)
    if drawn is None:
        raise InputError("rows", len(found.rows), "at least one that can be drawn")
    return drawn


# By name, of each kind of result; the first is shown by default.
PICTURES_OF: dict[type[Tabular], Mapping[str, Callable[[Any], Figure]]] = {
    Scene: {"start": scene_at_start},
    Solution: {name: _restrict_to_drawable(draw) for name, draw in PICTURES.items()},
    Modes: {"shapes": lambda found: mode_shapes(found, found.scene)},
    Equilibrium: {"shape": _draw_equilibrium},
    Critical: {"curves": _draw_critical},
    Cycle: {"film": film_strip, "multipliers": unit_circle},
    Exponents: {"means": lambda found: convergence(found, found.scene.name)},
    Floquet: {"multipliers": lambda found: multiplier_plane(found.multipliers, "periodic motion")},
    Spectrum: {"density": spectral_density},
    WorkPrecision: {"diagram": _draw_work_precision},
}


def plot(shown: Plottable, picture: str | None, figure: Figure | SubFigure | None) -> Axes:
    """Draw a picture of a result; returns the first axes. Raises InputError for an unknown name."""
    pictures = PICTURES_OF[type(shown)]
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
    pictures = PICTURES_OF[type(shown)]
    return pictures[next(iter(pictures)) if picture is None else picture](shown)


def video(solution: Solution, **settings: Any) -> Video:
    """Make a film of a run; settings: those of `Solution.animate`."""
    return make_video(solution, FilmSettings(**settings))


def html(shown: Result | Scene) -> str:
    """Return HTML: its first picture, where it can be drawn, its tables, and its notes."""
    draw = next(iter(PICTURES_OF.get(type(shown), {}).values()), None)
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
        with suppress(AnalysisError, InputError):  # the tables say what there is
            parts.append(_image_html(draw(), words))
    parts += map(_table_html, tables)
    parts += (f"<p>{note.kind}: {escape(note.text)}</p>" for note in notes)
    return f"<div>{''.join(parts)}</div>"


def _image_html(figure: Figure, words: str) -> str:
    file = BytesIO()
    figure.savefig(file, format="png", dpi=DOTS_PER_INCH)
    data = base64.b64encode(file.getvalue()).decode()
    return f'<img alt="{escape(words)}" src="data:image/png;base64,{data}">'


def _table_html(table: ResultTable) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in table.columns)
    rows = [f"<tr>{head}</tr>"] if any(table.columns) else []
    rows += [f"<tr>{''.join(f'<td>{escape(one)}</td>' for one in row)}</tr>" for row in table.rows]
    return f"<table>{''.join(rows)}</table>"
