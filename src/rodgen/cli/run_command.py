"""rodgen run: a scene integrated, its results written."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from rodgen.cli.console import err, out, picture_settings, print_json, show_run, show_work
from rodgen.cli.exits import (
    FAILED_RUN,
    INTERRUPTED,
    fail,
    ignore_ctrl_c,
    restore_ctrl_c,
    treat_signals_as_ctrl_c,
)
from rodgen.cli.options import AsJson, OutFolder, complete_words
from rodgen.cli.result_folders import (
    check_same_run,
    files_to_replace,
    output_folder,
    refuse_unwritable,
)
from rodgen.emit.targets import TARGETS
from rodgen.integrate import Interrupted, RunError, Solution, resume, simulate
from rodgen.integrate.files.saver import check_interval, checkpoint_path
from rodgen.integrate.methods.compiled_integrator import initial_parts
from rodgen.integrate.simulate import add_error_growth, check_samples
from rodgen.loading import build, build_or_explain, companions, sources
from rodgen.loading.cache import write_whole
from rodgen.model.methods import METHODS
from rodgen.scene import Scene
from rodgen.scene.integration import AUTO, IntegrationSettings, check_settings_used
from rodgen.system import System

RESULT, SUMMARY = "solution.nc", "summary.txt"


def run(
    context: typer.Context,
    scene: Scene,
    method: Annotated[
        str | None,
        typer.Option(
            help=f"Method to use instead of the scene's: {', '.join((AUTO, *METHODS))}.",
            autocompletion=complete_words([AUTO, *METHODS]),
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
            help="numpy or c. Default: c if it can be built.",
            autocompletion=complete_words(TARGETS),
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
    as_json: AsJson = False,
) -> None:
    """Integrate SCENE, and write states, pictures and a summary."""
    check_interval(checkpoint, "--checkpoint")
    overrides: IntegrationSettings = {
        "method": method,
        "span": span,
        "step": step,
        "rtol": rtol,
        "atol": atol,
        "output_every": output_every,
    }
    scene = scene.with_integrate(**overrides)
    check_settings_used(scene.integrate, overrides, prefix="--")
    check_samples(System.of(scene), to_file=True)
    start, end = scene.integrate.span
    folder = out_folder / scene.name
    file = folder / RESULT
    without_c, stale = "", list[Path]()
    if resumed:
        check_same_run(scene, file)
    else:
        with show_work("generating"):
            wanted = initial_parts(scene.integrate, target)
            if target:
                model = build(scene, target, parts=wanted)
            else:
                model, without_c = build_or_explain(scene, wanted)
        context.with_resource(output_folder(folder))
        stale = files_to_replace(scene, file)
    treat_signals_as_ctrl_c()
    with show_run(scene.name, start, end) as update:
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
            ignore_ctrl_c()
            solution, status = error.solution, INTERRUPTED
    if status == INTERRUPTED:  # below the bar, which is gone
        err.print(f"rodgen: {solution.message}; writing what was computed")
    if error_growth and not status:
        _find_error_growth(solution)
    with np.errstate(all="ignore"):  # a run that blew up has energies that overflow
        pictured = status != INTERRUPTED and len(solution.t) > 0
        written = _write_results(solution, folder, without_c, stale, pictured)
        if as_json:
            print_json(solution.to_dict() | {"folder": str(folder), "files": written})
        else:
            out.print((folder / SUMMARY).read_text(encoding="utf-8"), end="")
            out.print(f"Written to {folder}: {', '.join(written)}.")
    if status:
        does = "goes on with it" if checkpoint_path(file).exists() else "starts it again"
        again = f"; --resume {does}" if status == INTERRUPTED else ""
        until = f"up to t = {solution.t[-1]:.9g} s" if len(solution.t) else "(none)"
        kept = f"samples {until} are in {folder}"
        fail(f"{solution.message}; {kept}{again}", status)


def _find_error_growth(solution: Solution) -> None:
    """Measure how fast errors grow in the run, unless Ctrl-C stops that."""
    try:
        with show_work("following a neighbouring motion"):
            add_error_growth(solution)
    except KeyboardInterrupt:
        ignore_ctrl_c()
        err.print("rodgen: interrupted: how fast errors grow is not known")


def _write_results(
    solution: Solution, folder: Path, without_c: str, stale: list[Path], pictured: bool
) -> list[str]:
    """Write summary, module and pictures of a run; returns the names of its files. Ctrl-C can still
    leave out the pictures; where the run itself was stopped by it, there are none.

    without_c: why the C module was not used; stale: files of the module that was there before.
    """
    ignore_ctrl_c()
    from rodgen.show.summary import summary

    words = summary(solution, without_c)
    model = solution.model
    assert model is not None
    target = model.PROVENANCE["target"]
    texts = sources(solution.scene, target) | companions(target)
    # Of what lies in a folder, the folder.
    written = [RESULT, SUMMARY, *dict.fromkeys("".join(n.partition("/")[:2]) for n in texts)]
    with refuse_unwritable(folder), show_work("writing") as step:
        write_whole(folder / SUMMARY, words)
        for name, text in texts.items():
            write_whole(folder / name, text)
        for file in stale:
            if file.name not in texts:
                file.unlink(missing_ok=True)
        step(RESULT)
        settings = picture_settings()
        if pictured and settings:
            restore_ctrl_c()
            from rodgen.show.run_pictures import save_pictures

            made = save_pictures(solution, folder, settings)
            written += [picture.name for picture in made]
    return written
