"""What steers a run, in a real browser: buttons, keys, sliders and fields.

Most of it is long: what the page asks of a run, and what it is given, is tested in Python.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rodgen
from rodgen.scene import Scene
from tests.live.conftest import ROD
from tests.live.view import expect

NARROW = {"width": 390, "height": 844}
View = Any  # see conftest.py


def steps(view: View) -> int:
    """How many steps of the method the page shows."""
    return int(view.text("steps").replace("\u202f", ""))  # between thousands


def test_state_drawn_is_that_of_simulate(view: View) -> None:
    """Steps, a run that is paused and reset; values that the page shows against a run of the same
    scene without a page."""
    assert view.live("t") == 0.0
    view.tab("Values").button("One step").click()
    view.until(lambda: steps(view), 1, "no step")
    view.page.keyboard.press(".")
    view.until(lambda: steps(view), 2, "no second step")
    t = view.pause_after(0.5).live("t")
    sol = rodgen.simulate(Scene.from_dict(ROD), span=[0.0, t], output_every=t, rtol=1e-10)
    # Of times, hundredths are shown; of others five digits, and half of the last one is 5e-5 of a
    # number that begins with 1.
    for key, wanted in (
        ("t", pytest.approx(t, abs=0.0051)),
        ("centre_of_gravity_y", pytest.approx(sol.centre_of_gravity[-1, 1], rel=5.1e-5)),
        ("kinetic_energy", pytest.approx(sol.energy.kinetic[-1], rel=5.1e-5)),
    ):
        view.until(lambda key=key: float(view.text(key)), wanted, f"another {key}")
    assert view.live("t") == t
    view.button("Reset to").click()
    view.until(lambda: view.live("t"), 0.0, "not reset")


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
    view.page.mouse.up()

    def typed() -> float:
        return float(view.field("gravity g").input_value())

    # 90 % of the way from -3 to 3 times 9.81, and the pointer's half of the knob.
    g = view.until(typed, lambda g: 20.0 < g < 29.5, "the field does not follow")
    refusals = view.page.locator(".q-field__messages")
    for text, said in (
        ("abc", "must be a number"),
        ("-3", "greater than"),
        ("nan", "must be a number"),
    ):
        view.fill("mass M", text)
        expect(refusals.filter(has_text=said)).to_have_count(1)
    view.tab("Values")
    view.until(lambda: float(view.text("gravity")), pytest.approx(g, rel=1e-4), "not what is typed")
    assert float(view.text("mass")) == 3.0
    view.passes(0.0)


@pytest.mark.nightly
def test_blow_up_is_told_in_words_and_can_be_mended(view: View) -> None:
    """A method is given a step that is stable, and one without such a step is refused; from a state
    beyond use only a reset leads on, not another step."""
    view.select("method", "euler")
    view.noted("with every step of euler")
    view.select("method", "rk4")
    view.run().passes(0.3).pause()
    view.fill("step", "0.2")
    view.button("One step").click()
    alert = view.page.get_by_role("alert").filter(has_text="Stopped at t =")

    def stopped() -> bool:
        view.page.keyboard.press(".")
        return bool(alert.is_visible())

    view.until(stopped, True, "it does not blow up")
    expect(alert).to_contain_text("Reset it")
    expect(alert).not_to_contain_text("go on from there")
    view.fill("step", "0.0001")
    view.answered().state("stopped")
    view.button("Reset to").click()
    view.run().passes(0.1)


@pytest.mark.nightly
def test_keys(view: View) -> None:
    """Space selects a tab that has the focus; elsewhere it runs, and a click on a tab is no focus.
    Of keys that are held the first counts, of steps every one; none counts that is typed or the
    browser's."""
    keyboard, first = view.page.keyboard, view.dark()

    view.page.get_by_role("tab", name="Scene").focus()
    view.sent()
    keyboard.press("Space")
    expect(view.page.get_by_role("tab", name="Scene", selected=True)).to_be_visible()
    assert "key" not in view.sent()
    view.tab("Values")
    keyboard.press("Space")
    view.state("running")
    view.page.locator(".rodgen-chart").first.focus()
    keyboard.press("Space")
    view.state("paused")
    view.button("Reset to").click()
    view.until(lambda: steps(view), 0, "not reset")
    view.tab("Parameters").field("mass M").focus()
    view.sent()
    for key in ("Alt+d", "Control+.", "d", "."):
        keyboard.press(key)
    view.page.get_by_role("tab", name="Values").focus()
    for key in ("Alt+d", "Control+."):
        keyboard.press(key)
    assert "key" not in view.sent()
    view.tab("Values")
    for _ in range(3):
        keyboard.down("d")  # all but the first are repeats
    keyboard.up("d")
    assert view.sent().count("key") == 1
    view.until(view.dark, not first, "d does nothing")
    for _ in range(3):
        keyboard.down(".")
    view.until(lambda: steps(view), 3, "a held . is no more steps")


@pytest.mark.nightly
def test_space_does_not_scroll(server: Any, blank: View) -> None:
    blank.page.set_viewport_size(NARROW)
    blank.open(server.address)
    height = "document.documentElement.scrollHeight"
    blank.sees(height, lambda found: found > NARROW["height"], "nothing to scroll")
    blank.page.get_by_role("img", name="dart").focus()
    blank.page.evaluate("addEventListener('keydown', e => { window.kept = e.defaultPrevented; })")
    blank.page.keyboard.press("Space")
    assert blank.page.evaluate("window.kept")
    blank.state("running")


# What lies at the middle of every button that has an icon: its own, or another's, by their names.
HIT = """() => [...document.querySelectorAll("button:has(.material-icons)")]
    .filter(button => button.checkVisibility())
    .map(button => {
        button.scrollIntoView({ block: "center" });
        const { x, y, width, height } = button.getBoundingClientRect();
        const hit = document.elementFromPoint(x + width / 2, y + height / 2);
        return [button.ariaLabel, hit?.closest("button")?.ariaLabel];
    })
    .filter(([meant, hit]) => meant && meant !== hit)"""


def test_buttons_take_their_own_clicks_before_their_icons_are_there(
    server: Any, blank: View
) -> None:
    """Until the font of the icons has come, an icon is its name: `skip_next`, wider than its
    button, which then had the clicks that were for Run, beside it."""
    blank.page.route("**/*.woff2", lambda route: route.abort())
    blank.open(server.address)
    assert blank.page.evaluate(HIT) == []
    blank.run()


@pytest.mark.nightly
def test_click_counts_as_soon_as_there_is_a_button(
    server: Any, another: Callable[[], View]
) -> None:
    """In the very moment in which it comes, whatever of the page is not there yet."""
    for _ in range(3):
        view = another()
        view.page.add_init_script("""new MutationObserver((_, observer) => {
            const run = document.querySelector("button[aria-label^='Run (']");
            if (run) { observer.disconnect(); run.click(); }
        }).observe(document, { childList: true, subtree: true })""")
        view.page.goto(server.address)
        view.state("running")
        view.page.close()


@pytest.mark.nightly
def test_page_begins_with_a_rod_that_moves_and_tells_its_keys(
    serve: Callable[..., Any], blank: View, folder: Path
) -> None:
    """Until the space bar stops it; the list of scenes has a picture of each that can be read."""
    view = blank.open(serve(str(folder / "dart.toml"), "--port", "0", "--moving").address)
    view.passes(0.1).state("running")
    expect(view.page.get_by_role("status").filter(has_text="in a loop")).to_be_visible()
    view.page.keyboard.press("?")
    keys = view.page.get_by_role("dialog", name="Keys")
    expect(keys).to_contain_text("One step of the method")
    keys.get_by_role("button", name="Close").click()
    expect(keys).to_have_count(0)
    view.page.keyboard.press(" ")
    view.state("paused")
    view.page.get_by_role("combobox", name="Scene").click()
    widths = "[...document.querySelectorAll('.rg-gallery img')].map(i => i.naturalWidth > 0)"
    view.sees(widths, [False, True, True, True], "not a picture of each scene")  # bad, dart, ...


@pytest.mark.nightly
def test_undo_by_keys_and_what_differs_from_the_file(view: View) -> None:
    """Keys undo where nothing is typed; the field says what the file has while it differs."""
    view.tab("Parameters").fill("gravity", "3")
    said = view.page.get_by_text("in the file: 9.81")
    expect(said).to_be_visible()
    view.page.get_by_role("slider", name="Time that is shown").focus()
    view.page.keyboard.press("Control+z")
    expect(view.field("gravity")).to_have_value("9.81")
    expect(said).to_have_count(0)
    expect(view.button("Undo")).to_be_disabled()
    expect(view.button("Redo: loads.gravity.g = 3")).to_be_enabled()
    view.page.keyboard.press("Control+Shift+Z")
    expect(view.field("gravity")).to_have_value("3")
    view.button("Undo").click()
    expect(view.field("gravity")).to_have_value("9.81")
    view.select("Scene", "two")
    scenes = view.page.get_by_role("combobox", name="Scene")
    expect(scenes).to_have_value("two")
    view.button("Undo: scene rod").click()
    expect(scenes).to_have_value("dart")
