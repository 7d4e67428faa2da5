"""Pictures that Datasets of branches, boundaries and studies draw of themselves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from matplotlib import pyplot
from matplotlib.axes import Axes

import rodgen
from rodgen.analyse.curves.files import read, save
from rodgen.scene import Scene, SceneError

SCENE = Scene.from_dict(
    {
        "name": "pressed",
        "rod": {
            "links": 3,
            "length": 1.0,
            "bending_stiffness": 1.0,
            "mass": 1.0,
            "boundary": "clamped",
        },
        "loads": {"tip": {"y": -1.0, "x": 0.01}},
    }
)


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    yield
    pyplot.close("all")


def branch() -> xarray.Dataset:
    return rodgen.continue_equilibria(SCENE, "loads.tip.y", (-1.0, -3.0))


def mode() -> xarray.Dataset:
    return rodgen.continue_mode(SCENE.replace({"loads.tip": None}), 1, 1e-3, step=0.5)


def study() -> xarray.Dataset:
    pytest.importorskip("zarr", reason="the extra study is not installed")
    vary = {"loads.tip.y": [-1.0, -1.5, -2.0]}
    return rodgen.study(SCENE, vary, what="modes", keep=["frequency"], workers=1)


@pytest.mark.parametrize("make", [branch, mode, study], ids=lambda one: one.__name__)
def test_datasets_draw_themselves(make: Callable[[], Any]) -> None:
    data = make()
    axes = data.rodgen.plot()
    assert isinstance(axes, Axes)
    assert axes.figure is pyplot.gcf()
    drawn = [line for line in axes.get_lines() if len(np.atleast_1d(line.get_xdata())) > 1]
    assert drawn
    with pytest.raises(SceneError, match=r"picture = 'none': must be one of \w+"):
        data.rodgen.plot("none")


def test_a_branch_in_a_file_is_drawn_as_it_was(tmp_path: Path) -> None:
    data = branch()
    save(data, tmp_path / "branch.nc")
    again = read(tmp_path / "branch.nc", "file", "a branch", data.attrs["format"])
    lines = [one.rodgen.plot().get_lines()[0].get_xydata() for one in (data, again)]
    assert np.array_equal(*lines)


def test_other_datasets_are_refused() -> None:
    branch()
    with pytest.raises(SceneError, match="formats rodgen branch 1"):
        xarray.Dataset().rodgen.plot()


def test_a_study_says_what_it_is() -> None:
    pytest.importorskip("zarr", reason="the extra study is not installed")
    made = rodgen.Study.of(
        SCENE, {"loads.tip.y": {"from": -1, "to": -2, "count": 5}}, keep="last(tip_x)"
    )
    assert repr(made) == "<Study pressed: run at 5 of loads.tip.y>"
    html = made._repr_html_()
    assert "<td>loads.tip.y</td><td>5 values</td><td>-1.0</td><td>-2.0</td>" in html
