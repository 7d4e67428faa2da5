"""Numbers in expressions: parameters of the module, named in [parameters], and tables of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from rodgen.scene import Scene, SceneError
from rodgen.scene.expression import Expression, open_expression
from rodgen.scene.overrides import with_parameters
from tests.scene.tables import table_of

Make = Callable[..., Scene]


def scene(force: object, angle: float = 0.0, **tables: Any) -> Scene:
    loads = {"follower": {"force": force, "angle": angle}}
    return Scene.from_dict(table_of(rod={"links": 3}, loads=loads, **tables))


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("300*min(t/0.5, 1)", {"f_1": 300.0, "f_2": 0.5, "f_3": 1.0}),
        ("2 if t < 3 else -4", {"f_1": 2.0, "f_2": 3.0, "f_3": 4.0}),
        ("t**2 + t**-3 + t**0.5 + 2**t", {"f_1": 0.5, "f_2": 2.0}),  # whole exponents stay
        ("interp(t, [-1, 2], [3, -4]) + 5", None),
        ("sin(2*pi*t)", {"f_1": 2.0}),
    ],
)
def test_every_number_but_a_whole_exponent_gets_a_name(
    text: str, values: dict[str, float] | None
) -> None:
    expression = Expression(text, "t")
    named, found = expression.parametrised("f")
    if values is None:
        values = {
            "f_knot_1": -1.0,
            "f_knot_2": 2.0,
            "f_value_1": 3.0,
            "f_value_2": -4.0,
            "f_1": 5.0,
        }
    assert found == values
    t = np.linspace(0.1, 5, 50)
    again = open_expression(named, "t").with_values(found)
    np.testing.assert_array_equal(again(t), expression(t))
    assert again.names == tuple(found)


def test_scenes_that_differ_in_numbers_share_a_module() -> None:
    one, other = scene("300*min(t/0.5, 1)"), scene("301*min(t/0.25, 2)")
    assert one.structure == other.structure
    assert one.structure.stem == other.structure.stem
    assert one.parameters | {"follower_force_1": 301.0} != one.parameters
    assert other.parameters["follower_force_2"] == 0.25
    assert scene("300*min(t/0.5, t)").structure != one.structure


def test_a_named_number_serves_in_several_places() -> None:
    made = Scene.from_dict(
        table_of(
            rod={"links": 3},
            parameters={"P0": 300.0, "T": 2},
            loads={"follower": {"force": "P0*min(t/T, 1)"}, "tip": {"x": "P0/10", "y": "-P0*t"}},
            initial={"phi": "P0*s/1000"},
        )
    )
    p = made.parameters
    assert (p["P0"], p["T"], p["tip_force_x"]) == (300.0, 2.0, 30.0)
    assert made.structure.parameters.count("P0") == 1
    assert made.breaks() == [2.0]
    np.testing.assert_allclose(made.initial_state()[2:5], 0.3 * (np.arange(3) + 0.5) / 3)
    assert Scene.from_dict(made.model_dump(exclude_none=True)) == made
    assert with_parameters(made, {"P0": 200.0}).parameters["P0"] == 200.0


def test_a_number_of_an_expression_is_changed_by_its_name() -> None:
    made = with_parameters(scene("300*min(t/-0.5, 1)"), {"follower_force_2": 0.25})
    assert made.parameters["follower_force_2"] == 0.25
    assert made.expression("follower_force")(1.0) == -1200.0


@pytest.mark.parametrize(
    ("tables", "field"),
    [
        ({"parameters": {"t": 1.0}}, "parameters.t"),
        ({"parameters": {"mass": 1.0}}, "parameters.mass"),
        ({"parameters": {"follower_force_1": 1.0}}, "parameters.follower_force_1"),
        ({"parameters": {"sin": 1.0}}, "parameters.sin"),
        ({"parameters": {"lambda": 1.0}}, "parameters.lambda"),
        ({"parameters": {"phi": 1.0}}, "parameters.phi"),
        ({"parameters": {"_x": 1.0}}, "parameters._x"),
        ({"parameters": {"é": 1.0}}, "parameters.é"),
        ({"parameters": {"P0": 1.0, "p0": 1.0}}, "parameters.p0"),
        ({"parameters": {"P0": "2"}}, "parameters.P0"),
        ({"parameters": {"P0": float("inf")}}, "parameters.P0"),
        ({"numbers": {"P0": 2.0}}, "numbers"),
    ],
)
def test_a_name_that_cannot_be_is_refused(tables: dict[str, Any], field: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene("t", **tables)
    assert caught.value.field == field


KNOTS, VALUES = [0.0, 0.1, 2.0, 2.5, 5.0], [0.0, 310.0, 290.0, 290.0, -3.0]


@pytest.mark.parametrize(
    ("kind", "reference"),
    [
        ("", lambda t: np.interp(t, KNOTS, VALUES)),
        (", 'linear'", lambda t: np.interp(t, KNOTS, VALUES)),
        (", 'cubic'", lambda t: PchipInterpolator(KNOTS, VALUES)(np.clip(t, 0, 5))),
    ],
)
def test_a_table_holds_its_ends_and_breaks_at_its_knots(
    kind: str, reference: Callable[[NDArray[np.float64]], NDArray[np.float64]]
) -> None:
    table = Expression(f"interp(t, {KNOTS}, {VALUES}{kind})", "t")
    t = np.linspace(-1, 7, 801)
    np.testing.assert_allclose(table(t), reference(t), rtol=1e-14, atol=1e-12)
    assert table.breaks(-1, 7) == KNOTS
    assert table.breaks(0, 5) == KNOTS[1:-1]


def test_a_table_of_something_else_breaks_where_that_meets_its_knots() -> None:
    table = Expression("interp(2*t, [0, 1, 3], [0, 1, 0])", "t")
    assert table.breaks(0.0, 5.0) == pytest.approx([0.5, 1.5], abs=1e-15)


@pytest.mark.parametrize(
    "text",
    [
        "interp(t, [0, 1], [0])",
        "interp(t, [0], [0])",
        "interp(t, [1, 0], [0, 1])",
        "interp(t, [0, 0], [0, 1])",
        "interp(t, [0, 1], [0, t])",
        "interp(t, [0, 1], [0, 2*3])",
        "interp(t, [0, 1], [0, 1], 'spline')",
        "interp(t, [0, 1], [0, 1], kind='cubic')",
        "interp(t, 'thrust.csv')",
        "interp(t)",
        "interp([0], [0, 1], [0, 1])",
        f"interp(t, {list(range(1001))}, {list(range(1001))})",
        "[0, 1]",
    ],
)
def test_what_is_no_table_is_refused(text: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene(text)
    assert caught.value.field == "loads.follower.force"


SCENE = """
name = "motor"
[rod]
links = 3
length = 1.0
bending_stiffness = 1.0
mass = 1.0
[loads.follower]
force = "2*interp(t, '{name}')"
"""
MOTOR = """; a motor
C6 18 70 0-3-5-7 0.0108 0.0249 Estes
   0.031 0.946
   0.2 14.09
   1.86 0
;
"""


@pytest.mark.parametrize(
    ("name", "text", "knots", "values"),
    [
        ("a.csv", "time [s], thrust [N]\n0, 0\n0.5, 310 # peak\n\n2,0\n", [0, 0.5, 2], [0, 310, 0]),
        ("b.csv", "0;0\n1;2.5e1\n", [0, 1], [0, 25]),
        ("C.CSV", "0 0\n1\t-2", [0, 1], [0, -2]),
        ("c6.eng", MOTOR, [0, 0.031, 0.2, 1.86], [0, 0.946, 14.09, 0]),
    ],
)
def test_a_table_in_a_file_is_in_the_scene_afterwards(
    tmp_path: Path, name: str, text: str, knots: list[float], values: list[float]
) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "scene.toml").write_text(SCENE.replace("{name}", name), encoding="utf-8")
    made = Scene.from_toml(tmp_path / "scene.toml")
    force = made.expression("follower_force")
    assert force is not None
    np.testing.assert_allclose(force(knots), 2 * np.array(values))
    assert force.knots() == knots
    assert Scene.from_dict(made.model_dump(exclude_none=True)) == made


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("missing.csv", None),
        ("../secret.csv", "0 0\n1 1"),
        ("/etc/passwd", None),
        ("table.txt", "0 0\n1 1"),
        ("a.csv", "0 0\n0 1"),
        ("a.csv", "0 0\n1 x"),
        ("a.csv", "0 0\n1 inf"),
        ("a.csv", "x y\nx y\n0 0\n1 1"),
        ("a.csv", "0 0"),
        ("a.csv", "0 0 0\n1 1 1"),
        ("a.csv", "\n".join(f"{i} 0" for i in range(1001))),
        ("a.eng", "0 0\n1 1"),
        ("a.eng", MOTOR + MOTOR),
    ],
)
def test_a_file_that_is_no_table_is_refused(tmp_path: Path, name: str, text: str | None) -> None:
    if text is not None:
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "scene.toml").write_text(SCENE.replace("{name}", name), encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        Scene.from_toml(tmp_path / "scene.toml")
    assert (caught.value.field, caught.value.value) == ("loads.follower.force", name)
