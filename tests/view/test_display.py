"""What results and scenes show of themselves: a line, a picture, a table, a film."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Iterator
from functools import cache
from html import escape
from importlib.metadata import EntryPoints, entry_points
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from matplotlib import pyplot
from matplotlib.axes import Axes
from PIL import Image

import rodgen
from rodgen import display
from rodgen.analyse.curves.curve_datasets import read_curve, save_curve
from rodgen.dataset_result import register_notebook_display
from rodgen.display import Plottable, Tabular
from rodgen.errors import InputError
from rodgen.show.animation import film_files
from rodgen.show.appearance import _all_pictures, pictures_of
from tests.view.results import MAKERS, SCENE, made

# A number that the table of each has to have.
SHOWN: dict[str, Callable[[Any], str]] = {
    "Scene": lambda one: "30",
    "Solution": lambda one: f"{one.tip[-1, 0]:.6g}",
    "Modes": lambda one: f"{one.frequencies[0]:.10g}",
    "LinearModel": lambda one: f"{one.point[2]:.6g}",
    "Equilibrium": lambda one: f"{one.tip[1]:.12g}",
    "Critical": lambda one: f"{one.frequency:.12g}",
    "Cycle": lambda one: "0.2",
    "Exponents": lambda one: f"{one.exponents[0]:.6g}",
    "Floquet": lambda one: "0.2",
    "Spectrum": lambda one: f"{one.frequencies[0]:.10g}",
    "Extrapolation": lambda one: "2",
    "SimulatedCritical": lambda one: "2.5",
    "WorkPrecision": lambda one: "1.0e-08",
    "Study": lambda one: "2.5",
    "Description": lambda one: f"{one.mass:.9g}",
    "Ensemble": lambda one: f"{one['max(phi_2)'][0]:.6g}",
}
QUICKLY = ("Modes", "Spectrum")  # in next to no time
DRAWN = [name for name in SHOWN if issubclass(getattr(rodgen, name), Plottable)]
# What says itself in a line as it is: named tuples and descriptions, errors apart.
PLAIN = {"Event", "Note", "Result", "Structure", "System"}


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    yield
    pyplot.close("all")


def test_every_class_that_shows_itself_is_here() -> None:
    assert {kind.__name__ for kind in _all_pictures()} == set(DRAWN)
    assert set(SHOWN) == set(MAKERS)
    public = {name: getattr(rodgen, name) for name in rodgen.__all__}
    kinds = {name: one for name, one in public.items() if isinstance(one, type)}
    results = {name for name, one in kinds.items() if not issubclass(one, BaseException)}
    assert results - PLAIN == set(SHOWN)
    assert all(issubclass(kinds[name], Tabular) for name in SHOWN)


@pytest.mark.slow
def test_a_line_a_picture_and_a_table() -> None:
    for name, number in SHOWN.items():
        one = made(name)
        line = repr(one)
        assert line.startswith((f"<{name} ", f"<{name}:"))
        assert "swaying" in line or not hasattr(one, "scene")
        assert len(line) < 160
        assert "\n" not in line
        html = one._repr_html_()
        images = re.findall(r'<img alt="[^"]+" src="data:image/png;base64,([^"]+)">', html)
        assert len(images) == (name in DRAWN)
        for data in images:
            shown = np.asarray(Image.open(BytesIO(base64.b64decode(data))).convert("L"))
            assert np.ptp(shown) > 100  # of 255: it is not blank
        cells = " ".join(re.findall(r"<td[^>]*>([^<]*)</td>", html))
        assert number(one) in re.findall(r"[-+\w.]+(?<!\.)", cells), name
        assert pyplot.get_fignums() == []  # a notebook would show such a figure a second time


def test_notebooks_show_what_is_doubtful() -> None:
    unstable = rodgen.natural_modes(SCENE.replace({"loads.follower.force": 500.0}))
    assert unstable.doubts
    assert all(f"doubt: {escape(one.text)}" in unstable._repr_html_() for one in unstable.doubts)


# Those of one or two pictures are seen by the table above, too.
@pytest.mark.parametrize(
    "name", [n if n in QUICKLY else pytest.param(n, marks=pytest.mark.slow) for n in DRAWN]
)
def test_plots_are_those_of_pyplot_and_return_axes(name: str) -> None:
    one = made(name)
    axes = one.plot()
    assert isinstance(axes, Axes)
    assert axes.figure is pyplot.gcf()
    assert axes.has_data()
    figure = pyplot.figure(figsize=(8, 4), layout="constrained")
    left, right = figure.subfigures(1, 2)
    for picture, part in zip(pictures_of(type(one)), (left, right), strict=False):
        assert one.plot(picture, figure=part).figure is part
    assert tuple(figure.get_size_inches()) == (8, 4)
    with pytest.raises(InputError, match=r"^picture = 'none'"):
        one.plot("none")


def test_what_draws_is_looked_up_once_and_not_before(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[dict[str, str]] = []

    def looked_up(**group: str) -> EntryPoints:
        asked.append(group)
        return entry_points(**group)

    monkeypatch.setattr(display, "entry_points", looked_up)
    display.load_drawing_module.cache_clear()
    modes = made("Modes")
    assert repr(modes)
    assert asked == []
    assert modes.plot().has_data()
    assert modes._repr_html_()
    assert asked == [{"group": "rodgen.pictures", "name": "results"}]


def test_an_installation_without_pictures_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(display, "entry_points", lambda **_: EntryPoints(()))
    display.load_drawing_module.cache_clear()
    for draw in (made("Modes").plot, made("Modes")._repr_html_):
        with pytest.raises(ImportError, match=re.escape("rodgen.pictures")):
            draw()


def test_what_has_no_table_is_a_line() -> None:
    event = made("Solution").events[0]
    assert f"t = {event.t:g} s" in repr(event)
    assert len(repr(event)) < 160
    structure = rodgen.Structure(2, "pinned", terms=("gravity",))
    assert eval(repr(structure), {"Structure": rodgen.Structure}) == structure
    assert "nonuniform" not in repr(structure)


def test_what_cannot_be_drawn_is_still_told() -> None:
    """A run without a sample has no picture; text is escaped."""
    empty = made("Solution").head(0)
    empty.message = "<stopped>"
    html = empty._repr_html_()
    assert "<img" not in html
    assert "&lt;stopped&gt;" in html
    assert "<stopped>" not in html


def test_a_table_of_pandas_has_a_row_a_sample() -> None:
    """Against xarray, where every number has the same name with its coordinates; an added state is
    one of them."""
    scene = SCENE.replace({"states.lag": {"rate": "phi(1) - lag"}})
    run = rodgen.simulate(scene, span=(0.0, 0.1), target="numpy")
    frame, data = run.to_pandas(), run.to_xarray()
    assert frame.index.name == "t"
    assert np.array_equal(frame.index, data["time"])
    assert frame.shape[0] == data.sizes["time"]
    assert frame.columns.is_unique
    pairs = {
        "phi_2": data["phi"].sel(link=2),
        "joint_3_y": data["joints"].sel(joint=3, axis="y"),
        "force_follower_3_x": data["force_follower"].sel(joint=3, axis="x"),
        "work_follower": data["work_follower"],
        "tip_x": data["tip"].sel(axis="x"),
        "principal_moment_2": data["principal_moments"].sel(principal="larger"),
    }
    for name, values in pairs.items():
        assert np.array_equal(frame[name], values), name
        assert frame.attrs["units"][name].replace("^", "") == values.attrs["units"]
    assert np.array_equal(frame["lag"], run.y[:, -1])
    assert set(frame.attrs["units"]) == {"t", *frame.columns}


@pytest.mark.parametrize("ending", [".gif", pytest.param(".mp4", marks=pytest.mark.slow)])
def test_a_film_for_a_notebook(
    ending: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if ending == ".gif":
        monkeypatch.setattr("rodgen.show.animation.film.find_ffmpeg", lambda: None)
    elif film_files.find_ffmpeg() is None:
        pytest.skip("no ffmpeg")
    video: Any = made("Solution").animate(fps=10, width=320, height=320)
    assert video.ending == ending
    assert repr(video).startswith(f"<Video {ending}: ")
    start = video.data[:12]
    assert start.startswith(b"GIF89a") if ending == ".gif" else start[4:8] == b"ftyp"
    tag = "<img " if ending == ".gif" else "<video "
    html = video._repr_html_()
    assert html.startswith(tag)
    assert base64.b64encode(video.data).decode() in html
    path = tmp_path / f"film{ending}"
    video.save(path)
    assert path.read_bytes() == video.data
    with pytest.raises(InputError, match=re.escape(ending)):
        video.save(tmp_path / "film.avi")
    assert [one.name for one in tmp_path.iterdir()] == [path.name]


# Datasets of branches and studies ----------------------------------------------------------------

PRESSED = SCENE.replace({"name": "pressed", "loads": {"tip": {"y": -1.0, "x": 0.01}}})


@cache
def branch() -> xarray.Dataset:
    return rodgen.continue_equilibria(PRESSED, "loads.tip.y", (-1.0, -3.0))


def mode() -> xarray.Dataset:
    return rodgen.continue_mode(PRESSED.replace({"loads.tip": None}), 1, 1e-3, step=0.5)


def study() -> xarray.Dataset:
    pytest.importorskip("zarr", reason="the extra study is not installed")
    vary = {"loads.tip.y": [-1.0, -1.5, -2.0]}
    return rodgen.study(PRESSED, vary, analysis="modes", keep=["frequencies"], workers=1)


@pytest.mark.parametrize(
    "make",
    [branch, *(pytest.param(one, marks=pytest.mark.slow) for one in (mode, study))],
    ids=lambda one: one.__name__,
)
def test_datasets_draw_themselves(make: Callable[[], Any]) -> None:
    data = make()
    axes = data.rodgen.plot()
    assert isinstance(axes, Axes)
    assert axes.figure is pyplot.gcf()
    assert any(len(np.atleast_1d(line.get_xdata())) > 1 for line in axes.get_lines())
    with pytest.raises(InputError, match=r"^picture = 'none'"):
        data.rodgen.plot("none")
    with pytest.raises(InputError):
        xarray.Dataset().rodgen.plot()
    line, html = repr(data.rodgen), data.rodgen._repr_html_()
    assert re.fullmatch(rf"<.*pressed.*\b{len(data[next(iter(data.dims))])} .*>", line)
    assert f'<img alt="{escape(line)}"' in html
    assert "<td>" in html


@pytest.mark.nightly  # IPython comes with what builds the site
def test_notebooks_show_datasets_with_picture_and_table() -> None:
    shells = pytest.importorskip("IPython.core.interactiveshell", reason="IPython is not installed")
    data, shell = branch(), shells.InteractiveShell.instance()
    try:
        register_notebook_display(xarray.Dataset)
        whole, part, other = (
            shell.display_formatter.format(one)[0]["text/html"]
            for one in (data, data[["value"]], xarray.Dataset())
        )
    finally:
        shells.InteractiveShell.clear_instance()
    assert "<img" in whole
    assert str(data.sizes["point"]) in re.findall(r"\d+", whole.rpartition("<img")[2])
    for html in (part, other):
        assert "<img" not in html
        assert "xarray.Dataset" in html


def test_a_branch_in_a_file_is_drawn_as_it_was(tmp_path: Path) -> None:
    data = branch()
    save_curve(data, tmp_path / "branch.nc")
    again = read_curve(tmp_path / "branch.nc", "file", "a branch", data.attrs["format"])
    lines = [one.rodgen.plot().get_lines()[0].get_xydata() for one in (data, again)]
    assert np.array_equal(*lines)
