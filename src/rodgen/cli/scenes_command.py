"""rodgen scenes: scenes and studies that come with rodgen; rodgen new: a copy of one, to change."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import out, print_json, print_table
from rodgen.cli.options import AsJson, complete_words
from rodgen.cli.result_folders import refuse_unwritable
from rodgen.errors import InputError
from rodgen.loading.cache import write_whole
from rodgen.result import ResultTable
from rodgen.scene import Scene
from rodgen.scene.examples import (
    STUDIES,
    copy_texts,
    examples,
    examples_folder,
    find_example,
    first_sentence,
    studies,
)


def scenes(as_json: AsJson = False) -> None:
    """List the scenes and studies that come with rodgen."""
    found = {
        kind: {
            name: {"file": str(path), "about": first_sentence(path.read_text("utf-8"))}
            for name, path in of.items()
        }
        for kind, of in (("scenes", examples()), (STUDIES, studies()))
    }
    if as_json:
        print_json(found)
        return
    for kind, listed in found.items():
        rows = [(name, one["about"]) for name, one in listed.items()]
        table = ResultTable.of_rows(("name", "what it is"), rows)
        print_table(f"{kind.title()}: rodgen new NAME --like ...", table)
    out.print(f"Their files lie in {examples_folder()}.")


def new(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="Name of the scene or study, and of its file.")
    ],
    source: Annotated[
        str,
        typer.Option(
            "--like",
            metavar="EXAMPLE",
            help="Scene or study to copy, from the lists of rodgen scenes.",
            autocompletion=complete_words([*examples(), *studies()]),
        ),
    ] = "missile",
    folder: Annotated[Path, typer.Option("--out", help="Folder for the file.")] = Path(),
) -> None:
    """Write NAME.toml, a copy of a scene or a study that comes with rodgen. Change it as you like.

    A study whose scene is a file gets a copy of that, too.
    """
    file, study = find_example(source, examples() | studies()), source in studies()
    _read_scene(file, study).replace({"name": name})  # refuses what is no name
    made = copy_texts(file, name)
    for path in (folder / one for one in made):
        if path.exists():
            raise InputError("NAME", name, f"new: {path} is there already")
    with refuse_unwritable(folder):
        for one, text in made.items():
            write_whole(folder / one, text)
    written = ", ".join(str(folder / one) for one in made)
    run = f"rodgen {'study' if study else 'run'} {folder / f'{name}.toml'}"
    out.print(f"Written: {written}. Next: {run}")


def _read_scene(file: Path, study: bool) -> Scene:
    """Read the scene of a file, or that of a study."""
    if not study:
        return Scene.from_toml(file)
    from rodgen.studies.study import Study

    return Study.from_toml(file).system.scene
