"""Numbers in expressions: parameters of the module, named in [parameters], tables of them, and
where they stand in the text."""

from __future__ import annotations

import math
import pickle
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from rodgen.scene import Scene
from rodgen.scene.expression import Expression, open_expression
from rodgen.scene.literals import literals, replace_literal
from rodgen.scene.plain_tables import set_at
from rodgen.system import System
from tests.scene.tables import TOML, scene_of
from tests.told import refused


def scene(force: object, **tables: Any) -> Scene:
    return scene_of(rod={"links": 3}, loads={"follower": {"force": force}}, **tables)


def test_every_number_but_a_whole_exponent_gets_a_name() -> None:
    knots = {"f_knot_1": -1.0, "f_knot_2": 2.0, "f_value_1": 3.0, "f_value_2": -4.0}
    for text, values in (
        ("300*min(t/0.5, 1)", {"f_1": 300.0, "f_2": 0.5, "f_3": 1.0}),
        ("2 if t < 3 else -4", {"f_1": 2.0, "f_2": 3.0, "f_3": 4.0}),
        ("t**2 + t**-3 + t**0.5 + 2**t", {"f_1": 0.5, "f_2": 2.0}),  # whole exponents stay
        ("interp(t, [-1, 2], [3, -4]) + 5", {**knots, "f_1": 5.0}),
        ("sin(2*pi*t)", {"f_1": 2.0}),
        ("deg(30)*sin(deg(5*t))", {"f_1": 30.0, "f_2": 5.0}),  # in degrees
    ):
        expression = Expression(text, "t")
        named, found = expression.with_parameters("f")
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
    places = {f"loads.follower.force.{at}": v for at, v in enumerate((301.0, 0.25, 2.0))}
    assert [one.value_of(key) for key in places] == [300.0, 0.5, 1.0]
    assert refused(one.value_of, "loads.follower.force.3").field == "vary"
    assert one.replace(places).expression("follower_force")(0.125) == 150.5
    assert scene("300*min(t/0.5, t)").structure != one.structure


def test_a_named_number_serves_in_several_places() -> None:
    made = scene_of(
        rod={"links": 3},
        parameters={"P0": 300.0, "T": 2},
        loads={"follower": {"force": "P0*min(t/T, 1)"}, "tip": {"x": "P0/10", "y": "-P0*t"}},
        initial={"phi": "P0*s/1000"},
    )
    p = made.parameters
    assert (p["P0"], p["T"], p["tip_force_x"]) == (300.0, 2.0, 30.0)
    assert made.structure.parameters.count("P0") == 1
    assert made.breaks() == [2.0]
    np.testing.assert_allclose(made.initial_state()[2:5], 0.3 * (np.arange(3) + 0.5) / 3)
    assert Scene.from_dict(made.model_dump(exclude_none=True)) == made
    assert made.replace({"parameters.P0": 200.0}).parameters["P0"] == 200.0


def test_a_name_that_cannot_be_is_refused() -> None:
    for name in ("t", "mass", "follower_force_1", "sin", "deg", "lambda", "phi", "_x", "é"):
        assert refused(scene, "t + 1", parameters={name: 1.0})[:2] == (f"parameters.{name}", name)
    assert refused(scene, "t", parameters={"P0": 1.0, "p0": 1.0})[:2] == ("parameters.p0", "p0")
    for value in ("P0", "2*t", float("inf")):
        assert refused(scene, "t", parameters={"P0": value})[:2] == ("parameters.P0", value)
    assert refused(scene, "t", numbers={"P0": 2.0})[:2] == ("numbers", {"P0": 2.0})


def test_a_number_may_be_an_expression_of_named_ones() -> None:
    """It is computed with as a number, kept as its text, and follows the numbers that it names."""
    given: dict[str, Any] = {
        "parameters": {"tilt": "deg(15)", "size": 2},
        "rod": {
            "links": 3,
            "length": "size/2",
            "boundary": "clamped",
            "clamp_angle": "deg(90) + tilt",
            "bending_stiffness": ["size", 3, "1 + 1", 4.0],
        },
        "bodies": [{"name": "b", "at": "1/2", "mass": 1.0, "offset": [0.0, "size"]}],
        "supports": [{"at": 1.0, "to": ["size", 0], "rotation": "10*size"}],
        "loads": {
            "gravity": {"g": "9.81*cos(deg(60))"},
            "external_damping": {"coefficient": 1.0, "fin_factor": [0, 0, "size", 0]},
            "distributed_follower": {"force_per_length": [1, "deg(180)", 2]},
        },
        "states": {"lag": {"rate": 0.0, "initial": "-deg(10)"}},
        "initial": {"phi": ["deg(30)", 0.5, "2*tilt"], "omega": ["-size", 0, "min(1, tilt)"]},
        "events": [{"quantity": "phi_2", "value": "deg(40)"}],
    }
    for tilt, size in ((math.pi / 12, 2.0), (0.1, 3.0)):
        made = scene_of(**given).replace({"parameters.tilt": tilt, "parameters.size": size})
        plain = scene_of(**given).replace(
            {
                "parameters": None,
                "rod.length": size / 2,
                "rod.clamp_angle": math.pi / 2 + tilt,
                "rod.bending_stiffness": [size, 3.0, 2.0, 4.0],
                "bodies.b.at": 0.5,
                "bodies.b.offset.1": size,
                "supports.0.to.0": size,
                "supports.0.rotation": 10 * size,
                "loads.gravity.g": 9.81 / 2,
                "loads.external_damping.fin_factor.2": size,
                "loads.distributed_follower.force_per_length.1": math.pi,
                "states.lag.initial": -math.pi / 18,
                "initial.phi": [math.pi / 6, 0.5, 2 * tilt],
                "initial.omega": [-size, 0.0, min(1.0, tilt)],
                "events.0.value": math.pi / 4.5,
            }
        )
        assert made.structure == plain.structure
        for name, value in plain.parameters.items():
            np.testing.assert_allclose(made.parameters[name], value, rtol=1e-14)
        np.testing.assert_allclose(made.initial_state(), plain.initial_state(), rtol=1e-14)
        assert made.events[0].value == pytest.approx(plain.events[0].value, rel=1e-14)
        assert made.value_of("initial.phi.0") == pytest.approx(math.pi / 6, rel=1e-14)
        for again in (made, pickle.loads(pickle.dumps(made)), Scene.from_dict(made.to_dict())):
            assert again.to_dict()["initial"]["phi"] == given["initial"]["phi"]
            assert again.to_dict()["rod"]["clamp_angle"] == "deg(90) + tilt"
            assert again.to_dict()["events"][0]["value"] == "deg(40)"
        assert tomllib.loads(made.to_toml())["loads"]["gravity"]["g"] == "9.81*cos(deg(60))"
        # The same where other values need no other scene, and where the slot of a key is asked.
        system = System(scene_of(**given)).at({"parameters.tilt": tilt, "parameters.size": size})
        np.testing.assert_array_equal(system.y0, made.initial_state())
        system = system.at({"initial.phi.1": 0.25, "initial.phi.2.0": 3.0})
        assert system.y0[:3] == pytest.approx([math.pi / 6, 0.25, 3 * tilt], rel=1e-14)


def test_an_expression_that_is_no_such_number_is_refused() -> None:
    """The message names the entry of a list, its text and what may stand there."""
    for field, text in (
        ("initial.phi.1", "deg(s)"),
        ("initial.phi.1", "deg(B)"),
        ("initial.omega.2", "1/0"),
        ("initial.position.0", "t"),
        ("rod.bending_stiffness.3", "-deg(1)"),
        ("rod.length", "A - A"),
        ("rod.mass", "deg("),
        ("loads.drag.normal", "phi(0.5)"),
        ("parameters.A", "2*A"),
        ("integrate.span.1", "2*pi"),
    ):
        table, _, at = field.rpartition(".")
        given = scene_of(
            parameters={"A": 1.0},
            rod={"links": 3, "bending_stiffness": [1.0] * 4},
            loads={"drag": {}},
            initial={"phi": [0.0] * 3, "omega": [0.0] * 3, "position": ["A", 0]},
        ).to_dict()
        set_at(given, [*table.split("."), at], text)
        told = refused(Scene.from_dict, given)
        assert told[:2] == (field, text)
        limit = {"-deg(1)": "at least 0", "A - A": "greater than 0", "2*pi": "a number"}
        assert limit.get(text, "a number or an expression") in told.allowed


KNOTS, VALUES = [0.0, 0.1, 2.0, 2.5, 5.0], [0.0, 310.0, 290.0, 290.0, -3.0]


def test_a_table_holds_its_ends_and_breaks_at_its_knots() -> None:
    t = np.linspace(-1, 7, 801)
    linear, cubic = np.interp(t, KNOTS, VALUES), PchipInterpolator(KNOTS, VALUES)(np.clip(t, 0, 5))
    for kind, due in (("", linear), (", 'linear'", linear), (", 'cubic'", cubic)):
        table = Expression(f"interp(t, {KNOTS}, {VALUES}{kind})", "t")
        np.testing.assert_allclose(table(t), due, rtol=1e-14, atol=1e-12)
        assert table.breaks(-1, 7) == KNOTS
        assert table.breaks(0, 5) == KNOTS[1:-1]
    # Of something else, where that meets the knots.
    table = Expression("interp(2*t, [0, 1, 3], [0, 1, 0])", "t")
    assert table.breaks(0.0, 5.0) == pytest.approx([0.5, 1.5], abs=1e-15)


def test_what_is_no_table_is_refused() -> None:
    for text in (
        *("interp(t, [0, 1], [0])", "interp(t, [0], [0])", "interp(t, [1, 0], [0, 1])"),
        *("interp(t, [0, 0], [0, 1])", "interp(t, [0, 1], [0, t])", "interp(t, [0, 1], [0, 2*3])"),
        *("interp(t, [0, 1], [0, 1], 'spline')", "interp(t, [0, 1], [0, 1], kind='cubic')"),
        *("interp(t, 'thrust.csv')", "interp(t)", "interp([0], [0, 1], [0, 1])", "[0, 1]"),
        f"interp(t, {list(range(1001))}, {list(range(1001))})",
    ):
        assert refused(scene, text)[:2] == ("loads.follower.force", text)


MOTOR = """; a motor
C6 18 70 0-3-5-7 0.0108 0.0249 Estes
   0.031 0.946
   0.2 14.09
   1.86 0
;
"""


def _from_file(folder: Path, name: str, text: str | None) -> Scene:
    """A scene that takes the values of a table from a file beside it."""
    if text is not None:
        (folder / name).write_text(text, encoding="utf-8")
    load = f"[loads.follower]\nforce = \"2*interp(t, '{name}')\"\n"
    (folder / "scene.toml").write_text(TOML + load, encoding="utf-8")
    return Scene.from_toml(folder / "scene.toml")


def test_a_table_in_a_file_is_in_the_scene_afterwards(tmp_path: Path) -> None:
    for name, text, knots, values in (
        ("a.csv", "time [s], thrust [N]\n0, 0\n0.5, 310 # peak\n\n2,0\n", [0, 0.5, 2], [0, 310, 0]),
        ("b.csv", "0;0\n1;2.5e1\n", [0, 1], [0, 25]),
        ("C.CSV", "0 0\n1\t-2", [0, 1], [0, -2]),
        ("c6.eng", MOTOR, [0, 0.031, 0.2, 1.86], [0, 0.946, 14.09, 0]),
    ):
        made = _from_file(tmp_path, name, text)
        force = made.expression("follower_force")
        assert force is not None
        np.testing.assert_allclose(force(knots), 2 * np.array(values))
        assert force.knots() == knots
        assert Scene.from_dict(made.model_dump(exclude_none=True)) == made


KEPT = [(0.0, 0.5), (0.5, 12.25), (2.0, -1.0)]


@pytest.mark.parametrize(
    "text",
    [
        "t;F\ns;N\n0,0;0,5\n0,5;12,25\n2,0;-1,0\n",  # names, units, decimal commas
        "0,0 0,5\r\n0,5\t12,25\r\n2,0 -1\r\n",
        '"time (s)","thrust (N)"\n"0","0.5"\n"0.5","12.25"\n"2","-1"\n',
        '"0,0", "0,5"\n"0,5","12,25"\n"2,0","-1,0"\n',
        "0.0, 0.5, 7, left\n0.5, 12.25, 8\n2.0, -1.0, 9, right\n",  # further columns
        "0 ,0.5\n0.5 ,12.25\n2 ,-1\n",
        "0;0\n0;0.5\n.5;1225e-2\n2;-1\n2;0\n",  # jumps at its ends
        "# gemessen \xfc\n\n0\t0.5\t\n0.5\t12.25\t\n2\t-1\t\n",
    ],
)
@pytest.mark.parametrize("coding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_tables_are_read_as_people_have_them(tmp_path: Path, text: str, coding: str) -> None:
    (tmp_path / "a.csv").write_bytes(text.encode(coding))
    force = _from_file(tmp_path, "a.csv", None).expression("follower_force")
    assert force is not None
    assert [(at, force(at) / 2) for at in force.knots()] == KEPT


def test_a_column_by_its_name(tmp_path: Path) -> None:
    text = "Time [s]; Thrust (N); mass\n; kN; kg\n0; 1; 5\n2; 3; 4\n"
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    for more, values in (
        ("", [1, 3]),
        (", 'thrust'", [1, 3]),
        (", 'mass', 'cubic'", [5, 4]),
        (", 'linear'", [1, 3]),
    ):
        load = f"[loads.follower]\nforce = \"interp(t, 'a.csv'{more})\"\n"
        (tmp_path / "scene.toml").write_text(TOML + load, encoding="utf-8")
        force = Scene.from_toml(tmp_path / "scene.toml").expression("follower_force")
        assert force is not None
        assert [force(0.0), force(2.0)] == values
    for more in ("'trust'", "'Time'", "''"):
        load = f"[loads.follower]\nforce = \"interp(t, 'a.csv', {more})\"\n"
        (tmp_path / "scene.toml").write_text(TOML + load, encoding="utf-8")
        assert refused(Scene.from_toml, tmp_path / "scene.toml").field == "loads.follower.force"


ROCKSIM = """<?xml version="1.0" encoding="UTF-8"?>
<engine-database><engine-list><engine code="C6" mfg="Estes">
<data><eng-data t="0.031" f="0.946" m="10"/><eng-data t="0.2" f="14.09" m="9"/>{}</data>
</engine></engine-list></engine-database>
"""
LATE = '<eng-data t="1.86" f="3.5" m="0"/>'


def test_the_thrust_of_a_motor_ends_with_its_curve(tmp_path: Path) -> None:
    """Whatever its last value is; a table of anything else keeps that."""
    times = [0.0, 0.031, 0.2, 1.03, 1.86, 1.860001, 50.0]
    due = 2 * np.array([0.0, 0.946, 14.09, (14.09 + 3.5) / 2, 3.5, 0.0, 0.0])
    cut = MOTOR.replace("1.86 0", "1.86 3.5")
    for name, text in (
        ("c.eng", cut),
        ("c.rse", ROCKSIM.format(LATE)),
        ("C.RSE", ROCKSIM.format(LATE).replace("UTF-8", "shift_jis")),
    ):
        force = _from_file(tmp_path, name, text).expression("follower_force")
        assert force is not None
        np.testing.assert_allclose(force(np.array(times)), due)
        assert 1.86 in force.breaks(0.0, 3.0) or 1.86 in force.knots()
    early = MOTOR.replace("0.031 0.946", "0 9.46\n0.031 0.946")
    force = _from_file(tmp_path, "e.eng", early).expression("follower_force")
    assert force is not None
    np.testing.assert_allclose(force(np.array([-1e-6, 0.0])), [0.0, 18.92])
    force = _from_file(tmp_path, "kept.csv", "0 0\n1 3.5").expression("follower_force")
    assert force is not None
    assert force(9.0) == 7.0


def test_a_file_that_is_no_table_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "scenes"
    folder.mkdir()
    for name, text in (
        *(("missing.csv", None), ("../secret.csv", "0 0\n1 1"), ("/etc/passwd", None)),
        *(("table.txt", "0 0\n1 1"), ("a.csv", "0 0\n0 1"), ("a.csv", "0 0\n1 x")),
        *(("a.csv", "0 0\n1 inf"), ("a.csv", "0 0\nx y\n1 1"), ("a.csv", "0 0")),
        *(("a.csv", "x\n" * 11 + "0 0\n1 1"), ("a.csv", "0\n1"), ("a.csv", "0 0\n1 1\n1 2\n2 0")),
        *(("a.csv", "t;F\n0;1.000,5\n1;2\n2;3"), ("a.csv", "t,F\n0,\n1,2\n2,3")),
        *(("a.csv", "0 1,234.5\n1 1"), ("a.csv", "0 1_0\n1 1"), ("a.csv", "0 0\n1 1\0")),
        *(("a.eng", "0 0\n1 1"), ("a.eng", MOTOR + MOTOR), ("a.rse", MOTOR)),
        ("a.rse", ROCKSIM.format("").replace("f=", "g=")),
        ("a.rse", "<!DOCTYPE a [<!ENTITY b 'c'>]>" + ROCKSIM.format(LATE)),
        ("a.rse", "<engine-database/>"),
    ):
        assert refused(_from_file, folder, name, text)[:2] == ("loads.follower.force", name)


# Numbers in the text ----------------------------------------------------------------------------

TEXTS = (
    "300*min(t/0.5, 1)",
    "  ( 3\n  *t)**2 - 1e-3",
    "a*2*sin(t)**2 + (1 if t < 3 else 4)",
    "interp(t, [0, -1.5, 2], [1, a, -3], 'cubic')*5",
    "(-2*phi(0.3) - 0.5*omega(0.3) - gimbal)/0.05",
)


def test_literals_are_the_numbers_that_a_module_has_as_parameters() -> None:
    """In that order; other values of them are those that the module is given, of equal code."""

    def read(text: str) -> tuple[str, dict[str, float]]:
        made = Expression(text, "t", numbers=(("a", 2.0),), states=("gimbal",))
        return made.with_parameters("force")

    for text in TEXTS[:3] + TEXTS[4:]:
        code, named = read(text)
        named.pop("a", None)
        assert [one.value for one in literals(text)] == list(named.values())
        for at in range(len(named)):
            other, values = read(replace_literal(text, at, 0.125, "force"))
            assert other == code
            assert values == values | named | {f"force_{at + 1}": 0.125}


def test_numbers_of_tables_have_their_signs() -> None:
    """Those of others stand before them."""
    found = literals(TEXTS[3])
    assert [one.value for one in found] == [0.0, -1.5, 2.0, 1.0, -3.0, 5.0]
    assert [one.signed for one in found] == [True] * 5 + [False]
    assert replace_literal(TEXTS[3], 1, 0.5, "force").startswith("interp(t, [0, 0.5, 2], ")
    assert refused(replace_literal, "2**t", 0, -2.5, "force").field == "force"


def test_amplitude_is_what_all_that_changes_is_multiplied_by() -> None:
    for text, leading in (
        ("300*min(t/0.5, 1)", [True, False, False]),
        ("sin(2*t)*a*7", [False, True]),
        ("(1 - s)*40/3", [False, True, False]),
        ("3*t + 5", [False, False]),
        ("-300*t", [False]),  # the sign is not its own
        ("a*sin(t)", []),
    ):
        assert [one.leads for one in literals(text, ("a",))] == leading


def test_places_are_told_by_the_text_around_them() -> None:
    """As the expression has it, cut where it is long."""
    around = [one.around for one in literals(TEXTS[0])]
    assert around == ["«300»*min(t/0.5, 1)", "300*min(t/«0.5», 1)", "300*min(t/0.5, «1»)"]
    assert literals("1 + 1 + 1 + 1 + 1 + 1 + 1 + 1 + t")[-1].around == "…1 + 1 + 1 + 1 + «1» + t"
