"""A part of the report, and the keeping of its pictures."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

from rodgen.view.report_style import dark

Part = dict[str, Any]


@dataclass(frozen=True)
class Pictures:
    """Where pictures are written."""

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
    """As a name of a place in a page and of a file."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")


def part(title: str, text: list[str], **more: Any) -> Part:
    """For the template; figures that are None are left out."""
    empty: Part = {"figures": [], "tables": [], "folded": [], "legend": [], "said": []}
    more["figures"] = [picture for picture in more.get("figures", ()) if picture]
    return {"anchor": anchor(title), "title": title, "text": text, **empty, **more}
