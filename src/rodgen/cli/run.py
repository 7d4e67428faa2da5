"""rodgen run: a scene integrated, its results written."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from rodgen.cli.console import out, progress
from rodgen.cli.errors import FAILED_RUN, INTERRUPTED, fail
from rodgen.integrate import Interrupted, RunError, Solution, simulate
from rodgen.loading import load_text, source
from rodgen.scene import Scene, SceneError


def run(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene, in TOML.")],
    method: Annotated[str | None, typer.Option(help="Instead of the scene's method.")] = None,
    step: Annotated[float | None, typer.Option(help="Step of a fixed-step method [s].")] = None,
    rtol: Annotated[float | None, typer.Option(help="Relative tolerance.")] = None,
    out_folder: Annotated[
        Path, typer.Option("--out", help="Folder in which a folder of the scene's name is made.")
    ] = Path("results"),
) -> None:
    """Integrate SCENE; write states, pictures and a summary, and say what came out."""
    scene = Scene.from_toml(scene_file).with_integrate(method=method, step=step, rtol=rtol)
    folder = _folder(out_folder / scene.name)
    text = source(scene)
    model = load_text(text, scene.structure.stem)
    start, end = scene.integrate.span
    with progress(scene.name, start, end) as update:
        try:
            solution, status = simulate(scene, model=model, progress=update), 0
        except RunError as error:
            solution, status = error.solution, FAILED_RUN
        except Interrupted as error:
            solution, status = error.solution, INTERRUPTED
    with np.errstate(all="ignore"):  # a run that blew up has energies that overflow
        _write(solution, folder, f"{scene.structure.stem}.py", text)
    if status:
        fail(
            f"{solution.message}; samples up to t = {solution.t[-1]:.9g} s are in {folder}", status
        )


def _folder(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".write_test"
        probe.touch()
        probe.unlink()
    except OSError as error:
        reason = error.strerror or str(error)
        raise SceneError("--out", str(folder), f"a folder to write into ({reason})") from None
    return folder


def _write(solution: Solution, folder: Path, module_name: str, module_text: str) -> None:
    from rodgen.loading.cache import write_whole
    from rodgen.view.pictures import save_pictures
    from rodgen.view.summary import summary

    words = summary(solution)
    try:
        solution.save(folder / "solution.nc")
        write_whole(folder / module_name, module_text)
        write_whole(folder / "summary.txt", words)
        pictures = save_pictures(solution, folder)
    except OSError as error:
        reason = error.strerror or str(error)
        raise SceneError("--out", str(folder), f"a folder to write into ({reason})") from None
    out.print(words, end="")
    names = ", ".join(picture.name for picture in pictures)
    out.print(f"Written to {folder}: solution.nc, summary.txt, {module_name}, {names}.")
