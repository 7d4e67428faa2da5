"""What results and scenes show of themselves: a line, a picture, a picture with a table, a film."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterator
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.axes import Axes
from PIL import Image

import rodgen
from rodgen.scene import Scene, SceneError
from rodgen.show.animation import files
from rodgen.show.appearance import LOOKS
from rodgen.shown import Shown, Told

# A clamped rod that sways: every analysis has something to say of it.
SCENE = Scene.from_dict(
    {
        "name": "swaying",
        "rod": {
            "links": 3,
            "length": 2.0,
            "bending_stiffness": 30.0,
            "mass": 3.0,
            "boundary": "clamped",
        },
        "loads": {"follower": {"force": 4.0}, "gravity": {}},
        "initial": {"phi": 0.1},
        "events": [{"quantity": "phi_2", "value": 0.0}],
        "integrate": {"span": [0.0, 0.5], "output_every": 0.05},
    }
)


@cache
def solution() -> rodgen.Solution:
    return rodgen.simulate(SCENE)


def cycle() -> rodgen.Cycle:
    y0 = SCENE.initial_state()
    mu = np.full(len(y0), 0.5 + 0j)
    return rodgen.Cycle(
        SCENE, 0.0, 0.2, y0, mu, 0, 0.0, 0.0, 0.5, 0.1, False, 1e-12, 4, "collocation"
    )


TRUSTED = {"error_phi": 1e-9}


def _setting(error: float) -> dict[str, Any]:
    """A setting of a method that took the longer, the less its error."""
    named = {"who": "rodgen", "method": "rk4", "target": "c", "kind": "step", "failed": ""}
    return named | {"setting": error**0.25, "seconds": 1e-8 / error, "error_phi": error}


# How to come by one of every class that shows itself, and a number that its table has to have.
SHOWN: dict[str, tuple[Any, Any]] = {
    "Scene": (lambda: SCENE, lambda one: "30 N m^2"),
    "Solution": (solution, lambda one: f"{one.tip[-1, 0]:.6g}"),
    "Modes": (lambda: rodgen.natural_modes(SCENE), lambda one: f"{one.frequencies[0]:.10g}"),
    "Equilibrium": (
        lambda: rodgen.static_equilibrium(SCENE),
        lambda one: f"{one.tip[1]:.12g}",
    ),
    "Critical": (lambda: rodgen.critical_force(SCENE), lambda one: f"{one.frequency:.12g}"),
    "Cycle": (cycle, lambda one: "0.2 s"),
    "Exponents": (
        lambda: rodgen.lyapunov_exponents(SCENE, count=2),
        lambda one: f"{one.exponents[0]:.6g}",
    ),
    "Floquet": (
        lambda: rodgen.Floquet(np.array([0.5 + 0j]), 0.2, np.zeros(6), 1e-9, 1e-12, (0,)),
        lambda one: "0.2 s",
    ),
    "Spectrum": (
        lambda: rodgen.spectrum(
            rodgen.simulate(SCENE, span=(0.0, 4.0), output_every=0.005), peaks=1
        ),
        lambda one: f"{one.frequencies[0]:.10g}",
    ),
    "Extrapolation": (
        lambda: rodgen.richardson([4, 8, 16], [1 + 1 / 16, 1 + 1 / 64, 1 + 1 / 256]),
        lambda one: "<td>2</td>",
    ),
    "SimulatedCritical": (
        lambda: rodgen.SimulatedCritical(2.5, 2.0, 3.0, 10.0, None, 7, 0.1, "c"),
        lambda one: "2.5 N",
    ),
    "WorkPrecision": (
        lambda: rodgen.WorkPrecision(SCENE, [_setting(1e-6), _setting(1e-8)], {}, TRUSTED, {}),
        lambda one: "1.00e-08",
    ),
    "Study": (
        lambda: rodgen.Study.of(SCENE, {"loads.follower.force": [1.0, 2.5]}, what="modes"),
        lambda one: "2.5",
    ),
    "Ensemble": (
        lambda: rodgen.simulate_many(
            rodgen.build(SCENE),
            rodgen.build(SCENE).parameters(**SCENE.parameters),
            SCENE.initial_state(),
            keep="max(phi_2)",
            span=(0.0, 0.1),
        ),
        lambda one: f"{one['max(phi_2)'][0]:.6g}",
    ),
}
DRAWN = [name for name in SHOWN if issubclass(getattr(rodgen, name), Shown)]
# What says itself in a line as it is: named tuples and descriptions, errors apart.
PLAIN = {"Event", "Structure"}


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    yield
    pyplot.close("all")


def test_every_class_that_shows_itself_is_here() -> None:
    assert {kind.__name__ for kind in LOOKS} == set(SHOWN)
    public = {name: getattr(rodgen, name) for name in rodgen.__all__}
    kinds = {name: one for name, one in public.items() if isinstance(one, type)}
    results = {name for name, one in kinds.items() if not issubclass(one, BaseException)}
    assert results - PLAIN == set(SHOWN)
    assert all(issubclass(kinds[name], Told) for name in SHOWN)


@pytest.mark.parametrize("name", SHOWN)
def test_a_line_a_picture_and_a_table(name: str) -> None:
    make, number = SHOWN[name]
    one = make()
    line = repr(one)
    assert line.startswith((f"<{name} ", f"<{name}:"))
    assert "swaying" in line or not hasattr(one, "scene")
    assert len(line) < 160
    assert "\n" not in line
    html = one._repr_html_()
    images = re.findall(r'<img alt="[^"]+" src="data:image/png;base64,([^"]+)">', html)
    assert len(images) == (name in DRAWN)
    for data in images:
        assert _ink(Image.open(BytesIO(base64.b64decode(data)))) > 100
    assert number(one) in html
    assert pyplot.get_fignums() == []  # a notebook would show such a figure a second time


@pytest.mark.parametrize("name", DRAWN)
def test_plots_are_those_of_pyplot_and_return_axes(name: str) -> None:
    one = SHOWN[name][0]()
    axes = one.plot()
    assert isinstance(axes, Axes)
    assert axes.figure is pyplot.gcf()
    assert axes.has_data()
    figure = pyplot.figure(figsize=(8, 4), layout="constrained")
    left, right = figure.subfigures(1, 2)
    for picture, part in zip(LOOKS[type(one)].pictures, (left, right), strict=False):
        assert one.plot(picture, figure=part).figure is part
    assert tuple(figure.get_size_inches()) == (8, 4)
    with pytest.raises(SceneError, match=r"picture = 'none': must be one of \w+"):
        one.plot("none")


def test_what_has_no_table_is_a_line() -> None:
    event = solution().events[0]
    assert f"t = {event.t:g} s" in repr(event)
    assert len(repr(event)) < 160
    structure = rodgen.Structure(2, "pinned", terms=("gravity",))
    assert eval(repr(structure), {"Structure": rodgen.Structure}) == structure
    assert "uneven" not in repr(structure)


def _ink(image: Image.Image) -> int:
    """Pixels that are not white."""
    return int((np.asarray(image.convert("L")) < 200).sum())


def test_what_cannot_be_drawn_is_still_told() -> None:
    """A run without a sample has no picture; text is escaped."""
    empty = solution().until(0)
    empty.message = "<stopped>"
    html = empty._repr_html_()
    assert "<img" not in html
    assert "&lt;stopped&gt;" in html
    assert "<stopped>" not in html


def test_a_table_of_pandas_has_a_row_a_sample() -> None:
    """Against xarray, where every number has the same name with its coordinates."""
    frame, data = solution().to_pandas(), solution().to_xarray()
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
    assert set(frame.attrs["units"]) == {"t", *frame.columns}


def test_added_states_have_columns() -> None:
    scene = SCENE.replace({"states.lag": {"rate": "phi(1) - lag"}})
    run = rodgen.simulate(scene, span=(0.0, 0.1), target="numpy")
    assert np.array_equal(run.to_pandas()["lag"], run.y[:, -1])


@pytest.mark.parametrize("ending", [".gif", ".mp4"])
def test_a_film_for_a_notebook(
    ending: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if ending == ".gif":
        monkeypatch.setattr("rodgen.show.animation.video.ffmpeg", lambda: None)
    elif files.ffmpeg() is None:
        pytest.skip("no ffmpeg")
    video: Any = solution().animate(fps=10, width=320, height=320)
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
    with pytest.raises(SceneError, match=rf"a file that ends in {ending}"):
        video.save(tmp_path / "film.avi")
    assert [one.name for one in tmp_path.iterdir()] == [path.name]
