"""What a study keeps: its texts and the variables that they fill."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rodgen.studies.kept_quantities import run_quantities, variables
from rodgen.studies.study import Study
from tests.studies.conftest import BECK, PENDULUM, scene
from tests.told import refused

pytestmark = pytest.mark.compiler
VARY = {"loads.gravity.g": [9.0, 10.0]}
SECTION = "section(tip_y, where='tip_x', rising=0, from=1, max_points=7)"


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
        "method": ((), (), "U16", ""),
        "status": ((), (), "U8", ""),
        "message": ((), (), "U200", ""),
        "doubts": ((), (), "i4", ""),
        "energy_error": ((), (), "f8", "J"),
        "seconds": ((), (), "f8", "s"),
    }


def test_functions_of_the_same_text_are_told_apart() -> None:
    """A function that is made in a loop holds another value each time."""

    def of(value: float) -> Callable[[object], float]:
        return lambda solution: value

    functions = [of(1.0), of(2.0)]
    studies = [Study.of(scene(PENDULUM), VARY, keep=one) for one in functions]
    found = [run_quantities(study)[0] for study in studies]
    assert [getattr(one, "function", None) for one in found] == functions


WHERE = "section(tip_y, where='tip_x'"
SUMS = ("total_work", "work_tip_load", "energy_balance")
NOT_KEPT: list[tuple[list[str], str]] = [
    ([], "compute.keep"),
    (["max(tip_x)", "max(tip_x)"], "compute.keep"),
    (["last(tip_x)", "count(down)"], "compute.keep[1]"),
    *(
        ([text], "compute.keep[0]")
        for text in (
            *("max(tip_x", "median(tip_x)", "max(phi_3)", "peak(tip_q)", "section(tip_y)"),
            *("section(tip_y, where='tip_z', rising=0)", f"{WHERE})"),
            *(f"{WHERE}, rising=0, falling=0)", f"{WHERE}, rising=zero)"),
            *(f"{WHERE}, rising=0, max_points=2.5)", f"{WHERE}, rising=0, from=2, to=1)"),
            # At a crossing there are the states alone, and no sums over a run.
            *(f"section({sum}, where='phi_0', rising=0)" for sum in SUMS),
        )
    ),
]


def test_variables_of_analyses() -> None:
    vary = {"loads.material_damping.time": [1e-4, 1e-2]}
    usual = Study.of(scene(BECK), vary, analysis="modes")
    found = {one.name: (one.dims, one.shape, one.dtype) for one in variables(usual)[:-5]}
    assert found == {
        "frequencies": (("mode",), (4,), "f8"),
        "growth": (("mode",), (4,), "f8"),
        "stable": ((), (), "i8"),
    }
    asked = Study.of(scene(BECK), vary, analysis="modes", keep=["frequencies(2)", "growth(3)"])
    assert [one.dims for one in variables(asked)[:2]] == [("mode",), ("mode_2",)]


NOT_KEPT_OF_ANALYSES: list[tuple[str, list[str], dict[str, int], str]] = [
    ("critical", ["max(phi_0)"], {}, "compute.keep[0]"),
    ("critical", ["value(2)"], {}, "compute.keep[0]"),
    ("modes", ["frequencies(0)"], {}, "compute.keep[0]"),
    ("static", ["tip_z"], {}, "compute.keep[0]"),
    ("critical", [], {"force": 3}, "compute.options.force"),
    ("modes", [], {"count": 3}, "compute.options.count"),
    ("run", ["last(tip_x)"], {"t": 3}, "compute.options"),
]


def test_what_cannot_be_kept() -> None:
    of_runs = [("run", keep, {}, field) for keep, field in NOT_KEPT]
    for what, keep, options, field in (*of_runs, *NOT_KEPT_OF_ANALYSES):
        told = refused(Study.of, scene(PENDULUM), VARY, analysis=what, keep=keep, options=options)
        assert told.field == field, (what, keep, options)
