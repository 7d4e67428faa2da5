"""The page in a real browser: what is done in it reaches the run, and the other way round."""

from __future__ import annotations

import csv
import io
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest

import rodgen

SCENES = Path(__file__).parents[2] / "scenes"
NARROW = {"width": 390, "height": 844}
View = Any  # see conftest.py


def test_run_moves_and_pause_holds(view: View) -> None:
    assert view.live("t") == 0.0
    view.run()
    view.until(lambda: view.live("t") > 0.5, "time does not pass")
    view.pause()
    t = view.live("t")
    view.page.wait_for_timeout(400)
    assert view.live("t") == t
    view.button("Reset to").click()
    view.until(lambda: view.live("t") == 0.0, "not reset")


def test_state_drawn_is_that_of_simulate(view: View) -> None:
    """Values that the page shows against a run of the same scene without a page."""
    view.tab("Values").run()
    view.until(lambda: view.live("t") > 1.0, "time does not pass")
    view.pause()
    # Five digits are shown: how many decimals depends on how long the run has been going.
    view.until(
        lambda: float(view.text("t")) == pytest.approx(view.live("t"), rel=1e-4), "texts are late"
    )
    t = view.live("t")
    sol = rodgen.simulate(
        rodgen.Scene.from_toml(SCENES / "missile.toml"), span=[0.0, t], output_every=t, rtol=1e-10
    )
    # Five digits are shown.
    assert float(view.text("centre_of_gravity_y")) == pytest.approx(
        sol.centre_of_gravity[-1, 1], rel=2e-5
    )
    assert float(view.text("kinetic_energy")) == pytest.approx(sol.energy.kinetic[-1], rel=2e-5)


def test_slider_changes_the_number_in_the_simulation(view: View) -> None:
    view.tab("Values").run()
    assert float(view.text("gravity")) == 9.81
    view.tab("Parameters")
    slider = view.page.get_by_role("slider", name="gravity g")
    box = slider.bounding_box()
    assert box is not None
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
    view.page.wait_for_timeout(200)
    wanted = pytest.approx(typed(), rel=1e-4)
    view.tab("Values")
    view.until(lambda: float(view.text("gravity")) == wanted, "unchanged")
    assert float(view.text("gravity_energy")) != 0.0


def test_nonsense_is_refused_beside_the_field(view: View) -> None:
    view.run()
    for text, said in (("abc", "must be a number"), ("-3", "greater than"), ("nan", "must be")):
        view.fill("mass M", text)
        view.page.locator(".q-field__messages", has_text=said).first.wait_for()
    view.tab("Values")
    assert float(view.text("mass")) == 20.0
    t = view.live("t")
    view.until(lambda: view.live("t") > t, "the run does not go on")


def test_step_is_one_step(view: View) -> None:
    view.tab("Values")
    view.button("One step").click()
    view.until(lambda: view.text("steps") == "1", "no step")
    view.page.keyboard.press(".")
    view.until(lambda: view.text("steps") == "2", "no second step")


def test_blow_up_is_told_in_words_and_can_be_mended(view: View) -> None:
    view.page.get_by_role("combobox", name="method").click()
    view.page.get_by_role("option", name="euler", exact=True).click()
    view.fill("step", "0.05")
    view.run()
    alert = view.page.get_by_role("alert").filter(has_text="stopped at t =")
    alert.wait_for()
    assert "step" in (alert.text_content() or "")
    view.fill("step", "0.0001")
    view.button("Reset to").click()
    view.run()
    view.until(lambda: view.live("t") > 0.1, "it does not run again")


PLOTS = {
    "over time": {"quantities": "omega_3"},
    "one over another": {"quantity": "omega_19", "over": "phi_19"},
    "Poincaré": {"quantity": "omega_19", "over": "phi_19", "points where": "tip_x"},
    "all of a kind": {"kind of quantity": "bending"},
    "spectrum": {"quantity": "omega_19"},
}


@pytest.mark.parametrize("kind", PLOTS)
def test_every_kind_of_plot_gets_rows(view: View, kind: str) -> None:
    view.run()
    view.button("Add plot").click()
    dialog = view.page.get_by_role("dialog")
    dialog.get_by_role("combobox", name="kind of plot").click()
    view.page.get_by_role("option").filter(has_text=kind).click()
    for label, text in PLOTS[kind].items():
        field = dialog.get_by_role("combobox", name=label, exact=True)
        field.fill(text)
        view.page.get_by_role("option").filter(has_text=text).first.click()
        if label == "quantities":
            view.page.keyboard.press("Escape")
    dialog.get_by_role("button", name="Add").click()
    view.until(lambda: view.live("plots.p3?.rows") >= 1, "no rows")
    view.button("Remove").last.click()
    view.until(lambda: view.live("plots.p3?.rows") == -1, "not removed")


def test_plot_as_csv_and_png(view: View) -> None:
    """The angles of a CSV against a run without a page."""
    view.run()
    view.until(lambda: view.live("t") > 0.5, "time does not pass")
    view.pause()
    with view.page.expect_download() as waiting:
        view.page.get_by_role("button", name="CSV").first.click()
    rows = list(csv.reader(io.StringIO(Path(waiting.value.path()).read_text())))
    values = np.array(rows[1:], dtype=float)
    sol = rodgen.simulate(
        rodgen.Scene.from_toml(SCENES / "missile.toml"), span=[0.0, 2.0], rtol=1e-10
    )
    expected = np.interp(values[:, 0], sol.t, sol.phi[:, -1])
    assert values.shape[0] > 20
    assert values[:, 2] == pytest.approx(expected, abs=1e-3)  # interpolated over 0.01 s
    with view.page.expect_download() as waiting:
        view.page.get_by_role("button", name="PNG").last.click()
    assert Path(waiting.value.path()).read_bytes()[:4] == b"\x89PNG"


def test_scene_run_and_film_are_saved(view: View, tmp_path: Path) -> None:
    view.fill("mass M", "25")
    view.run()
    view.until(lambda: view.live("t") > 0.3, "time does not pass")
    view.pause().tab("Save")
    names = {"Scene as TOML": "missile.toml", "Run as NetCDF": "missile.nc", "Animation as GIF": ""}
    files = {}
    for text, name in names.items():
        with view.page.expect_download(timeout=60_000) as waiting:
            view.button(text).click()
        files[text] = tmp_path / (name or "missile.gif")
        waiting.value.save_as(files[text])
    scene = rodgen.Scene.from_toml(files["Scene as TOML"])
    assert scene.rod.mass == 25.0
    sol = rodgen.load(files["Run as NetCDF"])
    assert sol.t[-1] == pytest.approx(view.live("t"), abs=0.02)
    again = rodgen.simulate(scene, span=[0.0, 1.0], output_every=0.01)
    at = np.searchsorted(again.t, sol.t[-1])
    assert sol.phi[-1, -1] == pytest.approx(again.phi[at, -1], abs=0.02)
    assert files["Animation as GIF"].read_bytes()[:3] == b"GIF"


def test_link_reproduces_scene_and_parameters(view: View, another: Callable[[], View]) -> None:
    view.fill("bending stiffness EI", "123")
    view.tab("Save").button("Link").click()
    link = view.field("link")
    view.until(lambda: "scene=" in link.input_value(), "no link")
    other = another().open(link.input_value())
    assert other.field("bending stiffness EI").input_value() == "123"
    view.run().pause()
    assert link.is_visible()
    view.tab("Parameters").fill("bending stiffness EI", "124")
    view.tab("Save")
    view.until(lambda: not link.is_visible(), "a link to what was before is still shown")


def test_what_cannot_be_written_is_said(
    serve: Callable[..., Any],
    another: Callable[[], View],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A folder for temporary files that is gone stands for a full disk."""
    folder = tmp_path / "tmp"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    served = serve(str(SCENES / "missile.toml"), "--port", "0")
    view = another().open(served.address).tab("Save")
    folder.rmdir()
    view.button("Run as NetCDF").click()
    view.page.get_by_text("No such file").wait_for()
    folder.mkdir()
    with view.page.expect_download() as waiting:  # it can be done again
        view.button("Run as NetCDF").click()
    assert waiting.value.path().stat().st_size > 0
    view.page.get_by_text("missile.nc: ").wait_for()
    with view.page.expect_download():  # one file at a time is kept
        view.button("Run as NetCDF").click()
    assert len(list(folder.glob("rodgen-*"))) == 1
    view.page.close()
    another().until(lambda: not list(folder.glob("rodgen-*")), "the file is kept", 20.0)


def test_defect_is_said_on_the_page(blank: View, tmp_path: Path) -> None:
    """An event that no browser sends raises what nobody expects."""
    command = [Path(sys.executable).with_name("rodgen"), "view", SCENES / "missile.toml"]
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
            canvas = blank.page.get_by_role("img", name="missile")
            identity = canvas.evaluate("e => e.closest('[id^=c]').id.slice(1)")
            blank.page.evaluate(f"getElement({identity}).$emit('kick', {{link: 'x'}})")
            blank.page.locator(".q-notification", has_text="rodgen has failed").wait_for()
            process.send_signal(signal.SIGINT)
    assert "Traceback" in (tmp_path / "said").read_text()


def test_page_says_its_language_and_has_one_main_part(view: View) -> None:
    assert view.page.evaluate("document.documentElement.lang") == "en-US"
    assert view.page.get_by_role("main").count() == 1


def test_two_pages_have_their_own_runs_and_reload_keeps_them(
    view: View, server: Any, another: Callable[[], View]
) -> None:
    other = another().open(server.address)
    view.run()
    view.until(lambda: view.live("t") > 0.5, "time does not pass")
    assert other.live("t") == 0.0
    view.page.reload()
    view.ready()
    assert view.live("t") > 0.5
    view.button("Pause (").wait_for()
    assert other.live("t") == 0.0


def test_another_number_of_links_is_made_while_the_page_lives(view: View) -> None:
    view.tab("Scene").fill("number of links", "7")
    view.button("Apply").click()
    view.tab("Values")
    view.until(lambda: view.text("links") == "7", "not made")
    view.run()
    view.until(lambda: view.live("t") > 0.2, "it does not run")
    view.tab("Scene").fill("number of links", "0")
    view.button("Apply").click()
    view.page.locator(".q-field__messages", has_text="whole number from 1").wait_for()
    view.page.wait_for_timeout(300)
    assert view.page.locator(".q-notification").count() == 0  # it is said once
    view.fill("number of links", "7")
    view.fill("phi: a number", "sin(")
    view.button("Apply").click()
    wrong = view.page.locator(".q-field--error")
    view.until(lambda: "phi" in (wrong.first.text_content() or ""), "not said beside the field")
    assert wrong.count() == 1  # the number of links is not at fault any more
    assert view.page.locator(".q-notification").count() == 0


def test_kick_turns_the_rod(view: View) -> None:
    """Of a free rod, an impulse J at rest gives the velocity J/M to the centre of gravity."""
    view.page.get_by_role("switch", name="kick").click()
    view.field("N s per metre").wait_for()
    canvas = view.page.get_by_role("img", name="missile")
    box = canvas.bounding_box()
    assert box is not None
    view.tab("Values")
    before = float(view.text("kinetic_energy"))
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    view.page.mouse.move(x, y)
    view.page.mouse.down()
    view.page.mouse.move(x + 40, y, steps=4)
    view.page.mouse.up()
    view.until(lambda: float(view.text("kinetic_energy")) != before, "no kick")


def test_scene_of_the_folder(view: View) -> None:
    view.page.get_by_role("combobox", name="Scene").click()
    view.page.get_by_role("option", name="hanging_chain").click()
    view.tab("Values")
    view.until(lambda: view.text("links") != "20", "not taken")
    view.run()
    view.until(lambda: view.live("t") > 0.2, "it does not run")


def test_no_request_leaves_the_machine(view: View) -> None:
    for name in ("Values", "Scene", "Save", "Parameters"):
        view.tab(name)
    view.run()
    view.page.wait_for_timeout(500)
    hosts = {urlsplit(url).hostname for url in view.asked if not url.startswith(("blob:", "data:"))}
    assert hosts == {"localhost"}


def test_narrow_page_has_nothing_beside_it(server: Any, blank: View) -> None:
    blank.page.set_viewport_size(NARROW)
    blank.open(server.address)
    width = "document.documentElement.scrollWidth"
    blank.until(lambda: blank.page.evaluate(width) <= NARROW["width"], "wider than the window")


def test_every_control_has_a_name(view: View) -> None:
    controls = "button, input, [role=slider], [role=switch], [role=tab]"
    nameless = """controls => [...document.querySelectorAll(controls)]
        .filter(e => e.offsetParent && !(e.getAttribute('aria-label') || e.labels?.length
            || e.textContent.trim() || e.getAttribute('aria-labelledby')))
        .map(e => e.outerHTML.slice(0, 200))"""
    assert view.page.evaluate(nameless, controls) == []
