"""Curves that Ctrl-C stops: what was found is kept, and gone on with it is the whole curve."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.curves import curve_datasets
from tests.analyse.rods import AXIAL, COLUMN, FORCE, ONES, rod
from tests.analyse.test_boundary import INTERNAL
from tests.sets import sets

Follow = Callable[..., Any]


def _equilibria(across: float = 0.3) -> tuple[Follow, str, str]:
    scene = rod(6, "clamped", {"tip": {"x": 0.0, "y": across}})
    follow = partial(rodgen.continue_equilibria, scene, AXIAL, (0.0, -20.0), step=0.1)
    return follow, "value", "phi"


def _boundary() -> tuple[Follow, str, str]:
    loads = {"follower": {"force": 2.0}, "internal_damping": {"coefficient": 0.18}}
    scene = rod(3, "cantilever", loads, inertia="lumped", **ONES)
    ends = ((0.0, 60.0), (0.0, 3.0))
    return partial(rodgen.stability_boundary, scene, (FORCE, INTERNAL), bounds=ends), "b", "a"


def _cycles() -> tuple[Follow, str, str]:
    follow = partial(rodgen.continue_cycles, COLUMN, FORCE, (18.0, 21.0), start="run")
    return follow, "value", "period"


def _stopped(follow: Follow, after: int, **given: Any) -> Any:
    """What there is when Ctrl-C comes with a point."""
    seen = 0

    def watch(value: Any) -> None:
        nonlocal seen
        seen += 1
        if seen == after:
            raise KeyboardInterrupt

    with pytest.raises(rodgen.BranchInterrupted) as caught:
        follow(callback=watch, **given)
    return caught.value.found


@pytest.mark.parametrize("kind", sets([_equilibria, _boundary], slow=[_cycles]))
def test_what_was_found_is_kept_and_gone_on_with(kind: Any, tmp_path: Path) -> None:
    follow, along, with_it = kind()
    whole = follow()
    part = _stopped(follow, 4)
    assert not part.attrs["complete"]
    assert part.sizes["point"] == 4
    curve_datasets.save_curve(part, tmp_path / "part.nc")
    read = curve_datasets.read_curve(
        tmp_path / "part.nc", "resume", "a curve", part.attrs["format"]
    )
    # Where it was followed both ways, the end that was reached is its first point.
    back = 0 if kind is not _equilibria else -1
    on = follow(resume=read, point=back)
    if back == 0:
        on = follow(resume=on, point=-1)
    assert on.attrs["complete"]
    assert (np.diff(on["length"].values) > 0).all()
    for name in (along, with_it):
        np.testing.assert_allclose(on[name].values[[0, -1]], whole[name].values[[0, -1]], rtol=1e-8)
    assert set(part[along].values.tolist()) <= set(on[along].values.tolist())


def test_ctrl_c_before_the_other_branch_leaves_the_first() -> None:
    follow, *_ = _equilibria(across=0.0)
    straight = _stopped(follow, 3, branch_point=1)
    assert straight.attrs["branch_point"] == 0
    assert np.abs(straight["phi"].values).max() == 0.0
    bent = _stopped(follow, 22, branch_point=1)
    assert bent.attrs["branch_point"] == 1
    assert np.abs(bent["phi"].values).max() > 0.1


def test_numbers_beyond_range_end_a_branch() -> None:
    """Whatever breaks in the middle, what was found before is there."""
    follow, *_ = _equilibria()
    seen = []

    def watch(value: float) -> None:
        seen.append(value)
        if len(seen) == 5:
            raise OverflowError("math range error")

    found = follow(callback=watch)
    assert found["value"].values.tolist() == pytest.approx(seen, rel=1e-12)
    assert "math range error" in found.attrs["end"]  # what was raised
    assert not found.attrs["complete"]


@pytest.mark.slow
def test_a_boundary_is_gone_on_with_through_a_corner() -> None:
    """From a point where it diverges, back to where it flutters, and from the limit of no damping
    nowhere."""
    loads = {"follower": {"force": 2.0}, "tip": {"x": 0.0, "y": 0.0}}
    scene = rod(3, "cantilever", loads, inertia="lumped", **ONES)
    keys, ends = (FORCE, AXIAL), ((-30.0, 30.0), (-30.0, 10.0))
    whole = rodgen.stability_boundary(scene, keys, bounds=ends)
    still = np.flatnonzero(whole["frequency"].values == 0.0)
    part = whole.isel(point=slice(int(still[-1]) - 8, int(still[-1]) - 3), special=slice(0))
    part = part.assign(length=part["length"] - part["length"][0])
    if float(part["a"][0]) > float(part["a"][-1]):
        part = part.isel(point=slice(None, None, -1))
    on = rodgen.stability_boundary(scene, keys, bounds=ends, resume=part)
    assert on["special_kind"].values.tolist() == ["zero frequency"]
    corner = [float(on[f"special_{name}"][0]) for name in ("a", "b")]
    exact = [float(whole[f"special_{name}"][0]) for name in ("a", "b")]
    assert corner == pytest.approx(exact, rel=1e-6)
    assert float(on["frequency"][-1]) > 0


def test_the_limit_of_no_damping_is_an_end() -> None:
    follow, *_ = _boundary()
    whole = follow()
    assert float(whole["b"][0]) == 0.0
    again = follow(resume=whole, point=0)
    assert again.sizes["point"] == whole.sizes["point"]
