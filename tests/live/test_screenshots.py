"""The page as a stranger sees it: wide and narrow, light and dark. --update keeps a picture."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest

PICTURE = Path(__file__).parents[2] / "docs" / "pictures" / "live.png"
SIZES = {"wide": (1280, 800), "narrow": (390, 844)}
SHOWN = 3.0  # s of the scene


@pytest.mark.parametrize("shade", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_page_shows_a_rod(
    server: Any, blank: Any, size: str, shade: str, pytestconfig: pytest.Config
) -> None:
    """The rod's colours are in the picture, and its ground is light or dark."""
    width, height = SIZES[size]
    blank.page.set_viewport_size({"width": width, "height": height})
    blank.page.emulate_media(color_scheme=shade)
    blank.open(server.address).run()
    blank.until(lambda: blank.live("t") > SHOWN, "time does not pass")
    blank.pause()
    blank.page.mouse.move(width / 2, 0)
    blank.page.wait_for_timeout(1500)  # hints go away, plots come up
    picture = blank.page.screenshot()
    if pytestconfig.getoption("update") and (size, shade) == ("wide", "light"):
        PICTURE.write_bytes(picture)
    pixels = matplotlib.image.imread(io.BytesIO(picture))[..., :3]
    assert pixels.shape[:2] == (height, width)
    corner = pixels[-3, 3].mean()
    assert corner > 0.8 if shade == "light" else corner < 0.3
    canvas = blank.page.get_by_role("img", name="missile").bounding_box()
    x, y, w, h = (int(canvas[key]) for key in ("x", "y", "width", "height"))
    drawn = pixels[y : min(y + h, height), x : x + w]
    # The thrust's arrow is orange, the gravity's violet, whatever the ground: strong colours.
    strong = np.ptp(drawn, axis=-1) > 0.4
    assert strong.sum() > 100
