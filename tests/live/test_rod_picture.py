"""The picture of the rod in a browser: what is drawn, where, and what is drawn no longer."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.long  # what pixels show
View = Any  # see conftest.py
Open = Callable[..., View]
NARROW = {"width": 390, "height": 844}
UPRIGHT = '[initial]\nphi = "pi/2"'
FOLLOWER = "[loads.follower]\nforce = 3.0"
ORANGE = [194, 65, 12]  # red, green, blue of the follower force in the light
# Of pictures in the page: texts, circles [x, y, radius], and where images were put [x, y, w, h].
DRAWN = """
    window.drawn = { texts: [], circles: [], images: [], lines: 0 };
    const prototype = CanvasRenderingContext2D.prototype;
    for (const [name, kept] of [
        ["fillText", (context, [text]) => drawn.texts.push(text)],
        ["arc", (context, place) => drawn.circles.push(place.slice(0, 3))],
        ["drawImage", (context, [image, ...place]) => drawn.images.push(place)],
        ["lineTo", () => drawn.lines++],
    ]) {
        const usual = prototype[name];
        prototype[name] = function (...given) {
            if (this.canvas.closest(".rodgen-rod")) kept(this, given);
            return usual.apply(this, given);
        };
    }
"""
FORGET = "Object.assign(drawn, { texts: [], circles: [], images: [], lines: 0 })"
# [left, top, right, bottom] of the pixels of a colour in a picture, and how many they are.
COLOURED = """colour => {
    const canvas = document.querySelector(".rodgen-rod canvas");
    const { width, height } = canvas;
    const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    let count = 0;
    for (let at = 0; at < data.length; at += 4) {
        if (colour.some((c, k) => Math.abs(c - data[at + k]) > 25)) continue;
        const [x, y] = [(at / 4) % width, Math.floor(at / 4 / width)];
        // The legend, in the upper right corner, has the colours of the picture.
        if (x > width - 212 && y < 78) continue;
        count += 1;
        [box[0], box[1]] = [Math.min(box[0], x), Math.min(box[1], y)];
        [box[2], box[3]] = [Math.max(box[2], x), Math.max(box[3], y)];
    }
    return { count, box: count ? box : null, size: [width, height] };
}"""


@pytest.fixture
def opened(serve: Callable[..., Any], blank: View, scene_file: Callable[..., Path]) -> Open:
    """Writes scenes of a rod that stands, by name their loads and keys of [rod], and opens the page
    of the first."""

    def open_(viewport: dict[str, int] | None = None, **given: dict[str, Any]) -> View:
        paths = [
            scene_file(name, f"{keys.pop('loads', '')}\n{UPRIGHT}", **{"length": 2.0} | keys)
            for name, keys in given.items()
        ]
        blank.page.add_init_script(DRAWN)
        if viewport:
            blank.page.set_viewport_size(viewport)
        return blank.open(serve(str(paths[0]), "--port", "0").address)

    return open_


def coloured(view: View) -> dict[str, Any]:
    return dict(view.page.evaluate(COLOURED, ORANGE))


def drawn(view: View) -> dict[str, Any]:
    """What a new picture is made of."""
    view.page.evaluate(FORGET)
    view.page.get_by_role("img", name="rod of").press("0")  # fits it: it is there already
    view.until(lambda: view.page.evaluate("drawn.lines") > 0, "nothing is drawn")
    return dict(view.page.evaluate("drawn"))


def test_load_that_is_gone_is_drawn_no_longer(opened: Open) -> None:
    """The number of links is the same, whether a term goes or another scene comes."""
    view = opened(thrust={"loads": FOLLOWER}, coasting={})
    assert coloured(view)["count"] > 100
    for name, seen in (("coasting", False), ("thrust", True)):
        view.select("Scene", name)
        view.until(lambda seen=seen: (coloured(view)["count"] > 100) is seen, f"not as in {name}")
    view.tab("Scene").page.get_by_role("checkbox", name="follower", exact=True).click()
    view.button("Apply and restart").click()
    view.until(lambda: coloured(view)["count"] == 0, "the force is still drawn")


@pytest.mark.parametrize(
    ("boundary", "viewport"), [("clamped", None), ("clamped", NARROW), ("free", NARROW)]
)
def test_arrow_at_the_tail_is_in_the_picture(
    opened: Open, boundary: str, viewport: dict[str, int] | None
) -> None:
    """All of it, and nothing is behind the legend: neither joints nor centre of gravity."""
    view = opened(viewport, column={"boundary": boundary, "loads": FOLLOWER})
    found = coloured(view)
    left, top, right, bottom = found["box"]
    width, height = found["size"]
    assert min(left, top, width - 1 - right, height - 1 - bottom) >= 3
    assert bottom - top > 50
    marks = drawn(view)
    x, y, w, h = marks["images"][-1]
    assert marks["circles"]
    assert [p for p in marks["circles"] if x < p[0] < x + w and y < p[1] < y + h] == []


def test_bodies_are_drawn_to_scale(opened: Open) -> None:
    """A third of the whole mass of 4.5 kg has a third of the area that all of it had."""
    body = '[[bodies]]\nname = "tank"\nat = 0.5\nmass = 1.5\n'
    marks = drawn(opened(carrying={"loads": body, "mass": 3.0}))
    assert "tank" in marks["texts"]
    assert any(r == pytest.approx(18 / 3**0.5) for *_, r in marks["circles"])


def test_joints_are_drawn_where_they_do_not_touch(opened: Open) -> None:
    """All or none: of 100 links in 300 pixels none, and all once they are larger."""
    view = opened(fine={"links": 100})

    def joints() -> int:
        small = "drawn.circles.filter(([, , radius]) => radius < 5).length"
        view.page.evaluate(FORGET)
        view.page.get_by_role("img", name="rod of").press("ArrowLeft")
        view.until(lambda: view.page.evaluate("drawn.lines") > 0, "nothing is drawn")
        return int(view.page.evaluate(small))

    assert joints() == 0
    for _ in range(8):
        view.page.keyboard.press("+")
    view.until(lambda: joints() == 101, "joints are not drawn")


def test_kick_that_is_dragged_says_how_large_it_is(opened: Open) -> None:
    """A rigid rod at rest, kicked at its centre of gravity, has J^2 / 2M."""
    view = opened(rigid={"links": 1})
    view.tab("Values")
    view.page.get_by_role("switch", name="kick").click()
    view.fill("N s per metre", "7")
    box = view.page.get_by_role("img", name="rod of").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    view.page.mouse.move(x, y)
    view.page.mouse.down()
    view.page.mouse.move(x + 60, y - 45)
    view.page.evaluate(FORGET)
    view.page.mouse.move(x + 80, y - 60)

    def said() -> list[str]:
        texts = view.page.evaluate("drawn.texts")
        return [text for text in texts if re.fullmatch(r"[\d.]+ N s", text)]

    view.until(lambda: bool(said()), "nothing is said")
    impulse = float(said()[-1].split()[0])
    view.page.mouse.up()
    wanted = pytest.approx(impulse**2 / 4, rel=0.02)  # three digits are said
    view.until(lambda: float(view.text("kinetic_energy")) == wanted, "another kick")


def test_trail_is_there_again_after_a_reload(opened: Open) -> None:
    """A rod that was kicked, and has come some metres."""
    view = opened(flying={"links": 1})
    view.button("Kick").click()
    view.fill("impulse along x", "10")
    view.page.get_by_role("dialog").wait_for(state="detached")
    still = drawn(view)["lines"]
    view.pause_after(0.5)
    moved = drawn(view)["lines"]
    view.page.reload()
    view.ready()
    assert moved > still + 20
    assert drawn(view)["lines"] > 0.8 * moved
