"""The page as it is read: colours, names, words, and what lies over what."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest

from tests.live.view import expect

pytestmark = pytest.mark.nightly  # what pixels show
View = Any  # see conftest.py
SCENES = Path(__file__).parents[2] / "scenes"
PICTURE = Path(__file__).parents[2] / "docs" / "pictures" / "live.png"
SIZES = {"wide": (1280, 800), "narrow": (390, 844)}
SHOWN = 3.0  # s of the scene
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
UNDER_THE_POINTER = """element => {
    const { x, y, width, height } = element.getBoundingClientRect();
    return element.contains(document.elementFromPoint(x + width / 2, y + height / 2));
}"""
NAMELESS = """controls => [...document.querySelectorAll(controls)]
    .filter(e => e.offsetParent && !(e.getAttribute('aria-label') || e.labels?.length
        || e.textContent.trim() || e.getAttribute('aria-labelledby')))
    .map(e => e.outerHTML.slice(0, 200))"""


@pytest.mark.parametrize(("size", "shade"), [("wide", "light"), ("narrow", "dark")])
def test_page_shows_a_rod(
    serve: Callable[..., Any],
    blank: Any,
    size: str,
    shade: str,
    pytestconfig: pytest.Config,
) -> None:
    """The rod's colours are in the picture, its ground is light or dark, and nothing is beside the
    page. --update keeps a picture."""
    width, height = SIZES[size]
    blank.page.set_viewport_size({"width": width, "height": height})
    blank.page.emulate_media(color_scheme=shade)
    served = serve(str(SCENES / "missile.toml"), "--port", "0")
    blank.open(served.address).pause_after(SHOWN)
    wide = "document.documentElement.scrollWidth"
    blank.sees(wide, lambda found: found <= width, "wider than the window")
    blank.page.mouse.move(width / 2, 0)
    expect(blank.page.locator(".q-tooltip")).to_have_count(0)

    def look() -> bytes:
        return bytes(blank.page.screenshot())

    def told(picture: bytes) -> tuple[tuple[int, ...], bool, bool]:
        """The size of a picture, whether it is light, and whether there are strong colours: the
        thrust's arrow is orange, the gravity's violet, whatever the ground."""
        pixels = matplotlib.image.imread(io.BytesIO(picture))[..., :3]
        canvas = blank.page.get_by_role("img", name="missile").bounding_box()
        x, y, w, h = (int(canvas[key]) for key in ("x", "y", "width", "height"))
        strong = np.ptp(pixels[y : min(y + h, height), x : x + w], axis=-1) > 0.4
        corner = pixels[-3, 3].mean()
        assert corner > 0.8 or corner < 0.3
        return pixels.shape[:2], bool(corner > 0.5), bool(strong.sum() > 100)

    wanted = (height, width), shade == "light", True
    picture = blank.until(look, lambda found: told(found) == wanted, f"not {wanted}")
    if pytestconfig.getoption("update") and (size, shade) == ("wide", "light"):
        PICTURE.write_bytes(picture)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_colours_can_be_read(view: View, scheme: str) -> None:
    view.page.emulate_media(color_scheme=scheme)
    view.until(view.dark, scheme == "dark", "not the shade")
    view.fill("mass M", "-3")
    refused = view.page.locator(".q-field__messages", has_text="greater than").first
    view.until(lambda: refused.evaluate(CONTRAST), lambda c: c > LEAST, "the refusal stays faint")
    view.tab("Scene")
    read = {
        "add": view.button("Add plot"),
        "kick": view.button("Kick"),
        "apply": view.button("Apply"),
        "upload": view.button("A scene in TOML"),
    }
    for name, element in read.items():
        view.until(lambda e=element: e.evaluate(CONTRAST), lambda c: c > LEAST, f"{name} is faint")


def test_page_can_be_read_by_who_does_not_see_it(view: View) -> None:
    """A screen reader is not told the time five times a second, but can ask for it."""
    assert view.page.evaluate("document.documentElement.lang") == "en-US"
    expect(view.page.get_by_role("main")).to_have_count(1)
    controls = "button, input, [role=slider], [role=switch], [role=tab]"
    assert view.page.evaluate(NAMELESS, controls) == []
    statuses = view.page.get_by_role("status")
    expect(statuses.filter(has_text="paused")).to_have_count(1)
    expect(statuses.locator("[data-text]")).to_have_count(0)
    for name in ("time", "ratio"):
        expect(view.page.get_by_role("group", name=name).locator("[data-text]")).to_have_count(1)


def test_why_there_is_no_critical_force_is_wrapped(
    serve: Callable[..., Any], blank: View, scene_file: Callable[..., Path]
) -> None:
    """A rod of one link, which no force makes unstable; where there is one, nothing is said."""
    path = scene_file("one", "[loads.follower]\nforce = 2.0", links=1)
    one = blank.open(serve(str(path), "--port", "0").address).tab("Values")
    why = one.page.locator("[data-text=critical_why]")
    expect(why).to_contain_text("no mode can become unstable")
    box, table = why.bounding_box(), one.page.locator(".rg-values").bounding_box()
    assert box["width"] <= table["width"]
    panel = one.page.locator("aside")
    assert panel.evaluate("e => e.scrollWidth <= e.clientWidth")
    number = one.page.locator("td[data-text=follower_force]").first.bounding_box()
    assert number["width"] < table["width"] / 2  # numbers stand where they stood


def test_row_of_words_is_not_there_without_words(view: View) -> None:
    view.tab("Values")
    view.until(lambda: view.text("critical_force"), lambda text: text[0].isdigit(), "no force")
    expect(view.page.locator("[data-text=critical_why]")).to_be_hidden()


def test_no_tooltip_lies_over_a_menu(view: View) -> None:
    layers = view.button("What is shown")
    layers.hover()
    tooltip = view.page.locator(".q-tooltip", has_text="What is shown")
    expect(tooltip).to_be_visible()
    layers.click()
    expect(view.page.locator(".q-menu")).to_be_visible()
    expect(tooltip).to_be_hidden()
    view.page.keyboard.press("Escape")


@pytest.mark.compiler
@pytest.mark.skipif(os.name != "posix", reason="the compiler here is a shell script")
def test_what_is_being_made_is_told_and_covers_no_tool(
    serve: Callable[..., Any],
    blank: View,
    scene_file: Callable[..., Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And in the singular. From some time on, the compiler does not end."""
    script, held = tmp_path / "cc", tmp_path / "held"
    script.write_text(f'#!/bin/sh\n[ -e {held} ] && exec sleep 600\nexec cc "$@"\n')
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))
    view = blank.open(serve(str(scene_file(links=2)), "--port", "0").address)
    held.touch()
    view.tab("Scene").fill("number of links", "1")
    view.button("Apply").click()
    status = view.page.locator(".rg-making")
    expect(status).to_contain_text("1 link:")
    expect(status).to_be_visible()
    expect(status).to_be_in_viewport(ratio=1)
    assert not status.get_by_text("1 link:").evaluate(UNDER_THE_POINTER)
    status.get_by_role("button", name="Cancel").click()
    view.noted("cancelled")
