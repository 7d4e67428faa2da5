"""rodgen derive: equations proven, module written."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from rodgen.check.proofs import MOST_EXPLICIT, Proof, prove
from rodgen.cli.console import out, print_json, print_result, show_work
from rodgen.cli.exits import DISPROVEN, fail
from rodgen.cli.options import AsJson, Changes, complete_list, complete_words, read_scene
from rodgen.cli.result_folders import output_folder, refuse_unwritable
from rodgen.emit.targets import FORMS, TARGETS, available_parts, check_output, required_parts
from rodgen.errors import InputError, Missing
from rodgen.loading import companions, sources
from rodgen.loading.cache import write_whole
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import TERMS, THESIS_TERMS
from rodgen.scene import Structure
from rodgen.scene.term_texts import check_choice, parse_terms

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
            help=f"One of {', '.join(BOUNDARIES)}. Default: free.",
            autocompletion=complete_words(BOUNDARIES),
        ),
    ] = None,
    inertia: Annotated[
        str | None,
        typer.Option(
            help=f"One of {', '.join(INERTIAS)}. Default: uniform.",
            autocompletion=complete_words(INERTIAS),
        ),
    ] = None,
    terms: Annotated[
        str | None,
        typer.Option(
            help=f"all (without {OTHERS}), none, or a list with commas. Default: all.",
            autocompletion=complete_list(["all", "none", *TERMS]),
        ),
    ] = None,
    target: Annotated[
        str,
        typer.Option(
            help=f"{', '.join(TARGETS)} or both.", autocompletion=complete_words([*TARGETS, "both"])
        ),
    ] = "numpy",
    form: Annotated[
        str, typer.Option(help=f"One of {', '.join(FORMS)}.", autocompletion=complete_words(FORMS))
    ] = "chain",
    out_folder: Annotated[Path, typer.Option("--out", help="Folder for the module.")] = Path(),
    parts: Annotated[
        str,
        typer.Option(
            help=f"all, or a list with commas of {', '.join(available_parts('c'))}.",
            autocompletion=complete_list(["all", *available_parts("c")]),
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
    structure = _read_structure(given, scene_file, changes)
    check_choice("target", target, (*TARGETS, "both"))
    targets = TARGETS if target == "both" else (target,)
    for one in targets:
        check_output(one, form)
    wanted = None if parts == "all" else [part.strip() for part in parts.split(",")]
    for one in targets:
        required_parts(one, wanted, with_steps and target != "both")
    with output_folder(out_folder):
        proof = _prove(structure, explicit)
        if not as_json:
            print_result(f"{structure.stem}: entries equal to the closed form, exactly", proof)
            out.print(_describe_total(proof))
        with show_work("generating"):
            texts: dict[str, str] = {}
            for one in targets:
                steps = with_steps and (one == "c" or target != "both")
                texts |= sources(structure, one, form, wanted, steps) | companions(
                    one, wanted, steps
                )
        for name, text in texts.items():
            said = _write_module(out_folder / name, text)
            if not as_json:
                out.print(said)
        if as_json:
            print_json(proof.to_dict() | {"files": [str(out_folder / name) for name in texts]})


def _read_structure(
    given: Mapping[str, str | None], scene_file: Path | None, changes: Sequence[str] | None
) -> Structure:
    """Structure to derive: that of a scene, or of the options. Raises InputError."""
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
        _parse_whole(links), boundary or "free", inertia or "uniform", parse_terms(terms or "all")
    )


def _parse_whole(text: str) -> int:
    if not re.fullmatch(r"-?[0-9]{1,18}", text):
        raise InputError("links", text, "a whole number")
    return int(text)


def _prove(structure: Structure, explicit: bool) -> Proof:
    try:
        with show_work("deriving and comparing") as step:
            return prove(structure, explicit, lambda held: step(f"{held.name}, {held.how}"))
    except ArithmeticError as error:
        fail(f"the equations are not proven: {error}", DISPROVEN)


def _describe_total(proof: Proof) -> str:
    """Words on the number of all entries, and on when they were proven."""
    words = "proven earlier, unchanged since" if proof.kept else f"proven in {proof.seconds:.1f} s"
    if any(one.how == "rational points" for one in proof.comparisons):
        words += f"; beyond {MOST_EXPLICIT} links not by LagrangesMethod (see --explicit)"
    return f"{proof.entries} entries; {words}"


def _write_module(path: Path, text: str) -> str:
    with refuse_unwritable(path.parent):
        if path.is_file() and path.read_text(encoding="utf-8") == text:
            return f"{path} is up to date"
        write_whole(path, text)
    return f"wrote {path} ({len(text.encode())} bytes)"
