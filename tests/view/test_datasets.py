"""Pictures that Datasets of branches, boundaries and studies draw of themselves."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import cache
from html import escape
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
from rodgen.shown import show_in_notebook
from tests.view.results import TABLE

SCENE = Scene.from_dict({**TABLE, "name": "pressed", "loads": {"tip": {"y": -1.0, "x": 0.01}}})


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    yield
    pyplot.close("all")


@cache
def branch() -> xarray.Dataset:
    return rodgen.continue_equilibria(SCENE, "loads.tip.y", (-1.0, -3.0))


def mode() -> xarray.Dataset:
    return rodgen.continue_mode(SCENE.replace({"loads.tip": None}), 1, 1e-3, step=0.5)


def study() -> xarray.Dataset:
    pytest.importorskip("zarr", reason="the extra study is not installed")
    vary = {"loads.tip.y": [-1.0, -1.5, -2.0]}
    return rodgen.study(SCENE, vary, what="modes", keep=["frequency"], workers=1)


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
    drawn = [line for line in axes.get_lines() if len(np.atleast_1d(line.get_xdata())) > 1]
    assert drawn
    with pytest.raises(SceneError, match=r"^picture = 'none'"):
        data.rodgen.plot("none")
    line, html = repr(data.rodgen), data.rodgen._repr_html_()
    assert re.fullmatch(rf"<.*pressed.*\b{len(data[next(iter(data.dims))])} .*>", line)
    assert f'<img alt="{escape(line)}"' in html
    assert "<td>" in html


@pytest.mark.nightly  # IPython comes with what builds the site
def test_notebooks_show_datasets_with_picture_and_table() -> None:
    shells = pytest.importorskip("IPython.core.interactiveshell", reason="IPython is not installed")
    data, shell = branch(), shells.InteractiveShell.instance()
    try:
        show_in_notebook(xarray.Dataset)
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
    save(data, tmp_path / "branch.nc")
    again = read(tmp_path / "branch.nc", "file", "a branch", data.attrs["format"])
    lines = [one.rodgen.plot().get_lines()[0].get_xydata() for one in (data, again)]
    assert np.array_equal(*lines)


def test_other_datasets_are_refused() -> None:
    branch()
    with pytest.raises(SceneError):
        xarray.Dataset().rodgen.plot()


def test_a_study_says_what_it_is() -> None:
    pytest.importorskip("zarr", reason="the extra study is not installed")
    vary = {"loads.tip.y": {"from": -1, "to": -2, "count": 5}}
    made = rodgen.Study.of(SCENE, vary, keep="last(tip_x)")
    assert re.fullmatch(r"<Study pressed: .*\b5 .*loads\.tip\.y>", repr(made))
    cells = re.findall(r"<td>([^<]*)</td>", made._repr_html_())
    assert {"loads.tip.y", "-1.0", "-2.0"} <= {*cells}
