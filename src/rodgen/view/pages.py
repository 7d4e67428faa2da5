"""What all pages share: templates, tables with all digits, folders written whole."""

from __future__ import annotations

import csv
import io
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined

from rodgen.loading.cache import write_whole

PAGE = "index.html"


def render(template: str, **content: Any) -> str:
    """A page from a template of templates/pages; all text is escaped."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    source = files("rodgen.templates").joinpath(template).read_text(encoding="utf-8")
    return environment.from_string(source).render(**content)


def csv_lines(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Rows with all digits, below a head; nothing where there is None."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    for row in rows:
        writer.writerow(["" if cell is None else cell for cell in row])
    return text.getvalue()


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
