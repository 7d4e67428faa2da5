"""Scenes edited in the page: their structure, what is fixed to rods, what is taken away."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rodgen
from rodgen.scene import Scene
from tests.live.conftest import ROD
from tests.live.view import expect

pytestmark = pytest.mark.nightly
View = Any  # see conftest.py


def test_scene_run_film_and_link_are_taken_away(
    view: View, another: Callable[[], View], tmp_path: Path
) -> None:
    view.fill("mass M", "25")
    view.tab("Values").until(lambda: float(view.text("mass")), 25.0, "the mass is not taken")
    view.pause_after(0.3).tab("Save")
    files = {
        text: view.download(view.button(text)).rename(tmp_path / name)
        for text, name in (
            ("Scene as TOML", "dart.toml"),
            ("Run as NetCDF", "dart.nc"),
            ("Animation as GIF", "a.gif"),
        )
    }
    scene = Scene.from_toml(files["Scene as TOML"])
    assert scene.rod.mass == 25.0
    sol = rodgen.load(files["Run as NetCDF"])
    assert sol.t[-1] == pytest.approx(view.live("t"), abs=0.02)
    end = float(sol.t[-1])
    again = rodgen.simulate(scene, span=[0.0, end], output_every=end)
    assert sol.phi[-1, -1] == pytest.approx(again.phi[-1, -1], abs=0.02)
    assert files["Animation as GIF"].read_bytes()[:3] == b"GIF"
    view.button("Link").click()
    link = view.field("link")
    address = view.until(link.input_value, lambda text: "scene=" in text, "no link")
    other = another().open(address)
    expect(other.field("mass M")).to_have_value("25")
    expect(link).to_be_visible()
    view.tab("Parameters").fill("mass M", "24")
    view.tab("Save")
    expect(link).to_be_hidden()  # it is to what was before


def test_another_structure_is_made_while_the_page_lives(view: View) -> None:
    """What is refused is said beside its field, and there alone."""
    view.tab("Scene").fill("number of links", "1")
    view.page.get_by_role("checkbox", name="tip load").click()
    view.button("Apply").click()
    view.tab("Values")
    view.until(lambda: view.text("links"), "1", "not made")
    view.run().passes(0.2)
    wrong = view.page.locator(".q-field--error")
    view.tab("Scene").fill("number of links", "0")
    view.button("Apply").click()
    expect(wrong.filter(has_text="whole number from 1")).to_be_visible()
    view.fill("number of links", "1")
    view.fill("phi: a number", "sin(")
    view.button("Apply").click()
    expect(wrong.filter(has_text="phi")).to_be_visible()
    expect(wrong).to_have_count(1)  # the number of links is not at fault any more
    view.fill("phi: a number", "0")
    view.fill("position", "1e308,0")  # a part of a list
    view.button("Apply").click()
    expect(wrong.filter(has_text="position").filter(has_text="must be at most")).to_be_visible()
    assert view.answered().notes() == []


def test_what_a_scene_fixes_to_its_rod_can_be_edited(
    blank: View, serve: Callable[..., Any], tmp_path: Path
) -> None:
    """By number, by expression where one stands, and the value of a state at the start."""
    tomli_w = pytest.importorskip("tomli_w")
    table = {
        **ROD,
        "bodies": [{"name": "tank", "at": 0.5, "mass": 1.0}],
        "supports": [{"at": 1.0, "stiffness": [0.0, 5.0]}],
        "foundation": {"stiffness": "3 + s"},
        "states": {"valve": {"rate": "-2*valve", "initial": 2.0}},
    }
    path = tmp_path / "rig.toml"
    path.write_text(tomli_w.dumps(table))
    view = blank.open(serve(str(path), "--port", "0").address)

    def kept() -> tuple[object, ...]:
        """What a scene that is taken away has now."""
        view.tab("Save")
        scene = tomllib.loads(view.download(view.button("Scene as TOML")).read_text())
        tank, support, valve = scene["bodies"][0], scene["supports"][0], scene["states"]["valve"]
        body = tank["mass"], tank["at"], tank.get("offset")
        held = support["stiffness"], support.get("to", [None, None])[1]
        return *body, *held, scene["foundation"]["stiffness"], valve["rate"], valve["initial"]

    wanted: list[object] = [1.0, 0.5, None, [0.0, 5.0], None, "3 + s", "-2*valve", 2.0]
    for name, text, at, value in (
        ("mass of tank", "2", 0, 2.0),
        ("place s of tank", "0.25", 1, 0.25),
        ("centre across the link of tank", "0.1", 2, [0.0, 0.1]),
        ("fixed point in y of support 0", "0.3", 4, 0.3),
        ("stiffness of the foundation", "4 + 2*s", 5, "4 + 2*s"),
        ("rate of valve", "-3*valve", 6, "-3*valve"),
    ):
        view.tab("Parameters").fill(name, text)
        wanted[at] = value
        view.until(lambda at=at: kept()[at], value, f"{name} is not taken")
    view.tab("Parameters").fill("stiffness in y of support 0", "-5")
    refused = view.page.locator(".q-field__messages", has_text="at least 0")
    expect(refused).to_be_visible()
    view.tab("Scene").fill("valve at the start", "0.5")
    view.button("Apply").click()
    wanted[7] = 0.5
    view.until(kept, tuple(wanted), "not as it was edited")


# The scale of every picture since the last question, as it is written into it.
WRITTEN = """
    window.scales = [];
    const fill = CanvasRenderingContext2D.prototype.fillText;
    CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
        if (/^[0-9].* m$/.test(text)) scales.push(text);
        return fill.call(this, text, ...place);
    };
"""


def test_parameter_leaves_the_picture_and_another_scene_does_not(blank: View, server: Any) -> None:
    """The strength of kicks and the zoom: kept when the rod is made softer, anew for another
    scene."""

    def scales() -> list[str]:
        return list(blank.page.evaluate("scales.splice(0)"))

    blank.page.add_init_script(WRITTEN)
    blank.open(server.address)
    blank.page.get_by_role("switch", name="kick").click()
    strength = blank.field("N s per metre")
    expect(strength).to_have_value("3")  # of 3 kg
    blank.fill("N s per metre", "0.5")
    canvas = blank.page.get_by_role("img", name="dart")
    scales()
    canvas.press("0")
    fitted = blank.until(scales, lambda found: len(found) > 0, "nothing is drawn")[-1]
    for _ in range(12):  # 1.25^12 = 15
        canvas.press("+")
    blank.sees("scales", lambda found: found[-1] != fitted, "not zoomed")
    scales()
    blank.fill("bending stiffness EI", "4")
    blank.pause_after(0.2)
    assert fitted not in scales()
    expect(strength).to_have_value("0.5")
    blank.select("Scene", "two")
    expect(strength).to_have_value("4")
    blank.sees("scales", lambda found: fitted in found, "the view of the scene before")
