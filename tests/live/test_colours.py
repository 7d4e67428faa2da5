"""Colours of curves, as those see them who see fewer colours."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest

from rodgen.model.palette import DARK, LIGHT, as_css, pair, shades
from rodgen.model.term import DAMPER
from rodgen.model.terms import ROWS
from rodgen.show.precision_pictures import OURS, own

# What is left of linear red, green and blue without one kind of cones: G. M. Machado, M. M.
# Oliveira, L. A. F. Fernandes, A physiologically-based model for simulation of color vision
# deficiency, IEEE TVCG 15 (2009), 1291-1298, severity 1.
EYES = {
    "all": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
# sRGB to CIE XYZ, D65 (IEC 61966-2-1).
XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
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


@pytest.mark.parametrize("eyes", EYES)
@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=["light", "dark"])
@pytest.mark.parametrize("names", [("series",), ("tail", "centre")], ids=["curves", "trails"])
def test_colours_can_be_told_apart(names: Any, palette: Any, eyes: str) -> None:
    colours = [colour for name in names for colour in shades(name, palette)]
    seen = [lab(EYES[eyes] @ linear(colour)) for colour in colours]
    least = min(
        (float(np.linalg.norm(a - b)), first + 1, second + 1)
        for (first, a), (second, b) in combinations(enumerate(seen), 2)
    )
    assert least[0] > APART, f"colours {least[1]} and {least[2]} look alike"


def test_no_two_loads_have_one_colour() -> None:
    """Arrows are of the series, so what holds of that holds of them; dampings have none."""
    drawn = [term.colours for term in ROWS if term.kind != DAMPER]
    assert len(set(drawn)) == len(drawn)
    assert set(drawn) <= {pair(number) for number in range(1, 9)}


def test_methods_differ_in_colour_or_mark() -> None:
    assert len({own(method) for method in OURS}) == len(OURS)


@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=["light", "dark"])
def test_curves_can_be_seen(palette: Any) -> None:
    ground = XYZ[1] @ linear(shades("background", palette)[0])
    for colour in [
        *shades("series", palette),
        *shades("tail", palette),
        *shades("centre", palette),
    ]:
        less, more = sorted((ground, XYZ[1] @ linear(colour)))
        assert (more + 0.05) / (less + 0.05) > CONTRAST, colour


def test_the_known_distance_is_found() -> None:
    """Of red and green in L*a*b*, and the ends of its scale."""
    distance = np.linalg.norm(lab(linear("#ff0000")) - lab(linear("#00ff00")))
    assert distance == pytest.approx(170.6, abs=0.1)  # B. Lindbloom, Delta E calculator, CIE 1976
    assert [lab(linear(grey))[0] for grey in ("#000000", "#ffffff")] == pytest.approx([0, 100])


def test_both_grounds_have_the_same_colours() -> None:
    assert LIGHT.keys() == DARK.keys()
    assert "--rg-faint: #5b6470; " in as_css(LIGHT)
    assert len(shades("series")) == len(shades("series", DARK)) == 8
