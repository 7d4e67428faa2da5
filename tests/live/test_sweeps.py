"""Sweeps of a number: what the process beside the server computes, its diagrams, and the page."""

from __future__ import annotations

import queue
import xml.etree.ElementTree as ElementTree
from typing import Any

import pytest

import rodgen
from rodgen.live.page.sweep_picture import HEIGHT, WIDTH, Diagram, Point, picture
from rodgen.live.run.aside import Answer, Aside
from rodgen.live.run.sweep import COUNT, sweep
from rodgen.scene import Scene, SceneError
from tests.live.conftest import ROD, SCENES
from tests.live.view import PATIENT, expect

View = Any  # see conftest.py


def put_together(parts: Any) -> dict[str, Any]:
    found: dict[str, Any] = {"rows": []}
    for part in parts:
        found["rows"] += part.pop("rows", [])
        found |= part
    return found


@pytest.mark.nightly
def test_sweep_of_an_amplitude_finds_the_critical_force() -> None:
    """That of the missile under its full thrust, by the iteration of `rodgen.critical_force`; half
    the last interval is 600/40/6^4/2 N, and four digits are given. Its flight, which the branch
    follows over the number in the expression, begins to flutter there too."""
    scene = Scene.from_toml(SCENES / "missile.toml")
    found = put_together(sweep(scene, ["loads", "follower", "force", "0"], 100.0, 700.0, t=1.0))
    values = [value for value, *_ in found["rows"]]
    assert values == pytest.approx([100 + 15 * at for at in range(COUNT)])
    assert found["critical"] == pytest.approx(rodgen.critical_force(scene, t=1.0).force, abs=0.06)
    for value, growth, _, stable in found["rows"]:
        assert stable == (growth < 0) == (value < found["critical"])
    ((value, kind),) = found["special"]
    assert (value, kind) == (pytest.approx(found["critical"], abs=0.06), "hopf")


@pytest.mark.nightly
def test_sweep_of_a_dead_load_has_its_equilibria() -> None:
    """In the process beside the server, and after the span: the column buckles, and the branch of
    its straight equilibria, whose states lead on from there, has a point where another leaves it.
    """
    aside, told = Aside(), queue.Queue[Answer]()
    scene = Scene.from_toml(SCENES / "euler_column.toml")
    aside.ask("sweep", scene, told.put, path=["loads", "tip", "y"], low=-30.0, high=-1.0, t=1e3)
    parts = []
    while not (answer := told.get(timeout=PATIENT)).last:
        parts.append(answer.value)
    aside.close()
    found = put_together(parts)
    branch = found["branch"]
    assert len(branch["state"][0]) == len(scene.initial_state())
    assert {*branch["away"]} == {0.0}  # straight, but for rounding
    assert [kind for _, kind in found["special"]].count("branch") >= 1
    assert answer.refused == ""


def test_rods_of_very_many_links_are_not_swept() -> None:
    scene = Scene.from_dict({**ROD, "rod": {**ROD["rod"], "links": 300}})
    with pytest.raises(SceneError, match="at most 200 for a sweep"):
        next(sweep(scene, ["loads", "gravity", "g"], 0.0, 1.0, t=0.0))


def test_picture_shows_what_is_stable_and_where_that_ends() -> None:
    points = [Point(0.0, -1.0, True), Point(1.0, 0.5, False), Point(2.0, 3.0, False)]
    one = Diagram("growth", 0.0, 2.0, points)
    svg = ElementTree.fromstring(picture([one], "sweep of P", 0.5, 0.7, []))
    drawn = {line.get("class"): line.get("points") for line in svg.iter("polyline")}
    assert drawn.keys() == {"stable", "unstable"}
    assert "0.7" in [text.text for text in svg.iter("text")]
    assert {"present", "critical"} <= {path.get("class") for path in svg.iter("path")}
    for point in points:
        x, y = one.at(point)
        assert 0 <= x <= WIDTH
        assert 0 <= y <= HEIGHT
        assert one.nearest(x + 1.0, y - 40.0) == point


@pytest.mark.nightly
def test_click_on_a_sweep_takes_the_value_there(view: View) -> None:
    """Of the stability map, at the right end of the range. The critical value, of which
    `rodgen.critical_force` finds the same four digits, is marked on the slider too."""
    view.button("Sweep of follower force P").click()
    swept = view.page.get_by_role("group", name="sweep of follower force P")
    expect(swept.get_by_text("straight")).to_be_visible()
    swept.get_by_role("textbox", name="to").fill("200")
    swept.get_by_role("textbox", name="to").press("Enter")
    view.answered()
    expect(swept.get_by_text("straight")).to_be_visible()
    drawn = swept.locator("svg.rg-sweep")
    drawn.scroll_into_view_if_needed()
    box = drawn.bounding_box()  # of two diagrams, the map above
    view.page.mouse.click(box["x"] + box["width"] - 9, box["y"] + box["height"] / 8)
    expect(view.field("follower force P")).to_have_value("200")
    critical = rodgen.critical_force(Scene.from_dict(ROD)).force
    expect(view.page.get_by_text(f"critical {critical:.4g}", exact=True)).to_be_visible()
    view.button("Sweep of follower force P").click()
    expect(swept).to_have_count(0)
