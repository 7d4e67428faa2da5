"""The page in a real browser: what is done in it reaches the run, and the other way round.

Most of it is long: what the page asks of a run, and what it is given, is tested in Python.
"""

from __future__ import annotations

import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rodgen
from rodgen.scene import Scene
from tests.live.conftest import ROD, varied

NARROW = {"width": 390, "height": 844}
View = Any  # see conftest.py


def held(view: View, state: str) -> None:
    """The run is in that state, and still is when the page has answered once more."""
    view.until(lambda: view.page.evaluate("rodgenLive.state") == state, f"not {state}")
    view.page.wait_for_timeout(300)
    assert view.page.evaluate("rodgenLive.state") == state


def dark(view: View) -> bool:
    return bool(view.page.evaluate("document.body.classList.contains('body--dark')"))


def has_mass(view: View, mass: str) -> None:
    view.until(lambda: view.field("mass M").input_value() == mass, f"not {mass} kg")


def said_and_closed(view: View, text: str) -> None:
    """A note that is shown, until it is closed."""
    notes = view.page.locator(".q-notification")
    notes.filter(has_text=text).last.wait_for()
    view.page.locator(".q-notification button").last.click()
    view.until(lambda: notes.count() == 0, "still said")


# The run ---------------------------------------------------------------------------------------


def test_state_drawn_is_that_of_simulate(view: View) -> None:
    """Steps, a run that is paused and reset; values that the page shows against a run of the same
    scene without a page."""
    assert view.live("t") == 0.0
    view.tab("Values").button("One step").click()
    view.until(lambda: view.text("steps") == "1", "no step")
    view.page.keyboard.press(".")
    view.until(lambda: view.text("steps") == "2", "no second step")
    view.pause_after(0.5)
    held(view, "paused")
    # Of times, hundredths are shown.
    view.until(lambda: abs(float(view.text("t")) - view.live("t")) < 0.0051, "texts are late")
    t = view.live("t")
    sol = rodgen.simulate(Scene.from_dict(ROD), span=[0.0, t], output_every=t, rtol=1e-10)
    # Five digits are shown: half of the last one is 5e-5 of a number that begins with 1.
    height, kinetic = sol.centre_of_gravity[-1, 1], sol.energy.kinetic[-1]
    assert float(view.text("centre_of_gravity_y")) == pytest.approx(height, rel=5.1e-5)
    assert float(view.text("kinetic_energy")) == pytest.approx(kinetic, rel=5.1e-5)
    assert view.live("t") == t
    view.button("Reset to").click()
    view.until(lambda: view.live("t") == 0.0, "not reset")


def test_sliders_and_fields_change_numbers_in_the_simulation(view: View) -> None:
    """What is no number, or not allowed, is refused beside its field, and the run goes on."""
    view.run()
    slider = view.page.get_by_role("slider", name="gravity g")
    box = slider.bounding_box()
    middle = box["y"] + box["height"] / 2
    view.page.mouse.move(box["x"] + box["width"] * 2 / 3, middle)
    view.page.mouse.down()
    for share in (0.7, 0.8, 0.9):
        view.page.mouse.move(box["x"] + box["width"] * share, middle)
        view.page.wait_for_timeout(60)
    view.page.mouse.up()

    def typed() -> float:
        return float(view.field("gravity g").input_value())

    # 90 % of the way from -3 to 3 times 9.81, and the pointer's half of the knob.
    view.until(lambda: 20.0 < typed() < 29.5, "the field does not follow")
    for text, said in (("abc", "must be a number"), ("-3", "greater than"), ("nan", "must be")):
        view.fill("mass M", text)
        view.page.locator(".q-field__messages", has_text=said).first.wait_for()
    wanted = pytest.approx(typed(), rel=1e-4)
    view.tab("Values")
    view.until(lambda: float(view.text("gravity")) == wanted, "unchanged")
    assert float(view.text("mass")) == 3.0
    t = view.live("t")
    view.until(lambda: view.live("t") > t, "the run does not go on")


@pytest.mark.long
def test_blow_up_is_told_in_words_and_can_be_mended(view: View) -> None:
    """First by another step; from a state beyond use by a reset alone."""
    view.select("method", "euler")
    view.fill("step", "0.2")
    view.button("One step").click()
    alert = view.page.get_by_role("alert").filter(has_text="Stopped at t =")

    def stopped() -> bool:
        view.page.keyboard.press(".")
        return bool(alert.is_visible())

    view.until(stopped, "it does not blow up")
    assert "Reset it" in alert.text_content()
    assert "go on from there" not in alert.text_content()
    view.fill("step", "0.0001")
    view.button("Reset to").click()
    view.run()
    view.until(lambda: view.live("t") > 0.1, "it does not run again")


@pytest.mark.long
def test_scene_run_film_and_link_are_taken_away(
    view: View, another: Callable[[], View], tmp_path: Path
) -> None:
    view.fill("mass M", "25")
    view.pause_after(0.3).tab("Save")
    names = {"Scene as TOML": "dart.toml", "Run as NetCDF": "dart.nc", "Animation as GIF": "a.gif"}
    files = {}
    for text, name in names.items():
        with view.page.expect_download(timeout=60_000) as waiting:
            view.button(text).click()
        files[text] = tmp_path / name
        waiting.value.save_as(files[text])
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
    view.until(lambda: "scene=" in link.input_value(), "no link")
    other = another().open(link.input_value())
    assert other.field("mass M").input_value() == "25"
    assert link.is_visible()
    view.tab("Parameters").fill("mass M", "24")
    view.tab("Save")
    view.until(lambda: not link.is_visible(), "a link to what was before is still shown")


@pytest.mark.long
def test_another_structure_is_made_while_the_page_lives(view: View) -> None:
    view.tab("Scene").fill("number of links", "1")
    view.page.get_by_role("checkbox", name="tip load").click()
    view.button("Apply").click()
    view.tab("Values")
    view.until(lambda: view.text("links") == "1", "not made")
    view.run()
    view.until(lambda: view.live("t") > 0.2, "it does not run")
    view.tab("Scene").fill("number of links", "0")
    view.button("Apply").click()
    view.page.locator(".q-field__messages", has_text="whole number from 1").wait_for()
    view.page.wait_for_timeout(300)
    assert view.page.locator(".q-notification").count() == 0  # it is said once
    view.fill("number of links", "1")
    view.fill("phi: a number", "sin(")
    view.button("Apply").click()
    wrong = view.page.locator(".q-field--error")
    view.until(lambda: "phi" in (wrong.first.text_content() or ""), "not said beside the field")
    assert wrong.count() == 1  # the number of links is not at fault any more
    view.fill("phi: a number", "0")
    view.fill("position", "1e308,0")  # a part of a list
    view.button("Apply").click()
    wrong.filter(has_text="position").filter(has_text="must be at most").wait_for()
    assert view.page.locator(".q-notification").count() == 0


@pytest.mark.long
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
    for name, text in {
        "mass of tank": "2",
        "place s of tank": "0.25",
        "centre across the link of tank": "0.1",
        "fixed point in y of support 1": "0.3",
        "stiffness of the foundation": "4 + 2*s",
        "rate of valve": "-3*valve",
    }.items():
        view.fill(name, text)
    said = view.page.locator(".q-field__messages", has_text="at least 0")

    def refused() -> bool:
        """Typed again where a panel that was drawn anew has taken it away."""
        view.fill("stiffness in y of support 1", "-5")
        view.page.wait_for_timeout(500)
        return said.is_visible()

    view.until(refused, "a negative stiffness is not refused")
    view.tab("Scene").fill("valve at the start", "0.5")
    view.button("Apply").click()
    view.tab("Save")
    text = view.download(view.button("Scene as TOML")).read_text()
    kept = tomllib.loads(text)
    assert kept["bodies"][0] | {"mass": 2.0, "at": 0.25, "offset": [0.0, 0.1]} == kept["bodies"][0]
    assert kept["supports"][0]["to"] == [ROD["rod"]["length"], 0.3]
    assert kept["supports"][0]["stiffness"] == [0.0, 5.0]
    assert kept["foundation"]["stiffness"] == "4 + 2*s"
    assert kept["states"]["valve"] == {"rate": "-3*valve", "initial": 0.5}


@pytest.mark.long
def test_two_pages_have_their_own_runs_and_reload_keeps_them(
    view: View, server: Any, another: Callable[[], View]
) -> None:
    """With view, panel and shade as they were."""
    other = another().open(server.address)
    first = dark(view)
    view.button("Light or dark").click()
    view.until(lambda: dark(view) is not first, "the shade stays")
    view.tab("Scene")
    view.select("View", "turns with the axes")
    view.run()
    view.until(lambda: view.live("t") > 0.5, "time does not pass")
    assert other.live("t") == 0.0
    view.page.add_init_script(BACKGROUNDS)
    view.page.reload()
    view.ready()
    assert view.live("t") > 0.5
    view.button("Pause (").wait_for()
    view.page.get_by_role("tab", name="Scene", selected=True).wait_for()
    assert "turns with the axes" in view.page.locator(".rg-view").inner_text()
    view.until(lambda: dark(view) is not first, "the first shade again")
    assert view.page.evaluate("grounds") == [view.page.evaluate(GROUND)]  # nor did it flash
    assert other.live("t") == 0.0


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


# Keys and the pointer --------------------------------------------------------------------------


@pytest.mark.long
def test_keys(view: View) -> None:
    """Space selects a tab that has the focus; elsewhere it runs, and a click on a tab is no focus.
    Of keys that are held the first counts, of steps every one; none counts that is typed or the
    browser's."""
    keyboard, first = view.page.keyboard, dark(view)

    def steps() -> int:
        return int(view.text("steps").replace("\u202f", ""))  # between thousands

    view.page.get_by_role("tab", name="Scene").focus()
    keyboard.press("Space")
    view.page.get_by_role("tab", name="Scene", selected=True).wait_for()
    held(view, "paused")
    view.tab("Values")
    keyboard.press("Space")
    held(view, "running")
    view.page.locator(".rodgen-chart").first.focus()
    keyboard.press("Space")
    held(view, "paused")
    view.button("Reset to").click()
    keyboard.press("Alt+d")
    keyboard.press("Control+.")
    view.tab("Parameters").field("mass M").focus()
    keyboard.press("d")
    view.tab("Values").page.wait_for_timeout(300)
    assert dark(view) is first
    for _ in range(3):
        keyboard.down("d")  # all but the first are repeats
    view.until(lambda: dark(view) is not first, "d does nothing")
    view.page.wait_for_timeout(300)
    assert dark(view) is not first
    keyboard.up("d")
    before = steps()
    for _ in range(3):
        keyboard.down(".")
    view.until(lambda: steps() == before + 3, "a held . is no more steps")


@pytest.mark.long
def test_click_on_a_link_asks_in_kick_mode_alone(view: View) -> None:
    box = view.page.get_by_role("img", name="dart").bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    view.page.mouse.click(*middle)
    view.page.wait_for_timeout(300)
    assert view.page.locator(".q-notification, .q-dialog").count() == 0
    view.page.get_by_role("switch", name="kick").click()
    view.field("N s per metre").wait_for()
    view.page.mouse.click(*middle)
    # The rod is straight but for a little, and its centre of gravity is in the middle.
    view.until(lambda: view.field("link").input_value() == "2", "another link")


@pytest.mark.long
def test_kick_by_the_keyboard(
    serve: Callable[..., Any], blank: View, scene_file: Callable[..., Path]
) -> None:
    """A rigid rod at rest, M = 2 kg, L = 1 m, is given J = (4, 2) N s at its end: Jx^2/2M = 4 J,
    Jy^2/2M = 1 J, and (Jy L/2)^2/2I = 3 J with I = M L^2/12."""
    path = scene_file("rigid", links=1)
    blank.open(serve(str(path), "--port", "0").address).tab("Values")
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


@pytest.mark.long
def test_space_does_not_scroll(server: Any, blank: View) -> None:
    blank.page.set_viewport_size(NARROW)
    blank.open(server.address)
    assert blank.page.evaluate("document.documentElement.scrollHeight") > NARROW["height"]
    blank.page.get_by_role("img", name="dart").focus()
    before = blank.page.evaluate("scrollY")
    blank.page.keyboard.press("Space")
    held(blank, "running")
    assert blank.page.evaluate("scrollY") == before


# Scenes ----------------------------------------------------------------------------------------


def listed(view: View) -> str:
    """What the list of scenes shows."""
    return str(view.page.locator(".rg-scenes .q-field__native").inner_text()).strip()


@pytest.mark.long
def test_scenes_are_listed_by_file_and_can_be_had_again(view: View, tmp_path: Path) -> None:
    """One that is refused does not stay in the list, and one from elsewhere is none of it."""
    tomli_w = pytest.importorskip("tomli_w")
    assert listed(view) == "dart"
    view.select("Scene", "two")
    has_mass(view, "4")
    assert listed(view) == "two"
    for _ in range(2):  # the second is a change again
        view.select("Scene", "bad")
        said_and_closed(view, "name = 3")
        view.until(lambda: listed(view) == "two", "the refused one is shown")
    view.fill("mass M", "7")
    view.button("Reset to").click()
    view.page.wait_for_timeout(300)
    has_mass(view, "7")  # as the reset leaves what was changed
    view.page.reload()
    view.ready()
    has_mass(view, "7")
    assert listed(view) == "two"
    view.button("Load two again").click()
    has_mass(view, "4")
    good = tomli_w.dumps({**varied(mass=5.0), "name": "one"})
    files = {
        "evil": good.replace("0.2*cos(pi*s)", "__import__('os').system('x')"),
        "large": good + "#" * 2**20,
        "binary": "\x00\x01",
        "elsewhere": good,
    }
    chooser = view.tab("Scene").page.locator("input[type=file]")
    for name, text in files.items():
        (tmp_path / f"{name}.toml").write_text(text)
        chooser.set_input_files(tmp_path / f"{name}.toml")
        if name != "elsewhere":
            said_and_closed(view, "")
            assert listed(view) == "two"
    view.until(lambda: listed(view) == "one (other)", "shown as a file of the folder")
    view.tab("Parameters")
    has_mass(view, "5")


# All that is written into pictures, in window.written.
WRITTEN = """
    window.written = [];
    const fill = CanvasRenderingContext2D.prototype.fillText;
    CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
        window.written.push(text);
        return fill.call(this, text, ...place);
    };
"""


@pytest.mark.long
def test_parameter_leaves_the_picture_and_another_scene_does_not(blank: View, server: Any) -> None:
    """The strength of kicks and the zoom: kept when the rod is made softer, anew for another
    scene."""

    def scales() -> list[str]:
        """What was written into pictures since the last question, of the form of the scale."""
        texts = blank.page.evaluate("window.written.splice(0)")
        return [text for text in texts if text.endswith(" m") and text[0].isdigit()]

    blank.page.add_init_script(WRITTEN)
    blank.open(server.address)
    blank.page.get_by_role("switch", name="kick").click()
    strength = blank.field("N s per metre")
    assert strength.input_value() == "3"  # of 3 kg
    blank.fill("N s per metre", "0.5")
    fitted = scales()[-1]
    blank.page.get_by_role("img", name="dart").focus()
    for _ in range(12):  # 1.25^12 = 15
        blank.page.keyboard.press("+")
    blank.page.wait_for_timeout(300)
    assert scales()[-1] != fitted
    blank.fill("bending stiffness EI", "4")
    blank.pause_after(0.2)
    assert fitted not in scales()
    assert strength.input_value() == "0.5"
    blank.select("Scene", "two")
    blank.until(lambda: strength.input_value() == "4", "the strength of the scene before")
    blank.until(lambda: fitted in scales(), "the view of the scene before")


# What goes wrong -------------------------------------------------------------------------------


@pytest.mark.long
def test_what_cannot_be_written_is_said(
    serve: Callable[..., Any],
    another: Callable[[], View],
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A folder for temporary files that is gone stands for a full disk."""
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    monkeypatch.setenv("TMPDIR", str(temporary))
    served = serve(str(folder / "dart.toml"), "--port", "0")
    view = another().open(served.address).tab("Save")
    temporary.rmdir()
    view.button("Run as NetCDF").click()
    view.page.get_by_text("No such file").wait_for()
    temporary.mkdir()
    with view.page.expect_download() as waiting:  # it can be done again
        view.button("Run as NetCDF").click()
    assert waiting.value.path().stat().st_size > 0
    view.page.get_by_text("dart.nc: ").wait_for()
    with view.page.expect_download():  # one file at a time is kept
        view.button("Run as NetCDF").click()
    assert len(list(temporary.glob("rodgen-*"))) == 1
    view.page.close()
    another().until(lambda: not list(temporary.glob("rodgen-*")), "the file is kept", 20.0)


@pytest.mark.long
def test_defect_is_said_on_the_page(blank: View, folder: Path, tmp_path: Path) -> None:
    """An event that no browser sends raises what nobody expects."""
    command = [Path(sys.executable).with_name("rodgen"), "view", folder / "dart.toml"]
    with open(tmp_path / "said", "w") as said:
        process = subprocess.Popen(
            [*command, "--port", "0", "--no-open"],
            stdout=subprocess.PIPE,
            stderr=said,
            text=True,
        )
        with process:
            assert process.stdout is not None
            blank.open(next(word for word in process.stdout.readline().split() if "://" in word))
            canvas = blank.page.get_by_role("img", name="dart")
            identity = canvas.evaluate("e => e.closest('[id^=c]').id.slice(1)")
            blank.page.evaluate(f"getElement({identity}).$emit('kick', {{link: 'x'}})")
            blank.page.locator(".q-notification", has_text="rodgen has failed").wait_for()
            process.send_signal(signal.SIGINT)
    assert "Traceback" in (tmp_path / "said").read_text()
