"""The page as it is read: colours, icons, and all of its states, on a screen and on a phone."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterator
from importlib.resources import files
from io import BytesIO
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from live.tests.conftest import PHONE, SCENES, WIDE, make
from live.tests.view import View, expect, until
from rodgen.model.palette import DARK, LIGHT, colours_of, series_pair
from rodgen.model.term import AIR, ANCHOR, BASE, CONTACT, DAMPER
from rodgen.model.terms import ROWS
from rodgen.scene import Scene
from rodgen.show.precision_pictures import OURS, own_style
from rodgen_live.page.elements import ICONS, LIBRARY, icon_font

PICTURE = Path(__file__).parents[2] / "docs" / "pictures" / "live.png"

# What axe-core finds: how grave it is, what it is, and where. But for buttons of dialogs: before
# 4.14, axe takes what lies behind a dialog for their ground.
FOUND = """axe.run({ exclude: ["[role=dialog] button"] }, { resultTypes: ["violations"] })
    .then(({ violations }) => violations
        .map(({ id, impact, nodes }) => [impact, id, nodes.map((node) => node.failureSummary)])
        .filter(([impact]) => impact === "serious" || impact === "critical"))"""
# Whether nothing comes or goes, of what does not turn for good.
STILL = """document.getAnimations().every(({ effect, playState }) =>
    playState !== "running" || effect.getComputedTiming().iterations === Infinity)"""


def grave(view: View) -> Any:
    """What keeps somebody from using the page as it is now, by axe-core."""
    pytest.importorskip("axe_playwright_python", reason="axe-core is not installed")
    axe = files("axe_playwright_python") / "axe.min.js"
    view.page.wait_for_function(STILL)
    view.page.evaluate(axe.read_text(encoding="utf-8"))
    return view.page.evaluate(FOUND)


@pytest.mark.slow
def test_nothing_keeps_anybody_from_the_page(view: View) -> None:
    """As it opens."""
    assert grave(view) == []


@pytest.mark.nightly
def test_page_shows_a_rod(serve: Any, blank: View, pytestconfig: pytest.Config) -> None:
    """All of it, within its picture. --update keeps one of the page."""
    make(Scene.from_toml(SCENES / "missile.toml").structure)
    # Less than the span of the scene, 3 s, at the end of which it begins again.
    blank.open(serve(SCENES / "missile.toml").address).pause_after(2.5)
    box = blank.page.get_by_role("img", name="missile").bounding_box()
    joints = np.reshape(blank.live("live.joints"), (-1, 2))
    assert len(joints) == 21
    assert np.all((joints >= 0) & (joints <= [box["width"], box["height"]]))
    blank.page.mouse.move(WIDE["width"] / 2, 0)
    expect(blank.page.get_by_role("tooltip")).to_have_count(0)
    if pytestconfig.getoption("update"):
        PICTURE.write_bytes(blank.page.screenshot())


def states(view: View) -> Iterator[str]:
    """Brings the page from one state to the next, and tells their names."""
    for tab in ("Values", "Parameters", "Scene", "Text", "Save"):
        view.tab(tab)
        yield tab
    for button in ("What is shown", "Kicks and pulls", "Page without", "Add plot", "Help"):
        if view.button(button).is_visible():  # a phone has no keys
            dialog = view.dialog(button)
            yield button
            view.page.keyboard.press("Escape")
            expect(dialog).to_have_count(0)
    view.select("Scene", "bad")
    close = view.page.get_by_role("alert").get_by_role("button", name="Close")
    expect(close).to_be_visible()
    yield "a notification"
    close.click()
    expect(close).to_have_count(0)
    view.button("Mode shapes").click()
    view.sees("live.mode !== null")
    yield "mode shapes"
    view.tab("Parameters").button("Sweep of follower force P").click()
    expect(view.page.get_by_role("region", name="largest growth")).to_be_visible()
    yield "swept"
    view.button("Sweep of follower force P").click()
    view.fill("mass M", "-3")
    view.refuses("mass M")
    yield "refused"
    view.button("Keep each run").click()
    view.pause_after(0.2).button("Reset to").click()
    view.pause_after(0.1).line().press("Home")
    view.sees("live.past === 0")
    yield "looking back beside a run that is kept"


@pytest.mark.nightly
@pytest.mark.parametrize(("size", "scheme"), [*product((WIDE, PHONE), ("light", "dark"))])
def test_nothing_keeps_anybody_from_any_state(
    server: Any, blank: View, size: Any, scheme: Any
) -> None:
    blank.page.set_viewport_size(size)
    blank.page.emulate_media(color_scheme=scheme)
    view = blank.open(server.address)
    found = {state: grave(view) for state in states(view)}
    assert not any(found.values()), found


@pytest.mark.nightly
def test_field_in_focus_is_not_behind_the_rod_on_a_phone(server: Any, blank: View) -> None:
    blank.page.set_viewport_size(PHONE)
    view = blank.open(server.address)
    rod = view.page.locator(".rg-rod").bounding_box()
    below = rod["y"] + rod["height"]
    view.page.locator(".rg-plots").evaluate("plots => plots.scrollIntoView()")
    view.field("mass M").focus()
    place = view.field("mass M").bounding_box
    until(lambda: place()["y"], lambda y: y >= below, "behind the rod")


LIVE = Path(__file__).parents[1] / "src" / "rodgen_live"
WORD = re.compile(r"[\"'`]([a-z][a-z0-9_]*)[\"'`]")
# Names, among some words and those of Quasar's own icons, of which a font has an icon: as wide as
# high, by a ligature; `source`: of the font, null for that of the page.
DRAWN = """async ([words, source]) => {
    const icon = getComputedStyle(document.querySelector(".material-icons"));
    const family = source ? "every icon" : icon.fontFamily.replaceAll('"', "");
    if (source) document.fonts.add(await new FontFace(family, source).load());
    await document.fonts.load(`20px '${family}'`);
    const named = set => Object.values(set).flatMap(one =>
        typeof one === "string" ? [one] : one instanceof Object ? named(one) : []);
    const canvas = document.createElement("canvas").getContext("2d");
    canvas.font = `20px '${family}', monospace`;
    const drawn = name => name.length > 1 && canvas.measureText(name).width === 20;
    return [...new Set([...words, ...named(Quasar.IconSet.props)])].filter(drawn).sort();
}"""


def subset(font: bytes, names: list[str]) -> bytes:
    """A font with the icons of these names alone; only this needs brotli."""
    pytest.importorskip("brotli", reason="brotli is not installed")
    from fontTools import subset, ttLib

    made = ttLib.TTFont(BytesIO(font))
    letters = {glyph: chr(code) for code, glyph in made.getBestCmap().items()}
    (lookup,) = made["GSUB"].table.LookupList.Lookup
    icons = {
        "".join(letters[part] for part in (first, *ligature.Component)): ligature.LigGlyph
        for first, found in lookup.SubTable[0].ligatures.items()
        for ligature in found
    }
    subsetter = subset.Subsetter(subset.Options(layout_features=["*"], layout_closure=False))
    subsetter.populate(
        glyphs=[icons[name] for name in names],
        unicodes=[ord(letter) for letter in {*"".join(names)}],
    )
    subsetter.subset(made)
    written = BytesIO()
    made.flavor = "woff2"
    made.save(written)
    return written.getvalue()


@pytest.mark.nightly
def test_font_has_all_icons_that_the_page_may_show(view: Any, pytestconfig: pytest.Config) -> None:
    """Of NiceGUI's font, those with a name that stands in our Python or JavaScript, or that Quasar
    uses itself. --update makes the page's font of them."""
    sources = (path for suffix in (".py", ".js") for path in LIVE.rglob("*" + suffix))
    words = sorted({word for path in sources for word in WORD.findall(path.read_text("utf-8"))})
    place = icon_font()
    assert place is not None
    font = (LIBRARY / place).read_bytes()
    source = f"url(data:font/woff2;base64,{base64.b64encode(font).decode()})"
    wanted = view.page.evaluate(DRAWN, [words, source])
    assert {"play_arrow", "pause", "arrow_drop_down", "close"} <= {*wanted}
    if pytestconfig.getoption("update"):
        ICONS.write_bytes(subset(font, wanted))
        return
    assert view.page.evaluate(DRAWN, [words, None]) == wanted


def matrix(text: str) -> Any:
    return np.array(text.split(), dtype=float).reshape(3, 3)


# What is left of linear red, green and blue without one kind of cones: G. M. Machado, M. M.
# Oliveira, L. A. F. Fernandes, A physiologically-based model for simulation of color vision
# deficiency, IEEE TVCG 15 (2009), 1291-1298, severity 1: protanopia, deuteranopia, tritanopia.
EYES = (
    np.eye(3),
    matrix("0.152286 1.052583 -0.204868 0.114503 0.786281 0.099216 -0.003882 -0.048116 1.051998"),
    matrix("0.367322 0.860646 -0.227968 0.280085 0.672501 0.047413 -0.011820 0.042940 0.968881"),
    matrix("1.255528 -0.076749 -0.178779 -0.078411 0.930809 0.147602 0.004733 0.691367 0.303900"),
)
# sRGB to CIE XYZ, D65 (IEC 61966-2-1).
XYZ = matrix(
    "0.4124564 0.3575761 0.1804375 0.2126729 0.7151522 0.0721750 0.0193339 0.1191920 0.9503041"
)
APART = 20.0  # in CIE L*a*b*, where 2.3 can just be told side by side: far more, of thin lines
CONTRAST = 3.0  # of graphics, by WCAG 2.1, 1.4.11


def linear(colour: str) -> Any:
    """Linear red, green and blue of #rrggbb."""
    c = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)]) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(rgb: Any) -> Any:
    """CIE L*a*b* of linear red, green and blue."""
    share = XYZ @ np.clip(rgb, 0, 1) / XYZ.sum(axis=1)
    x, y, z = np.where(share > 216 / 24389, np.cbrt(share), (24389 / 27 * share + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=["light", "dark"])
def test_colours_can_be_seen_and_told_apart(palette: Any) -> None:
    """Of curves, and of trails; by all eyes, and on their ground."""
    ground = XYZ[1] @ linear(colours_of("background", palette)[0])
    for names in (("series",), ("tail", "centre")):
        colours = [colour for name in names for colour in colours_of(name, palette)]
        for eyes in EYES:
            seen = [lab(eyes @ linear(colour)) for colour in colours]
            for (first, a), (second, b) in combinations(zip(colours, seen, strict=True), 2):
                assert np.linalg.norm(a - b) > APART, (first, second)
        for colour in colours:
            less, more = sorted((ground, XYZ[1] @ linear(colour)))
            assert (more + 0.05) / (less + 0.05) > CONTRAST, colour


def test_loads_methods_and_grounds_have_colours_of_their_own() -> None:
    """Arrows are of the series, so what holds of that holds of them; dampings and what holds a rod
    have none, and what the air does has that of drag."""
    others = DAMPER, ANCHOR, BASE, CONTACT, AIR
    drawn = [term.colours for term in ROWS if term.kind not in others]
    assert len(set(drawn)) == len(drawn)
    assert set(drawn) <= {series_pair(number) for number in range(1, 9)}
    assert len({own_style(method) for method in OURS}) == len(OURS)
    assert LIGHT.keys() == DARK.keys()
    assert len(colours_of("series")) == len(colours_of("series", DARK)) == 8
