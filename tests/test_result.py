"""Results: rows in words and as plain data, and doubts that are told once."""

from __future__ import annotations

import json
import math
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.files.reader import load
from rodgen.result import (
    Note,
    Result,
    Row,
    collect_doubts,
    doubt,
    omit_from_tables,
    plain_data,
    warns_of_doubts,
)
from tests.analyse.rods import COLUMN, ZIEGLER, rod

TURNED = COLUMN.replace({"loads.follower.angle": 30.0, "integrate.span": [0.0, 0.1]})


@dataclass
class Numbers(Result):
    """One of each kind of row."""

    size: float = 2.5
    unit: str = "N"
    apart: float = math.nan
    ways: tuple[float, ...] = (1.0, 2.0)
    grows: tuple[bool, ...] = (True, False)
    of: Any = None
    notes: tuple[Note, ...] = ()

    ROWS = (
        Row("size", "size", "{unit}", ".2f"),
        Row("apart", "distance", "m", text=omit_from_tables),
        Row("of", "part {}", "kg", ".1f", of=lambda _: {"a": 1.0, "b": 2.0}),
        Row("ways", "way", "m", along="way"),
        Row("grows", "grows", along="way"),
    )


def test_rows_are_lines_and_columns() -> None:
    values, columns = Numbers().tables()
    assert values.rows == (("size", "2.50 N"), ("part a", "1.0 kg"), ("part b", "2.0 kg"))
    assert columns.columns == ("", "way [m]", "grows")
    assert columns.rows == (("1", "1", "yes"), ("2", "2", "no"))


def test_plain_data_has_neither_infinities_nor_classes() -> None:
    found = Numbers(notes=(doubt("why", size=math.inf),)).to_dict()
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert (found["apart"], found["ways"], found["of"]) == (None, [1.0, 2.0], {"a": 1.0, "b": 2.0})
    assert found["notes"] == [{"kind": "doubt", "text": "why", "figures": {"size": None}}]
    values = [np.float32(0.5), np.int64(3), np.array([1 + 2j]), np.bool_(True), (None, "x")]
    assert plain_data(values) == [0.5, 3, [[1.0, 2.0]], True, [None, "x"]]


def _told(call: Any) -> list[warnings.WarningMessage]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", rodgen.DoubtWarning)
        call()
    return [one for one in caught if one.category is rodgen.DoubtWarning]


def test_a_doubt_is_told_once_by_the_call_that_is_made_and_where_it_is_made() -> None:
    """Not by what that calls, nor twice where several results have it."""
    why = doubt("why", size=3.0)

    @warns_of_doubts
    def inner() -> list[Numbers]:
        return [Numbers(notes=(why,)), Numbers(notes=(why, doubt("else")))]

    @warns_of_doubts
    def outer() -> Numbers:
        inner()
        return Numbers(notes=(why, Note("remark", "nothing")))

    assert [str(one.message) for one in _told(inner)] == ["why", "else"]
    (told,) = _told(outer)
    assert (str(told.message), told.filename) == ("why", __file__)
    message = told.message
    assert isinstance(message, rodgen.DoubtWarning)
    assert message.figures == {"size": 3.0}
    with collect_doubts():
        assert _told(outer) == []
    with warnings.catch_warnings():
        warnings.simplefilter("error", rodgen.DoubtWarning)
        with pytest.raises(rodgen.DoubtWarning):
            outer()
    assert len(_told(outer)) == 1  # also after one that was an error


@pytest.mark.compiler
def test_doubts_of_a_run_are_told_before_it_and_kept_in_its_file(tmp_path: Path) -> None:
    """Also where a run fails, and with the growth of errors, which a file does not keep."""
    (told,) = _told(lambda: rodgen.simulate(TURNED, progress=False))
    assert told.filename == __file__
    file = tmp_path / "run.nc"
    with pytest.warns(rodgen.DoubtWarning, match="turns"):
        run = rodgen.simulate(TURNED, out=file, progress=False)
    (note,) = run.doubts
    assert note.figures["turns"] == pytest.approx(30 / (2 * math.pi))
    assert load(file).notes == run.notes == (note,)
    again = tmp_path / "again.nc"
    run.save(again)
    assert load(again).notes == run.notes
    assert json.loads(run.to_xarray().attrs["notes"]) == [note.to_dict()]
    with pytest.warns(rodgen.DoubtWarning), pytest.raises(rodgen.RunError) as stopped:
        rodgen.simulate(TURNED, max_steps=1, progress=False)
    assert stopped.value.solution.notes == (note,)
    with pytest.warns(rodgen.DoubtWarning) as both:
        fell = rodgen.simulate(
            rodgen.Scene.example("falling_chain"), span=(0, 3), error_growth=True, progress=False
        )
    assert [str(one.message) for one in both] == [str(fell.doubts[-1])]
    assert fell.doubts[-1].figures["factor"] == fell.error_growth


@pytest.mark.compiler
def test_a_run_that_goes_on_tells_its_doubts_again(tmp_path: Path) -> None:
    def stop(_: float) -> None:
        raise KeyboardInterrupt

    file, swings = tmp_path / "run.nc", rod(2, "pinned", {"gravity": {}}, initial={"phi": 30.0})
    with pytest.warns(rodgen.DoubtWarning), pytest.raises(rodgen.Interrupted) as stopped:
        rodgen.simulate(swings, span=(0, 1e6), out=file, progress=stop, output_every=1e3)
    due = stopped.value.solution.doubts
    again: list[Any] = []

    def go_on() -> None:
        with pytest.raises(rodgen.Interrupted) as stopped:
            rodgen.resume(file, progress=stop)
        again.append(stopped.value.solution)

    assert [str(one.message) for one in _told(go_on)] == [one.text for one in due]
    assert again[0].doubts == due


@pytest.mark.compiler
def test_doubts_of_the_runs_of_an_analysis_are_its_own() -> None:
    """A search for a cycle runs the scene, which names a number in vain, for several spans; what is
    asked of the cycle later runs it again. Where there is none, they are told all the same."""
    scene = rodgen.Scene.from_dict(ZIEGLER.to_dict() | {"parameters": {"idle": 2.0}})
    found: list[Any] = []
    (told,) = _told(lambda: found.append(rodgen.find_cycle(scene)))
    assert told.filename == __file__
    assert [str(told.message)] == [note.text for note in found[0].doubts]
    assert _told(lambda: found[0].to_dict()) == []
    assert len(_told(lambda: found.append(rodgen.natural_modes(scene, after=0.1)))) == 2
    assert {note.text for note in found[1].doubts} > {str(told.message)}
    calm = scene.replace({"loads.follower.force": 0.5})
    with pytest.warns(rodgen.DoubtWarning), pytest.raises(rodgen.AnalysisError):
        rodgen.find_cycle(calm)


@pytest.mark.compiler
def test_a_doubt_that_is_an_error_leaves_no_file(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", rodgen.DoubtWarning)
        with pytest.raises(rodgen.DoubtWarning):
            rodgen.simulate(TURNED, out=tmp_path / "run.nc", progress=False)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.compiler
def test_a_file_says_that_it_has_no_room_for_all_notes(tmp_path: Path) -> None:
    """Of forty numbers that nothing names; the run itself has them all."""
    numbers = {f"of_a_rather_long_name_that_nothing_reads_{at}": 1.0 for at in range(40)}
    scene = rodgen.Scene.from_dict(COLUMN.to_dict() | {"parameters": numbers})
    file = tmp_path / "run.nc"
    with pytest.warns(rodgen.DoubtWarning):
        run = rodgen.simulate(scene, span=(0, 0.1), out=file, progress=False)
    kept = load(file).notes
    assert (len(run.notes), kept[-1].kind) == (40, "remark")
    assert 10 < len(kept) < 40
    assert kept[:-1] == run.notes[: len(kept) - 1]
