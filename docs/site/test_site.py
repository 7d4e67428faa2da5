"""The built site: links, pictures with texts, and what axe-core finds of level AA."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from links import broken  # beside this file

SITE = Path(__file__).parents[2] / "build" / "site"
KINDS = (  # one page of each kind
    "index",
    "tutorial",
    "derivation",
    "how-to/control-loop",
    "reference/python",
    "reference/python/chaos",
    "reference/command-line",
    "examples/index",
    "examples/stability/plot_euler_column",
    "notebooks/tour",
    "replays",
    "search",
)
LEVEL = """axe.run({ runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"] })
.then(({ violations }) => violations.map((one) => [one.id, one.nodes[0].html, one.nodes.length]))"""

pytestmark = pytest.mark.nightly
if not (SITE / "index.html").exists():
    pytest.skip("the site is not built: make docs", allow_module_level=True)


def test_nothing_is_broken() -> None:
    assert list(broken(SITE)) == []


def test_nothing_comes_from_elsewhere() -> None:
    """A page opens from the file system: scripts, styles and pictures lie beside it."""
    for path in SITE.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        for reach in ('<script src="http', 'rel="stylesheet" href="http', '<img src="http'):
            assert reach not in text, (path, reach)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    chromium = shutil.which("chromium")
    if not chromium:
        pytest.skip("no chromium on PATH")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as started:
        made = started.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield made
        made.close()


@pytest.mark.parametrize("shade", ["light", "dark"])
@pytest.mark.parametrize("page", KINDS)
def test_pages_can_be_used_by_all(browser: Any, page: str, shade: str) -> None:
    axe = pytest.importorskip("axe_playwright_python", reason="axe-core is not installed")
    script = files(axe).joinpath("axe.min.js").read_text(encoding="utf-8")
    with browser.new_context(color_scheme=shade) as context:
        tab = context.new_page()
        tab.goto((SITE / f"{page}.html").as_uri())
        tab.evaluate(script)
        assert tab.evaluate(LEVEL) == []


@pytest.mark.parametrize("page", KINDS)
def test_pages_fit_a_phone_and_a_small_screen(browser: Any, page: str) -> None:
    for wide in (390, 1100):
        with browser.new_context(viewport={"width": wide, "height": 800}) as context:
            tab = context.new_page()
            tab.goto((SITE / f"{page}.html").as_uri())
            assert tab.evaluate("document.documentElement.scrollWidth") <= wide
