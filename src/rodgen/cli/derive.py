"""rodgen derive: equations proven, module written."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from rodgen.check.proofs import MOST_EXPLICIT, MOST_JOINTS, Proof, prove
from rodgen.cli.completion import listed_words, words
from rodgen.cli.console import out, print_json, working
from rodgen.cli.errors import DISPROVEN, fail
from rodgen.cli.options import AsJson
from rodgen.cli.results import promised, unwritable
from rodgen.cli.shared import Changes, read_scene
from rodgen.emit.targets import FORMS, TARGETS, check_output, closed, offered
from rodgen.errors import InputError, Missing
from rodgen.loading import companions, sources
from rodgen.loading.cache import write_whole
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import TERMS, THESIS_TERMS
from rodgen.scene import Structure
from rodgen.scene.structure import choose, parse_terms

OTHERS = ", ".join(name for name in TERMS if name not in THESIS_TERMS)


def derive(
    links: Annotated[
        str | None, typer.Argument(metavar="N", help="Number of links. Not allowed with --scene.")
    ] = None,
    scene_file: Annotated[
        Path | None,
        typer.Option("--scene", metavar="FILE", help="Write the module of this scene instead."),
    ] = None,
    changes: Changes = None,
    boundary: Annotated[
        str | None,
        typer.Option(
            help=f"One of {', '.join(BOUNDARIES)}. Default: free.", autocompletion=words(BOUNDARIES)
        ),
    ] = None,
    inertia: Annotated[
        str | None,
        typer.Option(
            help=f"One of {', '.join(INERTIAS)}. Default: uniform.", autocompletion=words(INERTIAS)
        ),
    ] = None,
    terms: Annotated[
        str | None,
        typer.Option(
            help=f"all (without {OTHERS}), none, or a list with commas. Default: all.",
            autocompletion=listed_words(["all", "none", *TERMS]),
        ),
    ] = None,
    target: Annotated[
        str,
        typer.Option(
            help=f"{', '.join(TARGETS)} or both.", autocompletion=words([*TARGETS, "both"])
        ),
    ] = "numpy",
    form: Annotated[
        str, typer.Option(help=f"One of {', '.join(FORMS)}.", autocompletion=words(FORMS))
    ] = "chain",
    out_folder: Annotated[Path, typer.Option("--out", help="Folder for the module.")] = Path(),
    parts: Annotated[
        str,
        typer.Option(
            help=f"all, or a list with commas of {', '.join(offered('c'))}.",
            autocompletion=listed_words(["all", *offered("c")]),
        ),
    ] = "all",
    with_steps: Annotated[
        bool,
        typer.Option(
            "--with-steps",
            help="Also write step loops beside the C module, for runs without rodgen.",
        ),
    ] = False,
    explicit: Annotated[
        bool,
        typer.Option(
            "--explicit", help=f"Run LagrangesMethod with all links beyond {MOST_EXPLICIT} too."
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Derive the equations of N links, or of a scene, prove them, and write the generated module.

    With --json, one JSON object is printed instead of a table. The module is written as well.
    """
    given = {"N": links, "--boundary": boundary, "--inertia": inertia, "--terms": terms}
    structure = _structure(given, scene_file, changes)
    choose("target", target, (*TARGETS, "both"))
    targets = TARGETS if target == "both" else (target,)
    for one in targets:
        check_output(one, form)
    wanted = None if parts == "all" else [part.strip() for part in parts.split(",")]
    for one in targets:
        closed(one, wanted, with_steps and target != "both")
    with promised(out_folder):
        proof = _prove(structure, explicit)
        if not as_json:
            out.print(_table(structure, proof))
        with working("generating"):
            texts: dict[str, str] = {}
            for one in targets:
                steps = with_steps and (one == "c" or target != "both")
                texts |= sources(structure, one, form, wanted, steps) | companions(
                    one, wanted, steps
                )
        for name, text in texts.items():
            said = _write(out_folder / name, text)
            if not as_json:
                out.print(said)
        if as_json:
            print_json(_object(structure, proof, [out_folder / name for name in texts]))


def _structure(
    given: Mapping[str, str | None], scene_file: Path | None, changes: Sequence[str] | None
) -> Structure:
    """What is derived: of a scene, or of what options say. Raises InputError."""
    if scene_file is not None:
        for option, value in given.items():
            if value is not None:
                raise InputError(option, value, "absent beside --scene, which says it")
        return read_scene(scene_file, changes).structure
    if changes:
        raise InputError("--set", changes, "given with --scene, whose keys it changes")
    links, boundary, inertia, terms = given.values()
    if links is None:
        raise InputError("N", Missing(), "given, the number of links, or else --scene FILE")
    return Structure(
        _whole(links), boundary or "free", inertia or "uniform", parse_terms(terms or "all")
    )


def _object(structure: Structure, proof: Proof, files: Sequence[Path]) -> dict[str, Any]:
    proven = [
        {"name": one.name, "how": one.how, "entries": one.entries} for one in proof.comparisons
    ]
    return {
        "module": structure.stem,
        "structure": structure.hash,
        "proven": proven,
        "proven_earlier": proof.kept,
        "files": [str(path) for path in files],
    }


def _whole(text: str) -> int:
    if not re.fullmatch(r"-?[0-9]{1,18}", text):
        raise InputError("links", text, "a whole number")
    return int(text)


def _prove(structure: Structure, explicit: bool) -> Proof:
    try:
        with working("deriving and comparing") as step:
            return prove(structure, explicit, lambda held: step(f"{held.name}, {held.how}"))
    except ArithmeticError as error:
        fail(f"the equations are not proven: {error}", DISPROVEN)


def _table(structure: Structure, proof: Proof) -> Table:
    ways = list(dict.fromkeys(held.how for held in proof.comparisons))
    table = Table(title=f"{structure.stem}: entries equal to the closed form, exactly")
    table.add_column("matrix or load")
    names = list(dict.fromkeys(held.name for held in proof.comparisons))
    for way in ways:
        table.add_column(_heading(way, structure.links), justify="right")
    for name in names:
        counts = {held.how: held.entries for held in proof.comparisons if held.name == name}
        table.add_row(name, *(str(counts.get(way, "")) for way in ways))
    total = sum(held.entries for held in proof.comparisons)
    again = "proven earlier, unchanged since" if proof.kept else f"proven in {proof.seconds:.1f} s"
    table.caption = f"{total} entries; {again}"
    if "rational points" in ways:
        table.caption += f"; beyond {MOST_EXPLICIT} links not by LagrangesMethod (see --explicit)"
    return table


def _heading(way: str, links: int) -> str:
    return {
        "any n": "any n (symbolic)",
        "explicit n": f"n = {links} (LagrangesMethod)",
        "rational points": f"n = {links} (exact, at random rational points)",
        "joint forces": f"n = {min(links, MOST_JOINTS)} (from the joint forces, exact)",
    }[way]


def _write(path: Path, text: str) -> str:
    try:
        if path.is_file() and path.read_text(encoding="utf-8") == text:
            return f"{path} is up to date"
        write_whole(path, text)
    except OSError as error:
        raise unwritable(path.parent, error) from None
    return f"wrote {path} ({len(text.encode())} bytes)"
