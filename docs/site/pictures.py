"""What pictures and films of the gallery and of notebooks show, in words: what is said before them.

sphinx-gallery gives thumbnails no text; others have the name of a file.
"""

from __future__ import annotations

import re
from html import escape, unescape

from docutils import nodes
from sphinx.application import Sphinx
from sphinx_gallery.directives import imgsgnode

DRAWN = ("examples/", "notebooks/")  # pages whose pictures are made by their code
THUMBNAIL = re.compile(r'tooltip="([^"]*)"')  # stands before each, with what its example says
FILM = "<video "


def _tell(site: Sphinx, page: nodes.document) -> None:
    drawn, said = site.env.docname.startswith(DRAWN), ""
    for node in page.findall():
        if isinstance(node, nodes.paragraph):
            said = " ".join(node.astext().split())
        elif isinstance(node, nodes.raw):
            text = node.astext()
            if found := THUMBNAIL.search(text):
                said = unescape(found[1])
            elif drawn and FILM in text:
                node.children = [nodes.Text(text.replace(FILM, f"{FILM}{_label(said)} "))]
        elif isinstance(node, imgsgnode) or _is_silent(node, drawn):
            node["alt"] = said


def _label(said: str) -> str:
    return f'aria-label="{escape(said)}"'


def _is_silent(node: nodes.Node, drawn: bool) -> bool:
    """Whether it is a picture without a text of its own; pages that are written have to give it."""
    if not isinstance(node, nodes.image) or node.get("alt"):
        return False
    return drawn or "_thumb." in node["uri"]


def setup(site: Sphinx) -> dict[str, bool]:
    site.connect("doctree-read", _tell)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
