"""Whether what the page says can be read, and what it keeps over a reload."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

View = Any  # see conftest.py
LEAST = 4.5  # contrast of text that WCAG 2.1 asks for, level AA

CONTRAST = """element => {
    const canvas = document.createElement('canvas').getContext('2d');
    const channels = colour => {
        canvas.clearRect(0, 0, 1, 1);
        canvas.fillStyle = colour;
        canvas.fillRect(0, 0, 1, 1);
        return [...canvas.getImageData(0, 0, 1, 1).data];
    };
    const luminance = colour => {
        const linear = channels(colour).slice(0, 3).map(c => c / 255)
            .map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
    };
    let ground = element;
    const behind = () => getComputedStyle(ground).backgroundColor;
    while (channels(behind())[3] < 255) ground = ground.parentElement;
    const both = [getComputedStyle(element).color, behind()];
    const [less, more] = both.map(luminance).sort((a, b) => a - b);
    return (more + 0.05) / (less + 0.05);
}"""
ONE = """
name = "one"
[rod]
links = 1
length = 1.0
bending_stiffness = 1.0
mass = 1.0
[loads.follower]
force = 2.0
[integrate]
span = [0.0, 5.0]
"""


@pytest.fixture
def one(serve: Callable[..., Any], blank: View, tmp_path: Path) -> View:
    """The page of a rod of one link, which no force makes unstable."""
    path = tmp_path / "one.toml"
    path.write_text(ONE, encoding="utf-8")
    return blank.open(serve(str(path), "--port", "0").address)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_colours_can_be_read(view: View, scheme: str) -> None:
    view.page.emulate_media(color_scheme=scheme)
    dark = "document.body.classList.contains('body--dark')"
    view.until(lambda: view.page.evaluate(dark) == (scheme == "dark"), "not the shade")
    view.fill("mass M", "-3")
    refused = view.page.locator(".q-field__messages", has_text="greater than").first
    refused.wait_for()
    view.page.wait_for_timeout(600)  # the refusal is faded in
    contrasts = {"refusal": refused.evaluate(CONTRAST)}
    view.tab("Scene")
    read = {
        "add": view.button("Add plot"),
        "kick": view.button("Kick"),
        "apply": view.button("Apply"),
        "upload": view.page.locator(".q-uploader__title"),
    }
    contrasts |= {name: element.evaluate(CONTRAST) for name, element in read.items()}
    assert min(contrasts.values()) > LEAST, contrasts


def test_why_there_is_no_critical_force_is_wrapped(one: View) -> None:
    one.tab("Values")
    why = one.page.locator("[data-text=critical_why]")
    why.filter(has_text="no mode can become unstable").wait_for()
    box, table = why.bounding_box(), one.page.locator(".rg-values").bounding_box()
    assert box["width"] <= table["width"]
    panel = one.page.locator("aside")
    assert panel.evaluate("e => e.scrollWidth <= e.clientWidth")
    number = one.page.locator("td[data-text=follower_force]").first.bounding_box()
    assert number["width"] < table["width"] / 2  # numbers stand where they stood


def test_row_of_words_is_not_there_without_words(view: View) -> None:
    view.tab("Values").text("critical_force")
    assert not view.page.locator("[data-text=critical_why]").is_visible()


def test_part_of_a_list_is_refused_beside_its_field(view: View) -> None:
    view.tab("Scene").fill("position", "1e308,0")
    view.button("Apply").click()
    wrong = view.page.locator(".q-field--error", has_text="position")
    wrong.filter(has_text="must be at most").wait_for()
    assert view.page.locator(".q-notification").count() == 0


def test_upload_tells_no_sizes_of_nothing(view: View) -> None:
    view.tab("Scene")
    view.page.locator(".q-uploader__title").wait_for()
    assert "0.00%" not in view.page.locator(".q-uploader").inner_text()


def test_no_tooltip_lies_over_a_menu(view: View) -> None:
    layers = view.button("What is shown")
    layers.hover()
    view.page.locator(".q-tooltip", has_text="What is shown").wait_for()
    layers.click()
    view.page.locator(".q-menu").wait_for()
    assert not view.page.locator(".q-tooltip").is_visible()


def test_what_is_being_made_is_told_above_the_plots(view: View) -> None:
    """And in the singular."""
    view.tab("Scene").fill("number of links", "1")
    view.page.get_by_role("checkbox", name="tip load").click()
    view.button("Apply").click()
    status = view.page.locator(".rg-making")
    status.filter(has_text=re.compile("1 link:")).wait_for()
    told, plots = status.bounding_box(), view.page.locator(".rg-plots").bounding_box()
    assert told["y"] + told["height"] <= plots["y"]


def test_reload_keeps_view_and_panel(view: View) -> None:
    view.tab("Scene")
    view.page.get_by_role("combobox", name="View").click()
    view.page.get_by_role("option", name="turns with the axes").click()
    view.page.get_by_role("tab", name="Scene", selected=True).wait_for()
    view.page.wait_for_timeout(300)
    view.page.reload()
    view.ready()
    view.page.get_by_role("tab", name="Scene", selected=True).wait_for()
    chosen = view.page.locator(".rg-view").inner_text()
    assert "turns with the axes" in chosen


def test_blow_up_beyond_use_advises_to_reset(view: View) -> None:
    view.page.get_by_role("combobox", name="method").click()
    view.page.get_by_role("option", name="euler", exact=True).click()
    view.fill("step", "0.05")
    view.button("One step").click()
    alert = view.page.get_by_role("alert").filter(has_text="Stopped at t =")

    def stopped() -> bool:
        view.page.keyboard.press(".")
        return bool(alert.is_visible())

    view.until(stopped, "it does not blow up")
    assert "Reset it" in alert.text_content()
    assert "go on from there" not in alert.text_content()
