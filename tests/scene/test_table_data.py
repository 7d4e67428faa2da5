"""Tables as data: what is read from a file stays numbers, and is no part of the text."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import rodgen
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.scene.grammar import TableData
from rodgen.scene.lookup_table import MOST_ROWS
from rodgen.scene.model_contents import model_parts
from rodgen.system import System
from tests.scene.tables import TOML, scene_of
from tests.told import refused

T = np.linspace(0.0, 2.0, 20_001)
SINE = {"knots": T.tolist(), "values": np.sin(3 * T).tolist()}
NONUNIFORM = np.concatenate(
    ([-1.0], np.geomspace(1e-6, 3.0, 999))
)  # guesses by even spacing are wrong
FORCE = "interp(t, 'f')"


def scene(force: str = FORCE, table: Any = SINE, **tables: Any) -> Scene:
    loads = {"follower": {"force": force}}
    rod = {"links": 1, "boundary": "pinned"}
    return scene_of(rod=rod, loads=loads, tables={"f": table}, **tables)


def test_a_table_is_one_parameter_whose_numbers_are_in_no_text() -> None:
    made = scene("2*interp(t, 'f') + interp(t, 'f', 'cubic')")
    structure = made.structure
    name, other = "follower_force_table_1", "follower_force_table_2"
    assert structure.tables == ((name, 20_001), (other, 20_001))
    assert len(dict(structure.expressions)["follower_force"]) < 100
    assert structure.slices[name] == slice(5, 5 + 2 * 20_001)
    module = rodgen.build(made, "numpy")
    p = module.parameters(**made.parameters)
    np.testing.assert_array_equal(p[structure.slices[other]], [*T, *np.sin(3 * T)])
    assert {name: 20_001, other: 20_001} == module.TABLES


def test_scenes_with_tables_go_out_and_come_in(tmp_path: Path) -> None:
    short = {"knots": T[::100].tolist(), "values": (T**2)[::100].tolist()}
    made = scene(table=short)
    assert made.to_dict()["tables"] == {"f": short}
    (tmp_path / "again.toml").write_text(made.to_toml(), encoding="utf-8")
    again = Scene.from_toml(tmp_path / "again.toml")
    for other in (again, pickle.loads(pickle.dumps(made)), Scene.from_dict(made.to_dict())):
        assert (other, hash(other)) == (made, hash(made))
    assert made != made.replace({"tables": {"f": short | {"values": short["knots"]}}})
    assert made.replace({"rod.links": 3}).tables == made.tables
    solution = rodgen.simulate(made.replace({"integrate.span": [0.0, 0.1]}), target="numpy")
    solution.save(tmp_path / "run.nc")
    assert rodgen.load(tmp_path / "run.nc").scene.tables == made.tables


def test_numbers_of_a_file_are_read_once_and_named_by_it(tmp_path: Path) -> None:
    """The scene names the file, and its column; what is there already is not read again."""
    (tmp_path / "a.csv").write_text("t;F;m\n0;1;5\n2;3;4\n", encoding="utf-8")
    (tmp_path / "a.eng").write_text("C6 18 70 0 0.1 0.2 E\n 1 4\n 2 2\n;", encoding="utf-8")
    text = TOML + "[loads.follower]\nforce = \"interp(t, 'a.csv') * interp(t, 'a.csv', 'm')\"\n"
    text += "[states.fuel]\nrate = \"interp(t, 'a.eng', 'cubic')\"\n"
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    made = Scene.from_toml(tmp_path / "a.toml")
    assert {name: table.values.tolist() for name, table in made.tables.items()} == {
        "a.csv": [1, 3],
        "a.csv:m": [5, 4],
        "a.eng": [0, 4, 2],
    }
    for name in ("a.csv", "a.eng"):
        (tmp_path / name).unlink()
    (tmp_path / "a.toml").write_text(made.to_toml(), encoding="utf-8")
    assert Scene.from_toml(tmp_path / "a.toml") == made
    rows = {one.piece: one.reason for one in model_parts(made)}
    assert "2 rows" in rows["table a.csv:m"]
    assert "'a.csv'" in rows["follower"]


def test_a_long_file_is_a_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = "".join(f"{a:.4f}, {a * a:.6f}\n" for a in T)
    (tmp_path / "a.csv").write_text("t [s], F [N]\n" + rows, encoding="utf-8")
    text = TOML + "[loads.follower]\nforce = \"interp(t, 'a.csv')\"\n"
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    table = Scene.from_toml(tmp_path / "a.toml").tables["a.csv"]
    assert len(table) == 20_001
    np.testing.assert_allclose(table.values, T**2, atol=1e-6)  # as it is written
    monkeypatch.setattr("rodgen.scene.scene_files.MOST_ROWS", 20_000)
    found = refused(Scene.from_toml, tmp_path / "a.toml")
    assert (found.field, found.value) == ("loads.follower.force", "a.csv")


@pytest.mark.parametrize(
    ("table", "field"),
    [
        ({"knots": [0, 1], "values": [0]}, "values"),
        ({"knots": [0], "values": [0]}, "knots"),
        ({"knots": [0, 1, 1], "values": [0, 1, 2]}, "knots"),
        ({"knots": [0, True], "values": [0, 1]}, "knots"),
        ({"knots": [0, 1], "values": [0, float("nan")]}, "values[1]"),
        ({"knots": [0, "1"], "values": [0, 1]}, "knots"),
        ({"knots": [[0, 1]], "values": [0, 1]}, "knots"),
        ({"knots": [0, 10**400], "values": [0, 1]}, "knots[1]"),
        ({"knots": list(range(MOST_ROWS + 1)), "values": [0] * (MOST_ROWS + 1)}, "knots"),
        ({"knots": [0, 1]}, ""),
        ({"knots": [0, 1], "values": [0, 1], "kind": 1}, ""),
        ([0, 1], ""),
    ],
)
def test_what_is_no_table_is_refused_by_its_name(table: Any, field: str) -> None:
    assert refused(scene, FORCE, table).field == ".".join(filter(None, ("tables.f", field)))


def test_a_table_is_named_where_it_is_one() -> None:
    for text in ("interp(t, 'g')", "interp(t, f)", "f*t", "'f'", "interp(t, 'f', 'spline')"):
        assert refused(scene, text)[:2] == ("loads.follower.force", text)
    force = "interp(t, F)"  # of a number
    assert refused(scene, force, parameters={"F": 2.0})[:2] == ("loads.follower.force", force)


def test_values_of_a_module_are_checked() -> None:
    made = scene(table={"knots": [0, 1, 2], "values": [5, 6, 4]})
    module, given, name = rodgen.build(made, "numpy"), made.parameters, "follower_force_table_1"
    for wrong in ([0, 1, 2, 5, 6], [0, 1, 1, 5, 6, 4], [0, 1, 2, 5, 6, np.inf], "abcdef"):
        with pytest.raises((TypeError, ValueError), match=name):
            module.parameters(**given | {name: wrong})


@pytest.mark.parametrize("target", ["numpy", "c"])
@pytest.mark.parametrize("kind", ["linear", "cubic"])
def test_every_target_finds_values_and_slopes(target: str, kind: str) -> None:
    """At knots, between and outside of them: of SciPy, and slopes by its derivative."""
    values = np.sin(40 * NONUNIFORM) + np.round(NONUNIFORM, 1)
    table = {"knots": NONUNIFORM.tolist(), "values": values.tolist()}
    states = {"a": {"rate": f"interp(a, 'f', '{kind}')"}}
    module = rodgen.build(scene("1.0", table, states=states), target)
    p = module.parameters(**scene("1.0", table, states=states).parameters)
    draw = np.random.default_rng(1)
    inside = draw.choice(NONUNIFORM[:-1], 300) * draw.uniform(1.0, 1.003, 300)
    inside[:4] = -0.9, -0.1, 2.96, 2.99  # in the first part and in the last
    x = np.concatenate((inside, NONUNIFORM[::7], [-5.0, -1.0, 3.0, 9.0]))
    cubic = PchipInterpolator(NONUNIFORM, values)
    due = cubic(np.clip(x, -1.0, 3.0)) if kind == "cubic" else np.interp(x, NONUNIFORM, values)
    found = [module.rhs(0.0, np.array([0.1, 0.2, at]), p)[2] for at in x]
    # Two forms of one polynomial: some roundings of the largest value.
    np.testing.assert_allclose(found, due, atol=2e-14 * np.abs(values).max())
    at = np.searchsorted(NONUNIFORM, inside, side="right") - 1
    due = (
        (np.diff(values) / np.diff(NONUNIFORM))[at]
        if kind == "linear"
        else cubic.derivative()(inside)
    )
    slopes = [module.jac(0.0, np.array([0.1, 0.2, at]), p)[2, 2] for at in inside]
    np.testing.assert_allclose(slopes, due, atol=1e-11 * np.abs(due).max())


def test_steps_end_at_knots_that_tell_what_a_table_is_like() -> None:
    few = TableData(T[::50], np.sin(3 * T[::50]))
    np.testing.assert_array_equal(few.corners, few.knots)
    corners = TableData(T, np.sin(3 * T)).corners
    assert {0.0, 2.0} < set(corners)
    # Between them straight lines are off by a thousandth of the range, of two, and no more; a line
    # from knot to knot over h is off by 9 h^2/8.
    assert 20 < len(corners) < 80
    off = np.sin(3 * T) - np.interp(T, corners, np.sin(3 * corners))
    assert np.abs(off).max() <= 0.002
    jump = np.where(T < 1.0, 0.0, 5.0) + 1e-3 * np.sin(50 * T)
    assert {T[9_999], T[10_000]} < set(TableData(T, jump).corners)
    noise = np.random.default_rng(1).standard_normal(len(T))
    assert len(TableData(T, noise).corners) <= 500
    assert (
        Expression(FORCE, "t", numbers=(("'f'", few),)).breaks(0.0, 1.0)
        == few.knots[1:-1][few.knots[1:-1] < 1.0].tolist()
    )


def test_a_long_table_costs_what_the_curve_costs() -> None:
    """Its kinks are no steps: of 20 000 knots, a run sees the sine, whose integral is known."""

    def run(rate: str) -> Any:
        settings = {"span": [0.0, 2.0], "method": "dop853", "rtol": 1e-7, "atol": 1e-9}
        made = scene("1.0", integrate=settings, states={"sum": {"rate": rate}})
        return rodgen.simulate(made, target="numpy")

    table, curve = run("interp(t, 'f')"), run("sin(3*t)")
    corners = TableData(**SINE).corners
    # A few to each corner, where the run begins anew.
    assert curve.stats.nsteps < table.stats.nsteps < curve.stats.nsteps + 4 * len(corners) < 250
    # Ten tolerances; a line between two knots is off by less, 9 (1e-4)^2/8.
    assert table.y[-1, -1] == pytest.approx((1 - np.cos(6.0)) / 3, abs=1e-6)


@pytest.mark.parametrize("target", ["numpy", "c"])
def test_a_law_of_the_motion_meets_a_pulse_of_its_table(target: str) -> None:
    """Of a state that crosses all its knots in one step; and where the last is at the end."""
    pulse = {"knots": [0, 4, 4.01, 4.02, 4.03, 10], "values": [0, 0, 100, 100, 0, 0]}
    for table in (pulse, _sampled(pulse)):
        states = {"clock": {"rate": 1.0}, "sum": {"rate": "interp(clock, 'f')"}}
        settings = {"span": [0.0, 10.0], "method": "dop853", "rtol": 1e-8, "atol": 1e-10}
        made = scene("1.0", table, states=states, integrate=settings)
        area = rodgen.simulate(made, target=target).y[-1, -1]
        assert area == pytest.approx(2.0, abs=1e-7)  # ten tolerances


def _sampled(table: dict[str, list[float]]) -> dict[str, list[float]]:
    """The same function in more rows than steps end at."""
    knots = np.unique([*np.linspace(0.0, 10.0, 801), *table["knots"]])
    values = np.interp(knots, table["knots"], table["values"])
    return {"knots": knots.tolist(), "values": values.tolist()}


def test_a_table_that_begins_later_is_met_at_all_its_knots() -> None:
    """However close they are to each other, and however long the span is."""
    knots = [777.7, 777.71, 777.72, 777.73]
    delayed = Expression(f"interp(t - 0.5, {knots}, [0, 5, 5, 0])", "t")
    assert delayed.breaks(0.0, 1000.0) == pytest.approx([at + 0.5 for at in knots], abs=1e-12)
    data = TableData(np.linspace(0, 900, 901), np.where(np.arange(901) == 700, 1.0, 0.0))
    named = Expression("interp(t - 0.5, 'f')", "t", numbers=(("'f'", data),))
    assert named.breaks(0.0, 1000.0) == pytest.approx(data.corners + 0.5, abs=1e-12)


def test_a_small_bump_of_a_long_table_is_met() -> None:
    """Of a hundredth of its range, long after it was at rest."""
    knots = np.linspace(0.0, 10.0, 2001)
    bump = np.where((knots > 5) & (knots < 5.011), 9.0, 0.0)
    values = np.where(knots < 0.05, 1000.0, 0.0) + bump
    table = {"knots": knots.tolist(), "values": values.tolist()}
    settings = {"span": [0.0, 10.0], "method": "dop853", "rtol": 1e-8, "atol": 1e-10}
    states = {"sum": {"rate": "interp(t, 'f')"}}
    made = scene("1.0", table, states=states, integrate=settings)
    due = np.trapezoid(values, knots)
    # As 1000 is integrated to a hundred tolerances of its own.
    assert rodgen.simulate(made, target="numpy").y[-1, -1] == pytest.approx(due, abs=1e-3)


def test_many_runs_take_tables_that_ascend() -> None:
    made = scene(table={"knots": [0, 1, 2], "values": [5, 6, 4]})
    model, name = rodgen.build(made, "numpy"), "follower_force_table_1"
    for knots in ([2, 1, 0], [0, 1, 1]):
        given = made.parameters | {name: [*knots, 1, 2, 3]}
        found = refused(rodgen.simulate_many, model, given, made.initial_state(), span=(0, 1))
        assert found.field == f"p.{name}"


def test_tables_have_a_limit_together_and_an_unread_one_is_a_doubt(tmp_path: Path) -> None:
    half = {"knots": list(range(100_001)), "values": [0.5] * 100_001}
    tables = {"f": half, "g": half}
    found = refused(scene_of, rod={"links": 1, "boundary": "pinned"}, tables=tables)
    assert found[:2] == ("tables", 200_002)
    (said,) = System(scene("1.0", {"knots": [0, 1], "values": [5, 6]})).doubts
    assert "tables.f" in said.text
    assert not System(scene(table={"knots": [0, 1], "values": [5, 6]})).doubts


def test_what_stands_in_tables_is_not_read_from_a_file(tmp_path: Path) -> None:
    """Nor a text written anew that names no file; a column beside one that is there is."""
    (tmp_path / "a.csv").write_text("t;F;m\n0;1;5\n2;3;4\n", encoding="utf-8")
    load = "[loads.follower]\nforce = \"interp(t, 'a.csv', 'F')+interp(t,'a.csv','m')\"\n"
    table = '[tables."a.csv:F"]\nknots = [0, 1]\nvalues = [7, 8]\n'
    (tmp_path / "a.toml").write_text(TOML + load + table, encoding="utf-8")
    made = Scene.from_toml(tmp_path / "a.toml")
    assert made.tables["a.csv:F"].values.tolist() == [7, 8]
    assert made.tables["a.csv:m"].values.tolist() == [5, 4]
    text = "2*interp(t,[0,1],[2,3])"
    (tmp_path / "b.toml").write_text(scene(text).to_toml(), encoding="utf-8")
    assert Scene.from_toml(tmp_path / "b.toml").loads.follower.force == text
    load = "[loads.follower]\nforce = \"interp(t, 'thrus')\"\n"
    (tmp_path / "c.toml").write_text(TOML + load + table.replace("a.csv:F", "thrust"))
    assert "thrust" in refused(Scene.from_toml, tmp_path / "c.toml").allowed


def test_a_column_by_name_behind_one_of_text(tmp_path: Path) -> None:
    text = "n;date;F\n0;1 May 2026;2,5\n1;2 May 2026;3,5\n;;\n\x1a\n"
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    load = "[loads.follower]\nforce = \"interp(t, 'a.csv', 'F')\"\n"
    (tmp_path / "a.toml").write_text(TOML + load, encoding="utf-8")
    assert Scene.from_toml(tmp_path / "a.toml").tables["a.csv:F"].values.tolist() == [2.5, 3.5]
