"""What a study keeps: its texts and the variables that they fill."""

from __future__ import annotations

import re

import pytest

from rodgen import SceneError
from rodgen.studies.keep import variables
from rodgen.studies.specification import Study
from tests.studies.scenes import BECK, PENDULUM, scene

pytestmark = pytest.mark.compiler
VARY = {"loads.gravity.g": [9.0, 10.0]}
SECTION = "section(tip_y, where='tip_x', rising=0, from=1, most=7)"


def test_variables_of_a_run() -> None:
    """Each with its unit, and what is there of every point behind them."""

    def mine(solution: object) -> float:
        return 1.0

    keep = ["max(phi_2)", "time_of_max(tip_x)", "last(work_internal_damping)", "count(up)"]
    study = Study.of(scene(PENDULUM), VARY, keep=[*keep, SECTION, "peak(omega_0)", mine])
    found = {one.name: (one.dims, one.shape, one.dtype, one.units) for one in variables(study)}
    assert found == {
        "max(phi_2)": ((), (), "f8", "rad"),
        "time_of_max(tip_x)": ((), (), "f8", "s"),
        "last(work_internal_damping)": ((), (), "f8", "J"),
        "count(up)": ((), (), "i8", ""),
        SECTION: (("crossing",), (7,), "f8", "m"),
        f"{SECTION}.t": (("crossing",), (7,), "f8", "s"),
        "peak(omega_0).frequency": ((), (), "f8", "Hz"),
        "peak(omega_0).amplitude": ((), (), "f8", "rad/s"),
        "mine": ((), (), "f8", ""),
        "status": ((), (), "U8", ""),
        "message": ((), (), "U200", ""),
        "energy_error": ((), (), "f8", "J"),
        "seconds": ((), (), "f8", "s"),
    }


def test_sections_of_other_lengths_have_dimensions_of_their_own() -> None:
    other = "section(phi_0, where='omega_0', falling=0, most=9)"
    study = Study.of(scene(PENDULUM), VARY, keep=[SECTION, other])
    dims = {one.name: one.dims for one in variables(study)}
    assert (dims[SECTION], dims[other]) == (("crossing",), ("crossing_2",))


@pytest.mark.parametrize(
    ("keep", "said"),
    [
        ([], "what is kept of every run"),
        (["max(tip_x"], "a reduction of a run"),
        (["median(tip_x)"], "a reduction of a run"),
        (["max(phi_3)"], "phi_{}"),
        (["last(tip_x)", "count(down)"], "compute.keep[1] = 'count(down)'"),
        (["section(tip_y)"], "where = one of"),
        (["section(tip_y, where='tip_z', rising=0)"], "where = one of"),
        (["section(tip_y, where='tip_x')"], "rising="),
        (["section(tip_y, where='tip_x', rising=0, falling=0)"], "rising="),
        (["section(tip_y, where='tip_x', rising=zero)"], "a finite number in place of 'zero'"),
        (["section(tip_y, where='tip_x', rising=0, most=2.5)"], "most="),
        (["section(tip_y, where='tip_x', rising=0, from=2, to=1)"], "from <= to"),
        (["peak(tip_q)"], "phi_{}"),
        (["max(tip_x)", "max(tip_x)"], "each thing once"),
    ],
)
def test_what_cannot_be_kept_of_a_run(keep: list[str], said: str) -> None:
    with pytest.raises(SceneError, match=re.escape(said)):
        Study.of(scene(PENDULUM), VARY, keep=keep)


def test_variables_of_analyses() -> None:
    vary = {"loads.material_damping.time": [1e-4, 1e-2]}
    usual = Study.of(scene(BECK), vary, what="modes")
    found = {one.name: (one.dims, one.shape, one.dtype) for one in variables(usual)[:-4]}
    assert found == {
        "frequency": (("mode",), (4,), "f8"),
        "growth": (("mode",), (4,), "f8"),
        "stable": ((), (), "i8"),
    }
    asked = Study.of(scene(BECK), vary, what="modes", keep=["frequency(2)", "growth(3)"])
    assert [one.dims for one in variables(asked)[:2]] == [("mode",), ("mode_2",)]


@pytest.mark.parametrize(
    ("what", "keep", "options", "said"),
    [
        ("critical", ["max(phi_0)"], {}, "one of force, factor"),
        ("critical", ["force(2)"], {}, "one of force, factor"),
        ("modes", ["frequency(0)"], {}, "a whole number k"),
        ("static", ["tip_z"], {}, "one of tip_x"),
        ("critical", [], {"force": 3}, "compute.options.force"),
        ("modes", [], {"count": 3}, "compute.options.count"),
        ("run", ["last(tip_x)"], {"t": 3}, "compute.options"),
    ],
)
def test_what_cannot_be_kept_of_an_analysis(
    what: str, keep: list[str], options: dict[str, int], said: str
) -> None:
    vary = {"loads.material_damping.time": [1e-4, 1e-2]}
    with pytest.raises(SceneError, match=re.escape(said)):
        Study.of(scene(BECK), vary, what=what, keep=keep, options=options)
