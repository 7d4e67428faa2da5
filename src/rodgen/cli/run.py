"""rodgen run: a scene integrated, its results written."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from rodgen.cli.completion import words
from rodgen.cli.console import (
    drawn,
    err,
    out,
    print_json,
    progress,
    working,
)
from rodgen.cli.errors import FAILED_RUN, INTERRUPTED, fail
from rodgen.cli.options import OutFolder
from rodgen.cli.results import check_same, promised, to_replace, unwritable
from rodgen.cli.signals import end_as_by_ctrl_c, hold_back_ctrl_c, let_ctrl_c_through
from rodgen.emit.targets import TARGETS
from rodgen.integrate import Interrupted, RunError, Solution, resume, simulate
from rodgen.integrate.files.checkpoint import beside
from rodgen.integrate.files.saver import check_every
from rodgen.integrate.methods.compiled import parts
from rodgen.integrate.simulate import check_samples, follow_errors
from rodgen.loading import build, companions, fastest, sources
from rodgen.loading.cache import write_whole
from rodgen.model.methods import METHODS
from rodgen.scene import Scene
from rodgen.scene.integration import AUTO, Settings, check_used
from rodgen.system import System

RESULT, SUMMARY = "solution.nc", "summary.txt"


def run(
    context: typer.Context,
    scene: Scene,
    method: Annotated[
        str | None,
        typer.Option(
            help=f"Method to use instead of the scene's: {', '.join((AUTO, *METHODS))}.",
            autocompletion=words([AUTO, *METHODS]),
        ),
    ] = None,
    step: Annotated[float | None, typer.Option(help="Step of a fixed-step method [s].")] = None,
    rtol: Annotated[float | None, typer.Option(help="Relative tolerance.")] = None,
    atol: Annotated[float | None, typer.Option(help="Absolute tolerance.")] = None,
    span: Annotated[
        tuple[float, float] | None,
        typer.Option(metavar="START END", help="Span to use instead of the scene's [s]."),
    ] = None,
    output_every: Annotated[float | None, typer.Option(help="Spacing of the samples [s].")] = None,
    target: Annotated[
        str | None,
        typer.Option(
            help="numpy or c. Default: c if it can be built.", autocompletion=words(TARGETS)
        ),
    ] = None,
    out_folder: OutFolder = Path("results"),
    checkpoint: Annotated[
        float,
        typer.Option(help="Seconds between two saved states, from which --resume can continue."),
    ] = 30.0,
    error_growth: Annotated[
        bool, typer.Option("--error-growth", help="Also measure how fast small errors grow.")
    ] = False,
    resumed: Annotated[
        bool, typer.Option("--resume", help="Continue the run of SCENE that was stopped.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the results as one JSON object.")
    ] = False,
) -> None:
    """Integrate SCENE, and write states, pictures and a summary."""
    check_every(checkpoint, "--checkpoint")
    overrides: Settings = {
        "method": method,
        "span": span,
        "step": step,
        "rtol": rtol,
        "atol": atol,
        "output_every": output_every,
    }
    scene = scene.with_integrate(**overrides)
    check_used(scene.integrate, overrides, prefix="--")
    check_samples(System.of(scene), to_file=True)
    start, end = scene.integrate.span
    folder = out_folder / scene.name
    file = folder / RESULT
    without_c, stale = "", list[Path]()
    if resumed:
        check_same(scene, file)
    else:
        with working("generating"):
            wanted = parts(scene.integrate, target)
            if target:
                model = build(scene, target, parts=wanted)
            else:
                model, without_c = fastest(scene, wanted)
        context.with_resource(promised(folder))
        stale = to_replace(scene, file)
    end_as_by_ctrl_c()
    with progress(scene.name, start, end) as update:
        try:
            if resumed:
                solution = resume(file, progress=update, checkpoint=checkpoint)
            else:
                solution = simulate(
                    scene, model=model, progress=update, out=file, checkpoint=checkpoint
                )
            status = 0
        except RunError as error:
            solution, status = error.solution, FAILED_RUN
        except Interrupted as error:
            hold_back_ctrl_c()
            solution, status = error.solution, INTERRUPTED
    if status == INTERRUPTED:  # below the bar, which is gone
        err.print(f"rodgen: {solution.message}; writing what was computed")
    if error_growth and not status:
        _find_error_growth(solution)
    with np.errstate(all="ignore"):  # a run that blew up has energies that overflow
        pictured = status != INTERRUPTED and len(solution.t) > 0
        written = _write(solution, folder, without_c, stale, pictured)
        if as_json:
            print_json(solution.to_dict() | {"folder": str(folder), "files": written})
        else:
            out.print((folder / SUMMARY).read_text(encoding="utf-8"), end="")
            out.print(f"Written to {folder}: {', '.join(written)}.")
    if status:
        does = "goes on with it" if beside(file).exists() else "starts it again"
        again = f"; --resume {does}" if status == INTERRUPTED else ""
        until = f"up to t = {solution.t[-1]:.9g} s" if len(solution.t) else "(none)"
        kept = f"samples {until} are in {folder}"
        fail(f"{solution.message}; {kept}{again}", status)


def _find_error_growth(solution: Solution) -> None:
    """How fast errors grow in the run, unless that is stopped by Ctrl-C."""
    try:
        with working("following a neighbouring motion"):
            follow_errors(solution)
    except KeyboardInterrupt:
        hold_back_ctrl_c()
        err.print("rodgen: interrupted: how fast errors grow is not known")


def _write(
    solution: Solution, folder: Path, without_c: str, stale: list[Path], pictured: bool
) -> list[str]:
    """What is made from the states, which are there already, as names of files. Ctrl-C can still
    leave out the pictures; where the run itself was stopped by it, there are none.

    without_c: why the C module was not used; stale: files of the module that was there before.
    """
    hold_back_ctrl_c()
    from rodgen.show.summary import summary

    words = summary(solution, without_c)
    model = solution.model
    assert model is not None
    target = model.PROVENANCE["target"]
    texts = sources(solution.scene, target) | companions(target)
    # Of what lies in a folder, the folder.
    written = [RESULT, SUMMARY, *dict.fromkeys("".join(n.partition("/")[:2]) for n in texts)]
    try:
        with working("writing") as step:
            write_whole(folder / SUMMARY, words)
            for name, text in texts.items():
                write_whole(folder / name, text)
            for file in stale:
                if file.name not in texts:
                    file.unlink(missing_ok=True)
            step(RESULT)
            if pictured and drawn():
                let_ctrl_c_through()
                from rodgen.show.pictures import save_pictures

                written += [picture.name for picture in save_pictures(solution, folder)]
    except OSError as error:
        raise unwritable(folder, error) from None
    return written
