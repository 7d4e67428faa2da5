"""Levels of the headings in the table of contents, which the theme leaves out."""

from __future__ import annotations

from typing import Any

from sphinx.application import Sphinx

TREE, LAST = "furo_navigation_tree", 900  # what the theme makes, and after it has


def _level(site: Sphinx, page: str, template: str, context: dict[str, Any], _: object) -> None:
    heading = 'role="heading"'
    context[TREE] = context.get(TREE, "").replace(heading, f'{heading} aria-level="2"')


def setup(site: Sphinx) -> dict[str, bool]:
    site.connect("html-page-context", _level, priority=LAST)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
