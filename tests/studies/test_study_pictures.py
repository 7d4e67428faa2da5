"""Pictures of studies: one for everything that is kept, of any number of axes."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure

from rodgen.show import study_maps, study_pictures, study_results
from rodgen.show.picture_settings import PictureSettings
from rodgen.show.study_results import StudyResults
from rodgen.show.style import style

SECTION = "section(tip_y, where='tip_x', rising=0)"
AXES = {
    "rod.length": np.geomspace(0.1, 10.0, 6),
    "loads.follower.force": np.linspace(0.0, 1.0, 5),
    "rod.links": np.array([5, 10, 20]),
    "rod.mass": np.array([1.0, 2.0]),
}


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of few dots, which take no time."""
    monkeypatch.setitem(style, "savefig.dpi", 40)


def dataset(names: tuple[str, ...], **more: Any) -> xarray.Dataset:
    """Results over some axes, of which one point failed."""
    shape = tuple(len(AXES[name]) for name in names)
    values = np.arange(np.prod(shape), dtype=float).reshape(shape)
    status = np.full(shape, "finished", dtype=object)
    status.flat[1] = "failed"
    values.flat[1] = np.nan
    data = {
        "last(tip_x)": (names, values, {"units": "m"}),
        "stable": (names, np.where(values > 2, 1, 0)),
        "kind": (names, np.where(values > 2, "flutter", "divergence").astype(object)),
        "frequencies(2)": ((*names, "mode"), np.stack([values, 2 * values], axis=-1)),
        SECTION: ((*names, "crossing"), np.stack([values, -values], axis=-1)),
        f"{SECTION}.t": ((*names, "crossing"), np.stack([values, values + 1], axis=-1)),
        "status": (names, status),
    }
    coords = {name: AXES[name] for name in names}
    return xarray.Dataset(data, coords, attrs={"name": "study"}).assign(more)


@pytest.mark.slow
def test_pictures_of_a_grid(tmp_path: Path) -> None:
    """Of one axis to four; text is as stores have it, of any length."""
    of_three = {"last_tip_x", "stable", "kind"}
    of_two = of_three | {"section_tip_y_where_tip_x_rising_0"}
    for count, expected in enumerate(
        (of_two | {"frequencies_2"}, of_two, of_three, {"scatter"}), 1
    ):
        data = dataset(tuple(AXES)[:count])
        text = {one: data[one].astype(np.dtypes.StringDType()) for one in ("status", "kind")}
        made = study_pictures.save_study_pictures(data.assign(text), tmp_path, PictureSettings())
        assert {path.stem for path in made} == expected
        assert all(path.read_bytes().startswith(b"\x89PNG") for path in made)


def test_of_too_many_points_some_are_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every fourth along the longer axis, and which share that is."""
    names = tuple(AXES)[1:3]
    whole = dataset(names)
    assert StudyResults.subsample(whole).dataset is whole
    monkeypatch.setattr(study_results, "MOST_SHOWN", 6)
    shown = StudyResults.subsample(whole)
    assert shown.status.shape == (2, 3)
    assert (shown.one_of, shown.title) == (4, "study")
    np.testing.assert_array_equal(shown.dataset["last(tip_x)"], whole["last(tip_x)"].values[::4])
    np.testing.assert_array_equal(shown.dataset[names[0]], AXES[names[0]][::4])


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_pictures_say_which_share_they_show(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, count: int
) -> None:
    """Also in vectors, which have no title; and only where it is not all."""
    data = dataset(tuple(AXES)[:count])[["last(tip_x)", "status"]]
    for most in (data["status"].size, 5):
        monkeypatch.setattr(study_results, "MOST_SHOWN", most)
        made = study_pictures.save_study_pictures(data, tmp_path, PictureSettings("svg"))
        share = StudyResults.subsample(data).share
        assert bool(share) == (most == 5)
        for picture in made:
            assert re.findall(r"one point of \d+", picture.read_text()) == [share] * bool(share)


def test_a_sample_is_a_scatter_matrix(tmp_path: Path) -> None:
    count = 30
    x, status = np.linspace(1, 2, count), np.full(count, "finished")
    data = {"max(phi_0)": ("point", x**2), "status": ("point", status)}
    coords = {"rod.length": ("point", x), "rod.mass": ("point", x[::-1])}
    results = xarray.Dataset(data, coords)
    (made,) = study_pictures.save_study_pictures(results, tmp_path, PictureSettings())
    assert made.name == "scatter.png"


def of_lines(figure: Figure, marker: str) -> np.ndarray:
    """Points of the lines that have a marker, (points, 2)."""
    lines = [line for axes in figure.axes for line in axes.lines if line.get_marker() == marker]
    return np.concatenate([np.column_stack(line.get_data()) for line in lines])


def test_what_is_drawn_is_what_there_is() -> None:
    """The curve without the failed point, and that one as a cross; all crossings."""
    of = StudyResults(dataset(("rod.length",)))
    figure = study_pictures.curve_plot(of, "last(tip_x)")
    drawn = of_lines(figure, ".")
    np.testing.assert_allclose(drawn[:, 0], AXES["rod.length"])
    np.testing.assert_array_equal(drawn[:, 1], [0, np.nan, 2, 3, 4, 5])
    np.testing.assert_allclose(of_lines(figure, "x")[:, 0], AXES["rod.length"][1])
    assert figure.axes[0].get_xscale() == "log"
    assert figure.axes[0].get_ylabel() == "last(tip_x) [m]"
    points = of_lines(study_pictures.bifurcation_plot(of, SECTION), ".")
    assert sorted(points[:, 1]) == [-5, -4, -3, -2, 0, 0, 2, 3, 4, 5]


def test_a_map_shows_the_points_that_were_computed() -> None:
    """Where not all are; the rest has the colour of the nearest."""
    names = tuple(AXES)[:2]
    data = dataset(names)
    status = np.full((6, 5), "", dtype=object)
    status[::2, ::2] = "finished"
    figure = study_maps.map_plot(StudyResults(data.assign(status=(names, status))), "stable")
    drawn = of_lines(figure, ".")
    assert len(drawn) == 9
    assert {*drawn[:, 0]} == {0.0, 0.5, 1.0}
    assert np.isfinite(np.ma.filled(figure.axes[0].collections[0].get_array(), np.nan)).all()
    texts = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    texts += [text.get_text() for text in figure.axes[0].texts]
    assert sorted(texts) == ["computed points", "stable", "unstable"]  # a name stands once


def test_periods_of_sections_are_told_apart() -> None:
    """Of made up motions: at rest, of period 1 with a noise of rounding, 3, and one that never
    repeats itself; beside them a value far outside, which does not change the range."""
    rng = np.random.default_rng(1)
    values = np.full((2, 3, 600), np.nan)
    values[0, 1] = 0.3 + 1e-9 * rng.normal(size=600)
    values[0, 2] = np.tile([0.0, 0.5, 1.0], 200)
    values[1, 0] = rng.random(600)
    values[1, 1, :4] = [0.2, 0.2004, 0.7, 0.2002]
    values[1, 2, 0] = 1e6
    found = study_maps.count_distinct(values)
    assert found[0].tolist() == [0, 1, 3]
    assert found[1, 0] > 100
    assert found[1, 1:].tolist() == [2, 1]
    assert study_maps.count_distinct(np.full((2, 3), np.nan)).tolist() == [0, 0]
