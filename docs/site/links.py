"""Look at every link, anchor and picture of the built site: python docs/site/links.py build/site.

Exit status 1 and a line for each that is broken, and for each picture without a text.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag, urlsplit

OTHERS = ("http", "https", "mailto", "data", "javascript")  # not looked at, which reach out


class Page(HTMLParser):
    """What a page links to, which anchors it has, and which pictures have no text."""

    def __init__(self, text: str):
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.silent: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.anchors.update(filter(None, (given.get("id"), given.get("name"))))
        link = given.get("href") if tag in ("a", "link") else given.get("src")
        if link:
            self.links.append(link)
        words = given.get("aria-label" if tag == "video" else "alt") or ""
        is_path = " " not in words or words.startswith("plot ")  # as programs make them up
        if tag in ("img", "video") and is_path:
            self.silent.append(link or "?")


def broken(folder: Path) -> Iterator[str]:
    """A line for everything that is wrong."""
    pages = {path.resolve(): Page(path.read_text()) for path in folder.rglob("*.html")}
    for path, page in pages.items():
        for picture in page.silent:
            yield f"{path.name}: the picture {picture} has no text"
        for link in page.links:
            if urlsplit(link).scheme in OTHERS:
                continue
            to, anchor = urldefrag(link)
            target = (path.parent / unquote(urlsplit(to).path)).resolve() if to else path
            if target.is_dir():
                target /= "index.html"
            if not target.exists():
                yield f"{path.name}: {link} is not there"
            elif anchor and target in pages and anchor not in pages[target].anchors:
                yield f"{path.name}: {link} has no such anchor"


def main() -> None:
    found = list(broken(Path(sys.argv[1])))
    sys.exit("\n".join(found) or None)


if __name__ == "__main__":
    main()
