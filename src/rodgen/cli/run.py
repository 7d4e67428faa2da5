"""rodgen run: a scene integrated, its results written."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from rodgen.cli.console import err, out, progress, working
from rodgen.cli.errors import FAILED_RUN, INTERRUPTED, fail
from rodgen.cli.folders import unwritable, writable
from rodgen.integrate import Interrupted, RunError, Solution, simulate
from rodgen.loading import build, build_fastest, sources
from rodgen.loading.cache import write_whole
from rodgen.scene import Scene, SceneError
from rodgen.scene.tables import FIXED_STEP


def run(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene, in TOML.")],
    method: Annotated[str | None, typer.Option(help="Instead of the scene's method.")] = None,
    step: Annotated[float | None, typer.Option(help="Step of a fixed-step method [s].")] = None,
    rtol: Annotated[float | None, typer.Option(help="Relative tolerance.")] = None,
    target: Annotated[
        str | None, typer.Option(help="numpy or c; if not given, c where it can be built.")
    ] = None,
    out_folder: Annotated[
        Path, typer.Option("--out", help="Folder in which a folder of the scene's name is made.")
    ] = Path("results"),
) -> None:
    """Integrate SCENE; write states, pictures and a summary, and say what came out."""
    scene = Scene.from_toml(scene_file).with_integrate(method=method, step=step, rtol=rtol)
    _used(scene, step, rtol)
    with working("generating"):
        model = build(scene, target) if target else build_fastest(scene)
    folder = writable(out_folder / scene.name)
    start, end = scene.integrate.span
    with progress(scene.name, start, end) as update:
        try:
            solution, status = simulate(scene, model=model, progress=update), 0
        except RunError as error:
            solution, status = error.solution, FAILED_RUN
        except Interrupted as error:
            _hold_back_ctrl_c()
            solution, status = error.solution, INTERRUPTED
            err.print(f"rodgen: {error.solution.message}; writing what was computed")
    with np.errstate(all="ignore"):  # a run that blew up has energies that overflow
        _write(solution, folder, model.PROVENANCE["target"])
    if status:
        kept = f"samples up to t = {solution.t[-1]:.9g} s are in {folder}"
        fail(f"{solution.message}; {kept}", status)


def _used(scene: Scene, step: float | None, rtol: float | None) -> None:
    """Refuse options that the method has no use for."""
    method = scene.integrate.method
    if step is not None and method not in FIXED_STEP:
        raise SceneError("--step", step, f"absent: {method} chooses its own steps")
    if rtol is not None and method in FIXED_STEP:
        raise SceneError("--rtol", rtol, f"absent: {method} has a fixed step")


def _write(solution: Solution, folder: Path, target: str) -> None:
    """States first, since they cost most; everything else can be made from them. Ctrl-C can
    still leave out the pictures."""
    _hold_back_ctrl_c()
    from rodgen.view.pictures import save_pictures
    from rodgen.view.summary import summary

    words = summary(solution)
    texts = sources(solution.scene, target)
    try:
        with working("writing") as step:
            solution.save(folder / "solution.nc")
            write_whole(folder / "summary.txt", words)
            for name, text in texts.items():
                write_whole(folder / name, text)
            _let_ctrl_c_through()
            step("solution.nc")
            pictures = save_pictures(solution, folder)
    except OSError as error:
        raise unwritable(folder, error) from None
    out.print(words, end="")
    names = ", ".join(picture.name for picture in pictures)
    out.print(f"Written to {folder}: solution.nc, summary.txt, {', '.join(texts)}, {names}.")


def _hold_back_ctrl_c() -> None:
    """What was computed is to be written first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _let_ctrl_c_through() -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)
