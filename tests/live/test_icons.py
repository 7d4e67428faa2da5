"""The page's font of icons: it has every icon that the page may show, and no others."""

from __future__ import annotations

import base64
import re
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest

from rodgen.live.page.elements import ICONS, LIBRARY
from rodgen.live.page.lean import icon_font

pytestmark = pytest.mark.nightly  # in a browser
LIVE = Path(__file__).parents[2] / "src" / "rodgen" / "live"
WORD = re.compile(r"[\"'`]([a-z][a-z0-9_]*)[\"'`]")
# Names, among some words and those of Quasar's own icons, of which a font has an icon: as wide as
# high, by a ligature; `source`: of the font, null for that of the page.
NAMED = """async ([words, source]) => {
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

# Bytes of the icons that the page has loaded.
SERVED = """performance.getEntriesByType("resource")
    .find(({ name }) => name.endsWith("/PLACE")).decodedBodySize"""


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
    options = subset.Options(layout_features=["*"], layout_closure=False)
    subsetter = subset.Subsetter(options)
    subsetter.populate(
        glyphs=[icons[name] for name in names],
        unicodes=[ord(letter) for letter in {*"".join(names)}],
    )
    subsetter.subset(made)
    written = BytesIO()
    made.flavor = "woff2"
    made.save(written)
    return written.getvalue()


def test_font_has_all_icons_that_the_page_may_show(view: Any, pytestconfig: pytest.Config) -> None:
    """Of NiceGUI's font, those with a name that stands in our Python or JavaScript, or that Quasar
    uses itself. --update makes the page's font of them."""
    sources = (path for suffix in (".py", ".js") for path in LIVE.rglob("*" + suffix))
    words = sorted({word for path in sources for word in WORD.findall(path.read_text("utf-8"))})
    place = icon_font()
    assert place is not None
    font = (LIBRARY / place).read_bytes()
    source = f"url(data:font/woff2;base64,{base64.b64encode(font).decode()})"
    wanted = view.page.evaluate(NAMED, [words, source])
    assert {"play_arrow", "pause", "arrow_drop_down", "close"} <= {*wanted}
    if pytestconfig.getoption("update"):
        ICONS.write_bytes(subset(font, wanted))
        return
    assert view.page.evaluate(NAMED, [words, None]) == wanted
    assert view.page.evaluate(SERVED.replace("PLACE", place)) == len(ICONS.read_bytes())
