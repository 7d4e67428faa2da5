"""Public names of the package: tables of them, and their descriptions as a reader wants them.

A docstring tells of several fields or arguments in one paragraph, "t: times [s], (T,); y: states".
The site shows such a paragraph as a list. Results are made by functions, so the arguments that
would make one are left out. Below each name stand the examples of the gallery that use it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from told import listed  # beside this file

if TYPE_CHECKING:
    from sphinx.application import Sphinx

PAGE, MARK = "reference/python", "<!-- names -->"
NAME = re.compile(r"^\.\. auto(?:function|class|exception):: (rodgen\.[\w.]+)$", re.MULTILINE)
MADE = "Structure"  # the one class that users make from arguments


def _tables(pages: Path) -> Iterator[str]:
    """A table of the names on every page of the reference, in the order of its contents."""
    contents = pages.with_suffix(".md").read_text(encoding="utf-8")
    for page in re.findall(rf"^{pages.name}/(\w+)$", contents, re.MULTILINE):
        text = (pages / f"{page}.md").read_text(encoding="utf-8")
        title = text.splitlines()[0].removeprefix("# ")
        yield f"## {title}\n"
        yield "```{eval-rst}\n.. autosummary::\n   :nosignatures:\n"
        yield from (f"   {name}" for name in NAME.findall(text))
        yield "```\n"


def _fill(site: Sphinx, page: str, source: list[str]) -> None:
    """Write the tables where the page has its mark."""
    if page == PAGE:
        source[0] = source[0].replace(MARK, "\n".join(_tables(Path(site.srcdir, PAGE))))


def shown(paragraph: str) -> list[str]:
    """The lines of a paragraph, or of a list where it tells one name after the other."""
    found = listed(paragraph)
    if not found:
        return [*paragraph.splitlines(), ""]
    return [*(f"- ``{names}``: {text}." for names, text in found), ""]


def _described(site: Sphinx, kind: str, name: str, _: object, __: object, lines: list[str]) -> None:
    """Paragraphs of names as lists, and the examples of the gallery below."""
    text, mark, rest = "\n".join(lines).partition("\nExamples\n")
    if kind in ("class", "method") and "\n-----" not in text:
        lines[:] = [line for one in text.split("\n\n") for line in shown(one)]
        lines += f"{mark}{rest}".splitlines()
    used = Path(site.srcdir, "examples", "backreferences", f"{name}.examples")
    if used.exists() and used.stat().st_size:
        lines += ["", ".. rubric:: In the gallery", "", f".. minigallery:: {name}", ""]


def _signature(_: Sphinx, kind: str, name: str, *__: object) -> tuple[str, None] | None:
    """No arguments of a class whose objects functions return."""
    return ("", None) if kind == "class" and not name.endswith(MADE) else None


def setup(site: Sphinx) -> dict[str, Any]:
    from sphinx.util.inspect import TypeAliasForwardRef

    # Inside of other types autodoc writes an alias as Python would make it.
    TypeAliasForwardRef.__repr__ = lambda alias: alias.name  # type: ignore[method-assign]
    site.connect("source-read", _fill)
    site.connect("autodoc-process-docstring", _described, priority=400)  # before numpydoc
    site.connect("autodoc-process-signature", _signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
