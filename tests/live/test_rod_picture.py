"""The picture of the rod in a browser: what is drawn, where, and what is drawn no longer."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rodgen.model.terms import TERMS
from tests.live.view import expect

pytestmark = pytest.mark.nightly  # what pixels show
View = Any  # see conftest.py
Open = Callable[..., View]
NARROW = {"width": 390, "height": 844}
UPRIGHT = '[initial]\nphi = "pi/2"'
FOLLOWER = "[loads.follower]\nforce = 3.0"
THRUST = [*bytes.fromhex(TERMS["follower"].colours[0][1:])]  # red, green, blue in the light
# Of the last picture in the page, each of which begins with its transform: its number, texts,
# circles [x, y, radius], where images were put [x, y, w, h], and how many lines it has.
DRAWN = """
    window.drawn = { number: 0 };
    const prototype = CanvasRenderingContext2D.prototype;
    const begin = () => {
        window.drawn = { number: drawn.number + 1, texts: [], circles: [], images: [], lines: 0 };
    };
    for (const [name, kept] of [
        ["setTransform", begin],
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
# How far up the rod reaches [m].
TALLEST = """import("rodgen-live/hub.js").then(({ hub }) =>
    Math.max(...hub.rod.joints.filter((_, at) => at % 2)))"""
# How far down [m].
LOWEST = TALLEST.replace("max", "min")
# In what order joints and links are drawn, of the last picture.
ORDER = """
    const context = document.querySelector(".rodgen-rod canvas").getContext("2d");
    for (const [name, what] of [["setTransform", null], ["fill", "joint"], ["stroke", "links"]]) {
        const usual = context[name].bind(context);
        context[name] = (...given) => {
            if (!what) window.order = [];
            else if (what === "links" ? context.lineWidth > 2 && context.lineCap === "round"
                : context.fillStyle === "#7a8696") order.push(what);
            usual(...given);
        };
    }
    null;
"""
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
    return dict(view.page.evaluate(COLOURED, THRUST))


def drawn(view: View, key: str = "0") -> dict[str, Any]:
    """What a new picture is made of, after a key: 0 fits it."""
    before = view.page.evaluate("drawn.number")
    view.page.get_by_role("img", name="rod of").press(key)
    return dict(view.sees("drawn", lambda made: made["number"] > before, "nothing is drawn"))


def arrow(view: View, seen: bool) -> None:
    """The follower force is drawn, or not."""
    what = "no arrow" if seen else "an arrow"
    view.until(lambda: coloured(view)["count"], lambda count: (count > 100) is seen, what)


def whole(view: View) -> None:
    """All of the follower force's arrow is in the picture."""

    def is_whole(found: dict[str, Any]) -> bool:
        if not found["box"]:
            return False
        left, top, right, bottom = found["box"]
        width, height = found["size"]
        around = min(left, top, width - 1 - right, height - 1 - bottom)
        return around >= 3 and bottom - top > 50

    view.until(lambda: coloured(view), is_whole, "the arrow is cut off")


def test_load_that_is_gone_is_drawn_no_longer(opened: Open) -> None:
    """The number of links is the same, whether a term goes or another scene comes."""
    view = opened(thrust={"loads": FOLLOWER}, coasting={})
    arrow(view, True)
    for name, seen in (("coasting", False), ("thrust", True)):
        view.select("Scene", name)
        arrow(view, seen)
    view.tab("Scene").page.get_by_role("checkbox", name="follower", exact=True).click()
    view.button("Apply and restart").click()
    view.until(lambda: coloured(view)["count"], 0, "the force is still drawn")


@pytest.mark.parametrize(
    ("boundary", "viewport"), [("clamped", None), ("clamped", NARROW), ("free", NARROW)]
)
def test_arrow_at_the_tail_is_in_the_picture(
    opened: Open, boundary: str, viewport: dict[str, int] | None
) -> None:
    """All of it, and nothing is behind the legend: neither joints nor centre of gravity."""
    view = opened(viewport, column={"boundary": boundary, "loads": FOLLOWER})
    whole(view)

    def hidden(marks: dict[str, Any]) -> list[Any] | None:
        if not marks["images"] or not marks["circles"]:
            return None
        x, y, w, h = marks["images"][-1]
        return [p for p in marks["circles"] if x < p[0] < x + w and y < p[1] < y + h]

    view.until(lambda: hidden(view.page.evaluate("drawn")), [], "behind the legend")


def test_picture_is_fitted_to_its_size_until_a_part_is_chosen(opened: Open) -> None:
    """As it is while the page is being built, and plots come below it."""
    view = opened(NARROW, column={"boundary": "clamped", "loads": FOLLOWER})
    canvas = "document.querySelector('.rodgen-rod canvas').clientHeight"

    def resized(height: int) -> None:
        before = view.page.evaluate(canvas)
        view.page.set_viewport_size({**NARROW, "height": height})
        view.sees(canvas, lambda now: now != before, "not resized")

    def link() -> float:
        """Pixels from one joint to the next, in a new picture."""
        (x, y, _), (u, v, _) = drawn(view, "ArrowLeft")["circles"][:2]
        return float(np.hypot(x - u, y - v))

    resized(500)
    whole(view)
    view.page.get_by_role("img", name="rod of").press("+")
    chosen = link()
    resized(900)
    assert link() == pytest.approx(chosen, abs=0.01)


def test_picture_is_fitted_again_after_a_change_and_a_reset(opened: Open) -> None:
    """A longer rod, another place of it: unless a part of the picture was chosen."""
    view = opened(column={"boundary": "clamped", "loads": FOLLOWER})
    whole(view)
    view.tab("Parameters").fill("length", "40")
    view.sees(TALLEST, pytest.approx(40.0, rel=0.01), "not as long")
    whole(view)
    view.page.get_by_role("img", name="rod of").press("+")
    view.fill("length", "4000")
    view.sees(TALLEST, pytest.approx(4000.0, rel=0.01), "not as long")
    view.button("Reset to").click()
    arrow(view, False)


def test_rod_that_moves_out_of_the_picture_is_fitted_again(opened: Open) -> None:
    """A column that falls below its clamp, until a part of the picture is chosen."""
    load = "[loads.tip]\nx = 3.0\ny = -30.0"
    view = opened(column={"boundary": "clamped", "clamp_angle": np.pi / 2, "loads": load})

    def outside() -> int:
        """How many joints are, while the tail hangs."""
        view.button("Reset to").click()
        view.run()
        view.sees(LOWEST, lambda y: y < -1.0, "it does not fall")
        view.pause()
        height = view.page.evaluate("document.querySelector('.rodgen-rod canvas').clientHeight")
        joints = [y for _, y, radius in view.page.evaluate("drawn.circles") if radius < 7]
        assert len(joints) >= 5
        return sum(y > height for y in joints)

    assert outside() == 0
    view.page.get_by_role("img", name="rod of").press("+")
    for _ in range(4):
        view.page.keyboard.press("+")
    assert outside() > 0


def test_joints_do_not_hide_the_moments_that_links_are_coloured_by(opened: Open) -> None:
    """The line of the links passes over every joint: the last joint is not on top of it."""
    view = opened(bent={"links": 4, "boundary": "clamped", "loads": FOLLOWER})
    view.page.evaluate(ORDER)
    drawn(view, "ArrowLeft")
    order = view.page.evaluate("order")
    assert "joint" in order
    assert order[-1] == "links"


def test_displacements_are_drawn_larger_and_said_to_be(opened: Open) -> None:
    """A column in its first millimetres: of its tail tenfold is ten times as far aside."""
    column = {"boundary": "clamped", "loads": FOLLOWER, "clamp_angle": 1.5707963267948966}
    view = opened(column={**column, "links": 3})
    view.button("Kick").click()
    view.fill("impulse along x", "0.01")
    view.pause_after(0.2)

    def aside() -> float:
        joints = [place for place in drawn(view)["circles"] if place[2] < 7]
        scale = abs(joints[-1][1] - joints[0][1])
        return float((joints[-1][0] - joints[0][0]) / scale)

    once = aside()
    view.select("Displacements", "× 10")
    view.sees("drawn.texts.includes('displacements × 10')", True, "it is not said")
    assert aside() == pytest.approx(10 * once, rel=0.02)  # lengths change by their squares


def test_bodies_are_drawn_to_scale(opened: Open) -> None:
    """A third of the whole mass of 4.5 kg has a third of the area that all of it had."""
    body = '[[bodies]]\nname = "tank"\nat = 0.5\nmass = 1.5\n'
    view = opened(carrying={"loads": body, "mass": 3.0})
    marks = view.sees("drawn", lambda made: "tank" in made["texts"], "no tank")
    assert any(r == pytest.approx(18 / 3**0.5) for *_, r in marks["circles"])


def test_joints_are_drawn_where_they_do_not_touch(opened: Open) -> None:
    """All or none: of 100 links in 300 pixels none, and all once they are larger."""
    view = opened(fine={"links": 100})

    joints = "drawn.circles.filter(([, , radius]) => radius < 7).length"
    drawn(view, "ArrowLeft")
    assert view.page.evaluate(joints) == 0
    for _ in range(11):
        view.page.keyboard.press("+")
    view.sees(joints, 101, "joints are not drawn")


def test_kick_that_is_dragged_says_how_large_it_is(opened: Open) -> None:
    """A rigid rod at rest, kicked at its centre of gravity, has J^2 / 2M."""
    view = opened(rigid={"links": 1})
    view.tab("Values")
    view.page.get_by_role("switch", name="kick").click()
    view.fill("N s per metre", "7")
    view.answered()
    box = view.page.get_by_role("img", name="rod of").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    view.page.mouse.move(x, y)
    view.page.mouse.down()

    def said() -> float:
        texts = view.page.evaluate("drawn.texts")
        found = [text for text in texts if re.fullmatch(r"[\d.]+ N s", text)]
        return float(found[0].split()[0]) if found else 0.0

    view.page.mouse.move(x + 60, y - 45)
    first = view.until(said, lambda impulse: impulse > 0, "nothing is said")
    view.page.mouse.move(x + 80, y - 60)
    impulse = view.until(said, pytest.approx(first * 4 / 3, rel=0.02), "not what is farther")
    view.page.mouse.up()
    wanted = pytest.approx(impulse**2 / 4, rel=0.02)  # three digits are said
    view.until(lambda: float(view.text("kinetic_energy")), wanted, "another kick")


def test_trail_is_there_again_after_a_reload(opened: Open) -> None:
    """A rod that was kicked, and has come some metres."""
    view = opened(flying={"links": 1})
    view.button("Kick").click()
    view.fill("impulse along x", "10")
    expect(view.page.get_by_role("dialog")).to_have_count(0)
    still = drawn(view)["lines"]
    view.pause_after(0.5)
    moved = drawn(view)["lines"]
    view.reload()
    assert moved > still + 20
    again = pytest.approx(moved, rel=0.2)  # it goes through other samples
    view.until(lambda: drawn(view)["lines"], again, "the trail is another")


def test_trail_ends_at_the_time_that_is_looked_at(opened: Open) -> None:
    """A rod that goes along in a straight line, looked at halfway."""
    view = opened(flying={"links": 1})
    view.button("Kick").click()
    view.fill("impulse along x", "10")
    expect(view.page.get_by_role("dialog")).to_have_count(0)
    view.pause_after(0.5)
    whole = drawn(view)["lines"]
    line = view.page.get_by_role("slider", name="Time that is shown")

    def ends(key: str, presses: int, lines: Any) -> int:
        """Pictures of the same scale, moved aside, come to have so many lines."""
        for _ in range(presses):
            line.press(key)
        return int(view.until(lambda: drawn(view, "ArrowLeft")["lines"], lines, "others are drawn"))

    still = ends("Home", 1, lambda lines: lines < whole - 20)
    # Places lie some pixels apart, and a page of the time line is some samples.
    ends("PageUp", 5, pytest.approx((still + whole) / 2, abs=0.2 * (whole - still)))
    ends("End", 1, whole)


def test_link_that_is_pointed_at_tells_what_it_does(opened: Open) -> None:
    """Of a rod that stands, in its middle link; nothing beside the rod."""
    view = opened(still={"links": 3, "boundary": "clamped", "clamp_angle": np.pi / 2})
    joints = [place for place in drawn(view)["circles"] if place[2] < 7]
    box = view.page.get_by_role("img", name="rod of").bounding_box()
    (x, y, _), (u, v, _) = joints[1:3]
    view.page.mouse.move(box["x"] + (x + u) / 2, box["y"] + (y + v) / 2)
    said = view.sees("drawn.texts", lambda texts: "link 1" in texts, "nothing is told")
    assert {"φ = 1.571 rad (90°)", "ω = 0 rad/s", "M = 0 and 0 N m at its joints"} <= set(said)
    assert {"N = 0 and 0 N at its joints", "Q = 0 and 0 N at its joints"} <= set(said)
    view.page.mouse.move(box["x"] + (x + u) / 2 + 60, box["y"] + (y + v) / 2)
    view.sees("drawn.texts.includes('link 1')", False, "it is still told")


def test_modes_swing_about_the_present_state(opened: Open) -> None:
    """Told by their frequencies, also of the state after a step, until the button is pressed."""
    view = opened(column={"boundary": "clamped", "loads": FOLLOWER, "clamp_angle": np.pi / 2})
    told = "drawn.texts.find(text => text.startsWith('mode '))"
    view.button("Mode shapes").click()
    first = view.sees(told, lambda text: text is not None, "no mode")
    assert re.fullmatch(r"mode 1: [\d.]+ Hz, about the rod as at t = 0 s", first)
    moved = view.page.evaluate("drawn.number")
    view.sees("drawn.number", lambda now: now > moved + 3, "it does not swing")
    view.page.get_by_role("combobox", name="Mode").click()
    view.page.get_by_role("option", name=re.compile("^2: ")).click()
    view.sees(told, lambda text: text.startswith("mode 2: "), "not the second")
    view.button("One step").click()
    later = re.compile(r"mode 2: .* t = (?!0 s)")
    view.sees(told, lambda text: bool(later.match(text)), "those of the state before")
    view.button("Mode shapes").click()
    view.sees(told, None, "it is still shown")
