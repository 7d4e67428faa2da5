"""The page of a run in a browser: each of its parts once, against what Python computes."""

from __future__ import annotations

import json
import re
import time
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from live.tests.conftest import SCENE, make
from live.tests.view import DIGITS, View, expect
from rodgen.scene import Scene, Structure
from rodgen.show.animation.film import animate
from rodgen.show.animation.film_files import find_ffmpeg
from rodgen.system import System
from rodgen_live.run.link import Link
from rodgen_live.run.live_run import LiveRun

pytestmark = pytest.mark.slow  # in a browser
TIMES = 1e-9  # s: between times that are the same but for rounding


def at(t: float) -> rodgen.Solution:
    """The scene at a time [s], without a page."""
    return rodgen.simulate(SCENE, span=[0.0, t], output_every=t, rtol=1e-10)


def test_rod_moves_as_it_is_simulated(view: View) -> None:
    """Steps, a run that is paused and reset; its values, in the panel of values too."""
    expect(view.page.get_by_role("heading", level=1)).to_have_text("rodgen")
    assert view.live("live.t") == 0.0
    view.button("One step").click()
    view.sees("number(live.texts.steps) === 1")
    view.page.keyboard.press(".")
    view.sees("number(live.texts.steps) === 2")
    frames = view.live("live.frames")
    t = view.tab("Values").pause_after(0.5).live("live.t")
    assert view.live("live.frames") > frames + 1
    wanted = at(t)
    view.shows("centre_of_gravity_y", wanted.centre_of_gravity[-1, 1])
    view.shows("kinetic_energy", wanted.energy.kinetic[-1])
    written = view.page.locator("td[data-text=kinetic_energy]")
    expect(written).to_have_text(view.live("live.texts.kinetic_energy"))
    view.button("Reset to").click()
    view.sees("live.t === 0 && live.state === 'paused'")


def test_sliders_and_fields_change_numbers_in_the_simulation(view: View) -> None:
    """While it runs. A thousandth of a slider is one of what it reaches over, here from -3 to 3
    times 9.81 m/s^2; who does not see the slider is told its value. What is refused is said beside
    its field."""
    since = view.run().live("live.t")
    slider = view.page.get_by_role("slider", name="gravity g")
    slider.focus()
    step = 6 * 9.81 / 1000
    for k in range(1, 6):
        view.page.keyboard.press("ArrowRight")
        view.shows("gravity", 9.81 + k * step, near=step / 2 / 9.81)  # it began between two stops
    g = view.live("number(live.texts.gravity)")
    expect(slider).to_have_attribute("aria-valuetext", re.compile(rf"^{g:.4g}"))
    assert float(view.field("gravity g").input_value()) == pytest.approx(g, rel=DIGITS)
    view.fill("mass M", "25")
    view.shows("mass", 25.0).shows("link_mass", 5.0)
    view.sees("live.t > given && live.state === 'running'", since)
    for text in ("abc", "-3", "nan"):
        view.fill("mass M", text)
        view.refuses("mass M")
    view.fill("mass M", "5")
    view.shows("mass", 5.0)
    expect(view.page.locator("[aria-invalid=true]")).to_have_count(0)


def test_structure_is_edited_and_undone(view: View) -> None:
    """Another module is made while the page lives, and the rod goes on by it. What is refused is
    said beside its field."""
    make(Structure(2, inertia="lumped", terms=()))
    view.pause_after(0.1).tab("Scene")
    for field, wrong, right in (("number of links", "0", "5"), ("phi: a number", "sin(", "0.1")):
        view.fill(field, wrong)
        view.button("Apply").click()
        view.refuses(field)
        view.fill(field, right)
    view.fill("number of links", "2")
    view.select("inertia of a link", "lumped")
    for term in SCENE.structure.terms:
        view.page.get_by_role("checkbox", name=term.replace("_", " "), exact=True).click()
    view.button("Apply").click()
    view.sees("live.joints.length === 6 && live.t === 0")
    view.pause_after(0.1)
    view.button("Undo").click()
    view.sees("live.joints.length === 12 && live.t === 0")
    expect(view.field("number of links")).to_have_value("5")


def test_changes_are_undone_and_redone(view: View) -> None:
    """By keys where nothing is typed, and by buttons, which say what; another scene as well."""
    field, scenes = view.field("gravity"), view.page.get_by_role("combobox", name="Scene")
    view.fill("gravity", "3")
    view.shows("gravity", 3.0)
    view.line().focus()
    view.page.keyboard.press("Control+z")
    view.shows("gravity", 9.81)
    expect(field).to_have_value("9.81")
    expect(view.button("Undo")).to_be_disabled()
    expect(view.button("Redo: loads.gravity.g = 3")).to_be_enabled()
    view.page.keyboard.press("Control+Shift+Z")
    view.shows("gravity", 3.0)
    view.select("Scene", "two")
    view.shows("mass", 4.0).shows("gravity", 9.81)
    expect(scenes).to_have_value("two")
    view.button("Undo").click()
    view.shows("mass", 3.0).shows("gravity", 3.0)
    expect(scenes).to_have_value("dart")


def test_plots_have_the_numbers_of_their_quantities(view: View) -> None:
    """In their files, which end where a plot was paused; over time, and one over another. A
    spectrum has rows, too."""
    over_time = view.add_plot("over time", quantities="omega")
    phase = view.add_plot("phase plot", quantity="omega", over="phi")
    t = view.pause_after(0.3).live("live.t")
    view.sees("given.every(id => live.plots[id].rows > 30)", [over_time, phase])
    view.page.get_by_role("button", name="Pause").nth(2).click()  # of the third plot
    view.pause_after(0.3)
    view.sees("live.plots[given].rows > 0", view.add_plot("spectrum", quantity="omega"))
    (_, third), (_, fourth) = view.csv(2), view.csv(3)
    sol = rodgen.simulate(SCENE, span=[0.0, fourth[-1, 0] + 1.0], rtol=1e-10)
    tail = {"omega_4": sol.omega[:, -1], "φ₄": sol.phi[:, -1]}
    assert t - 0.011 < third[-1, 0] <= t < fourth[-1, 0]  # samples are 0.01 s apart
    for rows, columns in ((third, ["omega_4"]), (fourth, ["φ₄", "omega_4"])):
        samples = np.rint(rows[:, 0] / 0.01).astype(int)
        assert rows[:, 0] == pytest.approx(sol.t[samples], abs=TIMES)
        for column, name in enumerate(columns, 1):
            # rtol 1e-8 of the page, over half a second.
            assert rows[:, column] == pytest.approx(tail[name][samples], abs=1e-5)


def test_time_line_looks_back_and_the_rod_goes_on_from_there(view: View) -> None:
    """Rod, values and plots are those of the sample; another run begins in it."""
    view.pause_after(0.3)
    view.line().press("Home")
    view.sees("live.past === 0 && live.t === 0")
    view.shows("kinetic_energy", 0.0)
    view.sees("Object.values(live.plots).every(({ at }) => at === 0)")
    for _ in range(3):
        view.line().press("ArrowRight")
    view.sees("Math.abs(live.past - 0.03) < 1e-9 && live.t === live.past")
    view.shows("kinetic_energy", at(0.03).energy.kinetic[-1])
    view.button("Another run").click()
    view.sees("live.past === null && live.span.every(t => Math.abs(t - 0.03) < 1e-9)")
    t = view.pause_after(0.2).live("live.t")
    assert t > 0.2
    view.shows("kinetic_energy", at(t).energy.kinetic[-1])


def test_rod_is_pulled_by_the_pointer_and_kicked_by_the_keyboard(view: View, run: LiveRun) -> None:
    """By a spring, whose energy F^2/2k is the work of the hand that tightens it, until it lets go;
    and by a dialog, each field of which has the focus in its turn, as a run without a page is."""
    tuned = view.dialog("Kicks and pulls")
    stiffness = float(view.field("spring").input_value())
    view.page.keyboard.press("Escape")
    expect(tuned).to_have_count(0)
    box = view.page.get_by_role("img", name="dart").bounding_box()
    joints = np.reshape(view.live("live.joints"), (-1, 2))
    x, y = joints[2:4].mean(axis=0) + np.array([box["x"], box["y"]])  # of the third link's middle
    view.page.mouse.move(x, y)
    view.page.mouse.down()
    view.page.mouse.move(x, y - 80, steps=8)  # faster than places are sent
    away = "(live.pull[5] / given) * live.scale"  # of the far end, in pixels
    view.sees(f"live.pull.length === 6 && {away} > 60", stiffness)
    link, share, _, _, *force = view.live("live.pull")
    assert (link, share) == (2, pytest.approx(0.5, abs=0.1))  # within two of its 20 pixels
    assert abs(force[0]) < 0.1 * force[1]  # it pulls up
    # Single precision of places some metres away, of a spring as long as 0.3 m.
    view.shows("given", np.dot(force, force) / (2 * stiffness), near=1e-3)
    view.page.mouse.up()
    view.sees("live.pull.length === 0")
    run.submit(lambda: run.kick(3, 0.25, (4.0, 2.0))).result()
    view.button("Kicks and pulls").click()
    view.button("Kick in numbers").focus()
    view.page.keyboard.press("Enter")
    dialog = view.page.get_by_role("dialog", name="Kick", exact=True)
    expect(dialog.get_by_role("textbox", name="link")).to_be_focused()
    for text in ("7", "0.25", "4", "2"):
        view.page.keyboard.press("Control+a")
        view.page.keyboard.type(text)
        view.page.keyboard.press("Tab")
    dialog.get_by_role("button", name="Kick").press("Enter")
    view.refuses("link")
    view.fill("link", "3")
    expect(dialog).to_have_count(0)
    view.shows("kinetic_energy", run.catalogue.columns(["kinetic_energy"], run.shown)[0, 0])


def test_sweep_finds_the_critical_force(view: View) -> None:
    """That of `rodgen.critical_load`; a click on its plot takes the value of a row, at the right
    end that of the range."""
    view.button("Sweep of follower force P").click()
    swept = view.page.get_by_role("group", name="sweep of follower force P", exact=True)
    swept.get_by_role("textbox", name="to").fill("200")
    swept.get_by_role("textbox", name="to").press("Enter")
    critical = rodgen.critical_load(SCENE).value  # four digits are shown
    expect(swept.get_by_role("status")).to_contain_text(f"stable up to {critical:.4g} N")
    view.button("Reset to").click()  # it is of no run
    view.sees("live.plots['loads.follower.force/growth'].seen === 41")
    expect(swept.get_by_role("status")).to_contain_text("N, where flutter begins")
    drawn = view.page.get_by_role("region", name="largest growth").locator("canvas")
    drawn.scroll_into_view_if_needed()
    box = drawn.bounding_box()
    view.page.mouse.click(box["x"] + box["width"] - 16, box["y"] + box["height"] / 4)
    expect(view.field("follower force P")).to_have_value("200")
    view.shows("follower_force", 200.0)
    view.button("Sweep of follower force P").click()
    view.sees("Object.keys(live.plots).length === 2")


def test_modes_are_those_about_the_present_state(view: View) -> None:
    """And, when that is another, of that; the chosen one stays chosen."""

    def hertz(y: Any) -> Any:
        return rodgen.natural_modes(System(SCENE).at(y0=y), 4, frozen=True).frequencies

    first = hertz(SCENE.initial_state())
    # The number, and four digits of its frequency.
    picture = view.page.get_by_role("img", name="dart")
    place = picture.bounding_box()
    told = "live.mode?.match(/mode ([0-9]+): ([0-9.]+) Hz/)?.slice(1).map(Number)"
    near = f"({told} ?? []).every((part, k) => Math.abs(part - given[k]) < 1e-3 * given[k])"
    view.button("Mode shapes").click()
    view.sees(f"{told} && {near}", [1, first[0]])
    view.page.get_by_role("combobox", name="Mode").click()
    view.page.get_by_role("option", name=re.compile("^2: ")).click()
    view.sees(f"{told} && {near}", [2, first[1]])
    t = view.pause_after(0.3).live("live.t")
    view.sees(f"{told} && {near}", [2, hertz(at(t).y[-1])[1]])
    assert picture.bounding_box() == place  # a list that comes does not move it
    view.button("Mode shapes").click()
    view.sees("live.mode === null")


def test_scene_and_run_are_taken_away(view: View, tmp_path: Path) -> None:
    """As they are by then; a link to it holds the scene, and is hidden when that is another. A page
    without a server holds the part that was asked for, of what there was at the click."""
    view.fill("mass M", "25")
    view.shows("mass", 25.0)
    t = view.pause_after(0.2).tab("Save").live("live.t")
    scene = Scene.from_toml(view.download(view.button("Scene as TOML")))
    assert scene == SCENE.replace({"rod.mass": 25.0})
    kept = rodgen.load(view.download(view.button("Run as NetCDF")).rename(tmp_path / "run.nc"))
    assert t - 0.011 < kept.t[-1] <= t  # samples are 0.01 s apart
    assert (kept.scene.rod.mass, kept.changes is None) == (25.0, False)
    view.button("Page without").click()
    expect(view.page.get_by_text("Part of the run for the page")).to_be_visible()
    ends = [view.field("from"), view.field("to")]
    expect(ends[1]).to_have_value(f"{kept.t[-1]:.6g}")
    ends[0].fill("0.1")
    ends[1].fill("0.05")
    view.button("Make").click()
    view.refuses("to")
    ends[1].fill(f"{kept.t[-1]:.6g}")
    archive = zipfile.ZipFile(view.download(view.button("Make")))
    written = archive.read("dart/run.js").decode().partition("=")[2].rstrip(";\n")
    times = json.loads(written)["times"]
    assert (times[0], times[-1]) == (pytest.approx(0.1), pytest.approx(kept.t[-1]))
    view.button("Link").click()
    expect(view.field("link")).to_have_value(re.compile("scene="))
    assert Link.unpack(view.field("link").input_value().partition("scene=")[2]).scene == scene
    view.line().focus()
    view.page.keyboard.press("Control+z")
    view.shows("mass", 3.0)
    expect(view.field("link")).to_be_hidden()


@pytest.mark.skipif(find_ffmpeg() is None, reason="MP4 needs ffmpeg, which is not here")
def test_film_holds_the_part_of_the_run_before_a_module_is_made(view: View, tmp_path: Path) -> None:
    """Asked for while the module is made; the film is that of the samples that were there."""
    view.pause_after(0.3).tab("Save")
    kept = rodgen.load(view.download(view.button("Run as NetCDF")).rename(tmp_path / "run.nc"))
    text = view.tab("Text").field("Text of the scene")
    # A state that no scene has had: its module is in no cache.
    other = f"\n[states.lag_{time.time_ns()}]\nrate = 0.0\n"
    text.fill(text.input_value().replace("links = 5", "links = 1") + other)
    view.page.get_by_role("button", name="Apply").filter(visible=True).click()
    expect(view.page.get_by_text("dart, 1 link: ")).to_be_visible()
    view.tab("Save").button("Film as MP4").click()
    expect(view.field("to")).to_have_value(f"{kept.t[-1]:.6g}")
    view.field("from").fill("0.1")
    view.field("to").fill("0.2")
    view.sees("live.t === 0")
    made = view.download(view.button("Make"))
    expect(view.page.get_by_text("11 samples, t = 0.1 s to 0.2 s")).to_be_visible()
    animate(kept.isel(slice(10, 21)), film := tmp_path / "film.mp4")
    assert made.read_bytes() == film.read_bytes()


def test_page_tells_that_its_server_has_ended(serve: Any, blank: View, folder: Path) -> None:
    """Which it does at once, and well, while the rod moves."""
    served = serve(folder / "dart.toml")
    blank.open(served.address).run()
    served.end()
    blank.sees("!live.connected")
    expect(blank.page.get_by_role("alert").filter(has_text=re.compile(r"\S")).first).to_be_visible()
