"""Pages: templates, tables with all digits, pictures, folders that are written whole."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib import rc_context
from matplotlib.figure import Figure

from rodgen.loading.cache import write_whole
from rodgen.model.palette import DARK, LIGHT, colours_of

PAGE = "index.html"


def render(template: str, **content: Any) -> str:
    """A page from a template of templates/; in HTML all text is escaped."""
    environment = Environment(
        loader=PackageLoader(__package__),
        autoescape=template.endswith(".html.jinja"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(**content)


@contextmanager
def put_whole(folder: Path) -> Iterator[Path]:
    """A folder to make files in, which are put into another when all are made, the page last."""
    with tempfile.TemporaryDirectory(dir=folder, prefix=".making") as making:
        made = Path(making)
        yield made
        for file in sorted(made.iterdir(), key=lambda file: (file.name == PAGE, file.name)):
            if file.name == PAGE:  # with the rights that a new file has
                write_whole(folder / PAGE, file.read_text(encoding="utf-8"))
            else:
                file.replace(folder / file.name)


Part = dict[str, Any]

# On dark pages.
BRIGHT = {
    light: dark
    for name in ("ink", "faint", "axis", "series")
    for light, dark in zip(colours_of(name, LIGHT), colours_of(name, DARK), strict=True)
}


@dataclass(frozen=True)
class Pictures:
    """Folder to which pictures are written."""

    folder: Path

    def save(
        self, figure: Figure | None, name: str, caption: str, alt: str = "", large: bool = False
    ) -> dict[str, Any] | None:
        """Write it; its file and what it shows, None where there is no picture."""
        if figure is None:
            return None
        file = f"{anchor(name)}.svg"
        # The same bytes from the same rows.
        with rc_context({"svg.hashsalt": "rodgen"}):
            figure.savefig(self.folder / file, transparent=True, metadata={"Date": None})
        dark(self.folder / file)
        return {"file": file, "caption": caption, "alt": alt or caption, "large": large}


def anchor(name: str) -> str:
    """Turn a name into that of a place in a page and of a file."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")


def part(title: str, text: list[str], **more: Any) -> Part:
    """Entries of a part for the template; figures that are None are left out."""
    empty: Part = {"figures": [], "tables": [], "folded": [], "legend": [], "said": []}
    more["figures"] = [picture for picture in more.get("figures", ()) if picture]
    return {"anchor": anchor(title), "title": title, "text": text, **empty, **more}


def dark(file: Path) -> None:
    """Let a picture's ink and curves be bright where its reader prefers dark pages."""
    rules = "".join(
        f'[style*="{what}: {colour}"]{{{what}:{bright}!important}}'
        for colour, bright in BRIGHT.items()
        for what in ("fill", "stroke")
    )
    style = f"<style>@media (prefers-color-scheme: dark){{{rules}}}</style>"
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace("<defs>", f"{style}<defs>", 1), encoding="utf-8")
