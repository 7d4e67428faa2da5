"""What a newcomer does in the browser: see flutter, write a scene."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from live.tests.conftest import PHONE, SCENE, make
from live.tests.view import View, expect, until
from rodgen.scene import Scene

pytestmark = pytest.mark.slow  # in a browser
SELECTED = "area => area.value.slice(area.selectionStart, area.selectionEnd)"


def test_text_of_the_scene_is_edited(view: View) -> None:
    """A refusal tells its line and selects it; what is applied is what is saved, with comments."""
    text = view.tab("Text").field("Text of the scene")
    written = text.input_value()
    for mass in ("-3.0", "4.0"):
        text.fill(f"# Mine.\n{written.replace('mass = 3.0', f'mass = {mass}  # kg')}")
        view.page.get_by_role("button", name="Apply").filter(visible=True).click()
        if mass == "-3.0":
            told = view.page.get_by_role("alert").filter(has_text="rod.mass")
            line = written[: written.index("mass = 3.0")].count("\n") + 2
            expect(told).to_have_text(re.compile(f"Line {line}: "))
            until(lambda: text.evaluate(SELECTED), "mass = -3.0  # kg", "not selected")
    view.shows("mass", 4.0)
    expect(view.page.get_by_text("Mine.", exact=True)).to_be_visible()
    saved = view.tab("Save").download(view.button("Scene as TOML")).read_text()
    assert saved == f"# Mine.\n{written.replace('mass = 3.0', 'mass = 4.0  # kg')}"


def test_file_that_is_opened_is_loaded_again_and_no_change_is_lost_to_a_text(view: View) -> None:
    """A refusal of it tells its line; a text of before a change takes two presses."""

    def open_file(text: str) -> None:
        with view.page.expect_file_chooser() as chosen:
            view.button("Open a file").click()
        payload = {"name": "mine.toml", "mimeType": "text/plain", "buffer": text.encode()}
        chosen.value.set_files([payload])

    written = "# Mine.\n" + SCENE.replace({"rod.mass": 4.0}).to_toml()
    open_file(written.replace("mass = 4.0", "mass = -4.0"))
    line = written[: written.index("mass = 4.0")].count("\n") + 1
    expect(view.page.get_by_text(re.compile(f"^Line {line}: .*rod.mass"))).to_be_visible()
    open_file(written)
    view.tab("Parameters").shows("mass", 4.0)
    text = view.tab("Text").field("Text of the scene")
    expect(text).to_have_value(written)
    text.fill(written.replace("mass = 4.0", "mass = 6.0"))
    view.tab("Parameters").fill("mass M", "5")
    view.shows("mass", 5.0)
    view.tab("Text")
    apply = view.page.get_by_role("button", name="Apply").filter(visible=True)
    apply.click()
    expect(view.page.get_by_role("alert").filter(has_text="was changed")).to_be_visible()
    view.shows("mass", 5.0)
    apply.click()
    view.shows("mass", 6.0)
    view.page.get_by_role("button", name=re.compile(r"^Load .* \(opened\) again")).click()
    view.shows("mass", 4.0)


def test_file_that_has_gone_is_refused_and_the_run_stays(
    serve: Any, blank: View, tmp_path: Path
) -> None:
    file = tmp_path / "dart.toml"
    file.write_text(SCENE.to_toml(), encoding="utf-8")
    view = blank.open(serve(file).address).tab("Parameters")
    file.unlink()
    view.page.get_by_role("button", name="Load dart again").click()
    expect(view.page.get_by_role("alert").filter(has_text="dart")).to_be_visible()
    view.shows("mass", SCENE.rod.mass)


@pytest.mark.parametrize("size", [{"width": 1280, "height": 1000}, PHONE], ids=["screen", "phone"])
def test_first_job_of_a_newcomer_takes_four_actions(serve: Any, blank: View, size: Any) -> None:
    """See flutter, its phase plot and its spectrum. The list of scenes says what each is."""
    make(Scene.example("flutter").structure)
    blank.page.set_viewport_size(size)
    actions = ["the command"]
    view = blank.open(serve("--moving").address)
    told = re.compile("^Raise the follower force, the thrust, beyond 10.7 N")
    expect(view.page.get_by_text(told)).to_be_visible()
    expect(view.page.get_by_text("critical 10.71")).to_be_visible()

    actions += ["a drag"]
    slider = view.page.get_by_role("slider", name="follower force P")
    expect(slider).to_be_in_viewport()
    box = slider.bounding_box()
    across, along = box["y"] + box["height"] / 2, box["x"] + box["width"] * np.array([0.66, 0.96])
    view.page.mouse.move(along[0], across)
    view.page.mouse.down()
    view.page.mouse.move(along[1], across, steps=5)
    view.page.mouse.up()
    view.sees("number(live.texts.follower_force) > 14")
    raised = view.live("live.t")

    actions += ["a button"]
    flutter = view.page.get_by_role("button", name="Flutter", exact=True)
    expect(flutter).to_be_in_viewport()
    for _ in range(2):  # the second time they are there
        flutter.click()
    heads = view.page.get_by_role("heading", level=3)
    expect(heads).to_have_count(5)
    for number, name in enumerate(("tail", "phase plot", "spectrum of the tail")):
        expect(heads.nth(number)).to_have_text(name)  # they come one by one
    for name in ("tail", "phase plot")[: 1 if size == PHONE else 2]:
        expect(view.page.get_by_role("heading", name=name, exact=True)).to_be_in_viewport()
    view.sees("live.t > given", raised + 5.0)
    aside = abs(view.csv(0)[1][:, 1])
    assert aside.max() > 1.1 * aside[0]  # below the critical force it was largest at the start

    actions += ["scrolling"]
    heads.filter(has_text="spectrum").scroll_into_view_if_needed()
    assert len(actions) <= 4
    view.page.get_by_role("combobox", name="Scene").click()
    listed = view.page.get_by_role("listbox")
    assert listed.get_by_text("follows its direction").count() == 1
    assert listed.evaluate("list => { list.scrollTop = 300; return list.scrollTop }") == 300
