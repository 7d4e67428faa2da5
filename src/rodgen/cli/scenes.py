"""rodgen scenes: those that come with rodgen; rodgen new: a copy of one, to change."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from rodgen.cli.console import out, print_json
from rodgen.cli.options import AsJson
from rodgen.cli.results import unwritable
from rodgen.loading.cache import write_whole
from rodgen.scene import Scene, SceneError
from rodgen.scene.examples import about, examples, folder, renamed

STUDIES = "studies"


def scenes(as_json: AsJson = False) -> None:
    """List the scenes that come with rodgen, to start from."""
    if as_json:
        kinds = {"scenes": examples(), STUDIES: examples(STUDIES)}
        print_json(
            {
                kind: {name: {"file": str(path), "about": about(path)} for name, path in of.items()}
                for kind, of in kinds.items()
            }
        )
        return
    table = Table("name", "what it is", title="Scenes: rodgen new NAME --from ... copies one")
    for name, path in examples().items():
        table.add_row(name, about(path))
    out.print(table)
    out.print(f"Their files lie in {folder()}, those of studies in its folder {STUDIES}:")
    out.print(f"{', '.join(examples(STUDIES))}.")


def new(
    name: Annotated[str, typer.Argument(help="Name of the scene, and of its file.")],
    source: Annotated[
        str, typer.Option("--from", metavar="EXAMPLE", help="Scene to copy: one of rodgen scenes.")
    ] = "missile",
    folder: Annotated[Path, typer.Option("--out", help="Folder for the file.")] = Path(),
) -> None:
    """Write NAME.toml, a copy of a scene that comes with rodgen, to change."""
    Scene.example(source).replace({"name": name})
    path = folder / f"{name}.toml"
    if path.exists():
        raise SceneError("NAME", name, f"new: {path} is there already")
    try:
        write_whole(path, renamed(source, name))
    except OSError as error:
        raise unwritable(folder, error) from None
    out.print(f"Written: {path}. Next: rodgen run {path}")
