"""Keys of the page, kicks in numbers, scenes of a folder, and what another scene changes."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

View = Any  # see conftest.py
NARROW = {"width": 390, "height": 844}
SCENE = """
name = "{name}"
[rod]
links = {links}
length = 1.0
bending_stiffness = 10.0
mass = {mass}
boundary = "{boundary}"
[integrate]
span = [0.0, 1.0]
"""
# All that is written into pictures, in window.written.
WRITTEN = """
    window.written = [];
    const fill = CanvasRenderingContext2D.prototype.fillText;
    CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
        window.written.push(text);
        return fill.call(this, text, ...place);
    };
"""


def scene(
    path: Path, *, name: str = "rod", links: int = 4, mass: float = 2.0, boundary: str
) -> str:
    path.write_text(SCENE.format(name=name, links=links, mass=mass, boundary=boundary))
    return str(path)


def written(view: View, form: str) -> list[str]:
    """What was written into pictures, of that form, since the last question."""
    texts = view.page.evaluate("window.written.splice(0)")
    return [text for text in texts if re.fullmatch(form, text)]


def held(view: View, state: str) -> None:
    """The run is in that state, and still is a moment later."""
    view.until(lambda: view.page.evaluate("rodgenLive.state") == state, f"not {state}")
    view.page.wait_for_timeout(300)
    assert view.page.evaluate("rodgenLive.state") == state


GROUND = "getComputedStyle(document.body).backgroundColor"
BACKGROUNDS = f"""
    window.grounds = [];
    const look = () => {{
        const ground = document.body && {GROUND};
        if (ground && grounds.at(-1) !== ground) grounds.push(ground);
        requestAnimationFrame(look);
    }};
    look();
"""


def dark(view: View) -> bool:
    return bool(view.page.evaluate("document.body.classList.contains('body--dark')"))


# Keys ------------------------------------------------------------------------------------------


def test_space_does_one_thing(view: View) -> None:
    """It selects a tab that has the focus; elsewhere it runs, and a click on a tab is no focus."""
    view.page.get_by_role("tab", name="Scene").focus()
    view.page.keyboard.press("Space")
    view.page.get_by_role("tab", name="Scene", selected=True).wait_for()
    held(view, "paused")
    view.tab("Values")
    view.page.keyboard.press("Space")
    held(view, "running")
    view.page.locator(".rodgen-chart").first.focus()
    view.page.keyboard.press("Space")
    held(view, "paused")


def test_space_does_not_scroll(server: Any, blank: View) -> None:
    blank.page.set_viewport_size(NARROW)
    blank.open(server.address)
    assert blank.page.evaluate("document.documentElement.scrollHeight") > NARROW["height"]
    blank.page.get_by_role("img", name="missile").focus()
    before = blank.page.evaluate("scrollY")
    blank.page.keyboard.press("Space")
    held(blank, "running")
    assert blank.page.evaluate("scrollY") == before


def test_keys_that_are_held_or_meant_for_others(view: View) -> None:
    keyboard, first = view.page.keyboard, dark(view)
    keyboard.press("Alt+d")
    keyboard.press("Control+.")
    view.field("mass M").focus()
    keyboard.press("d")
    view.page.get_by_role("tab", name="Values").click()
    view.page.wait_for_timeout(300)
    assert dark(view) is first
    for _ in range(3):
        keyboard.down("d")  # all but the first are repeats
    view.until(lambda: dark(view) is not first, "d does nothing")
    view.page.wait_for_timeout(300)
    assert dark(view) is not first
    keyboard.up("d")
    for _ in range(3):
        keyboard.down(".")
    view.until(lambda: view.text("steps") == "3", "a held . is no more steps")


def test_light_or_dark_stays_over_a_reload(view: View) -> None:
    view.button("Light or dark").click()
    view.until(dark.__get__(view), "not dark")
    view.page.add_init_script(BACKGROUNDS)
    view.page.reload()
    view.ready()
    view.until(dark.__get__(view), "light again")
    assert view.page.evaluate("grounds") == [view.page.evaluate(GROUND)]  # nor did it flash


def test_state_alone_is_said(view: View) -> None:
    """A screen reader is not told the time five times a second, but can ask for it."""
    statuses = view.page.get_by_role("status")
    assert statuses.locator("[data-text]").count() == 0
    assert statuses.filter(has_text="paused").count() == 1
    for name in ("time", "ratio"):
        assert view.page.get_by_role("group", name=name).locator("[data-text]").count() == 1


# Kicks -----------------------------------------------------------------------------------------


def test_kick_by_the_keyboard(serve: Callable[..., Any], blank: View, tmp_path: Path) -> None:
    """A rigid rod at rest, M = 2 kg, L = 1 m, is given J = (4, 2) N s at its end: Jx^2/2M = 4 J,
    Jy^2/2M = 1 J, and (Jy L/2)^2/2I = 3 J with I = M L^2/12."""
    path = scene(tmp_path / "rigid.toml", links=1, boundary="free")
    blank.open(serve(path, "--port", "0").address).tab("Values")
    keyboard = blank.page.keyboard
    blank.button("Kick").focus()
    keyboard.press("Enter")
    blank.page.locator("input:focus").wait_for()
    for text in ("3", "1", "4", "nan"):
        keyboard.press("Control+a")
        keyboard.type(text)
        keyboard.press("Tab")
    refused = blank.page.locator(".q-dialog .q-field__messages")
    blank.page.get_by_role("dialog").get_by_role("button", name="Kick").press("Enter")
    refused.filter(has_text="must be a number").wait_for()
    blank.fill("impulse along y", "2")
    refused.filter(has_text="from 0 to 0").wait_for()
    blank.fill("link", "0")
    blank.page.get_by_role("dialog").wait_for(state="detached")
    blank.until(lambda: float(blank.text("kinetic_energy")) == pytest.approx(8.0), "another kick")


def test_click_on_a_link_asks_in_kick_mode_alone(view: View) -> None:
    box = view.page.get_by_role("img", name="missile").bounding_box()
    assert box is not None
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    view.page.mouse.click(*middle)
    view.page.wait_for_timeout(300)
    assert view.page.locator(".q-notification, .q-dialog").count() == 0
    view.page.get_by_role("switch", name="kick").click()
    view.field("N s per metre").wait_for()
    view.page.mouse.click(*middle)
    # The missile is straight but for a little, and its centre of gravity is in the middle.
    view.until(lambda: view.field("link").input_value() in ("9", "10"), "another link")


# Scenes ----------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two scenes of one name and structure, and one that is none."""
    scene(tmp_path / "one.toml", boundary="clamped")
    scene(tmp_path / "two.toml", mass=3.0, boundary="clamped")
    (tmp_path / "bad.toml").write_text("name = 3")
    return tmp_path


@pytest.fixture
def clamped(serve: Callable[..., Any], blank: View, folder: Path) -> View:
    """The page of the first."""
    blank.page.add_init_script(WRITTEN)
    return blank.open(serve(str(folder / "one.toml"), "--port", "0").address)


def listed(view: View) -> str:
    """What the list of scenes shows."""
    return str(view.page.locator(".rg-scenes .q-field__native").inner_text()).strip()


def choose(view: View, name: str) -> None:
    view.page.get_by_role("combobox", name="Scene").click()
    view.page.get_by_role("option", name=name, exact=True).click()


def has_mass(view: View, mass: str) -> None:
    view.until(lambda: view.field("mass M").input_value() == mass, f"not {mass} kg")


def test_scenes_are_listed_by_file_and_can_be_had_again(clamped: View) -> None:
    assert listed(clamped) == "one"
    choose(clamped, "two")
    has_mass(clamped, "3")
    assert listed(clamped) == "two"
    clamped.fill("mass M", "7")
    clamped.button("Reset to").click()
    clamped.page.wait_for_timeout(300)
    has_mass(clamped, "7")  # as the reset leaves what was changed
    clamped.page.reload()
    clamped.ready()
    has_mass(clamped, "7")
    assert listed(clamped) == "two"
    clamped.button("Load two again").click()
    has_mass(clamped, "3")
    choose(clamped, "one")
    has_mass(clamped, "2")


def test_refused_scene_does_not_stay_in_the_list(clamped: View) -> None:
    for _ in range(2):  # the second is a change again
        choose(clamped, "bad")
        note = clamped.page.locator(".q-notification")
        note.filter(has_text="name = 3").wait_for()
        clamped.until(lambda: listed(clamped) == "one", "the refused one is shown")
        clamped.page.locator(".q-notification button").last.click()
        clamped.until(lambda: clamped.page.locator(".q-notification").count() == 0, "still said")
    has_mass(clamped, "2")


def test_uploaded_scene_is_none_of_the_folder(clamped: View, folder: Path) -> None:
    path = scene(folder.parent / "three.toml", name="one", mass=5.0, boundary="clamped")
    clamped.tab("Scene").page.locator("input[type=file]").set_input_files(path)
    clamped.until(lambda: listed(clamped) == "one (other)", "shown as a file of the folder")
    clamped.tab("Parameters")
    has_mass(clamped, "5")
    choose(clamped, "one")
    has_mass(clamped, "2")


BAR = r"[\d.]+ m"  # the scale


def test_parameter_leaves_the_picture_and_another_scene_does_not(clamped: View) -> None:
    """The strength of kicks and the zoom: kept when the clamp turns, anew for another scene."""
    clamped.page.get_by_role("switch", name="kick").click()
    strength = clamped.field("N s per metre")
    assert strength.input_value() == "2"  # of 2 kg
    clamped.fill("N s per metre", "0.5")
    fitted = written(clamped, BAR)[-1]
    clamped.page.get_by_role("img", name="rod").focus()
    for _ in range(12):  # 1.25^12 = 15
        clamped.page.keyboard.press("+")
    clamped.page.wait_for_timeout(300)
    assert written(clamped, BAR)[-1] != fitted
    clamped.fill("clamp angle", "0.3")
    clamped.run()
    clamped.until(lambda: clamped.live("t") > 0.2, "time does not pass")
    clamped.pause()
    assert fitted not in written(clamped, BAR)
    assert strength.input_value() == "0.5"
    choose(clamped, "two")
    clamped.until(lambda: strength.input_value() == "3", "the strength of the scene before")
    clamped.until(lambda: fitted in written(clamped, BAR), "the view of the scene before")


def test_time_in_the_picture_has_the_digits_of_a_step(clamped: View) -> None:
    clamped.page.get_by_role("combobox", name="method").click()
    clamped.page.get_by_role("option", name="rk4", exact=True).click()
    clamped.fill("step", "0.0001")
    clamped.button("One step").click()
    time = r"t = [\d.]+ s"
    clamped.until(lambda: "t = 0.0001 s" in written(clamped, time), "not 0.1 ms")
    clamped.run()
    clamped.until(lambda: clamped.live("t") > 0.3, "time does not pass")
    written(clamped, time)
    clamped.until(lambda: clamped.live("t") > 0.6, "time does not pass")
    shown = written(clamped, time)
    # Frames are 16.7 ms apart: two decimals tell them, one more where some come sooner.
    assert shown
    assert all(len(text.split(".")[1]) <= len("123 s") for text in shown), shown
