"""rodgen run: a scene integrated, its results written."""

from __future__ import annotations

import signal
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from rodgen.cli.console import err, out, progress, working
from rodgen.cli.errors import FAILED_RUN, INTERRUPTED, fail
from rodgen.cli.folders import unwritable, writable
from rodgen.cli.options import OutFolder, SceneFile
from rodgen.integrate import Interrupted, RunError, Solution, StepWarning, resume, simulate
from rodgen.integrate.files.checkpoint import beside
from rodgen.integrate.files.storage import load
from rodgen.loading import build, build_fastest, sources
from rodgen.loading.cache import write_whole
from rodgen.scene import Scene, SceneError
from rodgen.scene.tables import AUTO, FIXED_STEP

RESULT = "solution.nc"


def run(
    scene_file: SceneFile,
    method: Annotated[str | None, typer.Option(help="Instead of the scene's method.")] = None,
    step: Annotated[float | None, typer.Option(help="Step of a fixed-step method [s].")] = None,
    rtol: Annotated[float | None, typer.Option(help="Relative tolerance.")] = None,
    target: Annotated[
        str | None, typer.Option(help="numpy or c; if not given, c where it can be built.")
    ] = None,
    out_folder: OutFolder = Path("results"),
    checkpoint: Annotated[
        float, typer.Option(help="Seconds between two states from which --resume can go on.")
    ] = 30.0,
    resumed: Annotated[
        bool, typer.Option("--resume", help="Go on with the run of SCENE that was stopped.")
    ] = False,
) -> None:
    """Integrate SCENE; write states, pictures and a summary, and say what came out."""
    given = Scene.from_toml(scene_file)
    scene = given.with_integrate(method=method, step=step, rtol=rtol)
    _used(scene, step, rtol)
    start, end = scene.integrate.span
    if resumed:
        folder = out_folder / scene.name
        _same(scene, folder / RESULT)
    else:
        with working("generating"):
            model = build(scene, target) if target else build_fastest(scene)
        folder = writable(out_folder / scene.name)
    file = folder / RESULT
    # What a batch system sends to end a program is to lose nothing either.
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    with progress(scene.name, start, end) as update, _warned():
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
            _hold_back_ctrl_c()
            solution, status = error.solution, INTERRUPTED
            err.print(f"rodgen: {solution.message}; writing what was computed")
    with np.errstate(all="ignore"):  # a run that blew up has energies that overflow
        _write(solution, folder, pictured=status != INTERRUPTED)
    if status:
        does = "goes on with it" if beside(file).exists() else "starts it again"
        again = f"; --resume {does}" if status == INTERRUPTED else ""
        kept = f"samples up to t = {solution.t[-1]:.9g} s are in {folder}"
        fail(f"{solution.message}; {kept}{again}", status)


def _used(scene: Scene, step: float | None, rtol: float | None) -> None:
    """Refuse options that the method has no use for."""
    method = scene.integrate.method
    if step is not None and method not in FIXED_STEP:
        raise SceneError("--step", step, f"absent: {method} chooses its own steps")
    if rtol is not None and method in FIXED_STEP:
        raise SceneError("--rtol", rtol, f"absent: {method} has a fixed step")


def _same(scene: Scene, file: Path) -> None:
    """Refuse to go on with the run of another scene, or with other options."""
    if not file.exists():
        raise SceneError("--resume", str(file), "a run that was begun; there is none")
    begun = load(file, most=1).scene
    method = scene.integrate.method
    if method == AUTO:
        method = begun.integrate.method
    now, then = (s.model_dump() for s in (scene.with_integrate(method=method), begun))
    other = [
        f"{table}.{key}" if isinstance(now[table], dict) else table
        for table in now
        for key in (now[table] if isinstance(now[table], dict) else [""])
        if (now[table][key] != then[table][key] if key else now[table] != then[table])
    ]
    if other:
        allowed = f"the run of this scene with the same options (changed: {', '.join(other)})"
        raise SceneError("--resume", str(file), allowed)
    if not beside(file).exists():
        err.print("rodgen: there is no state to go on from; the run starts again")


@contextmanager
def _warned() -> Iterator[None]:
    """Warnings of a run as lines of their own."""

    def show(message: Warning | str, *_: object, **__: object) -> None:
        err.print(f"rodgen: warning: {message}")

    with warnings.catch_warnings():
        warnings.simplefilter("always", StepWarning)
        warnings.showwarning = show
        yield


def _write(solution: Solution, folder: Path, pictured: bool) -> None:
    """What is made from the states, which are there already. Ctrl-C can still leave out the
    pictures; where the run itself was stopped by it, there are none."""
    _hold_back_ctrl_c()
    from rodgen.view.summary import summary

    words = summary(solution)
    model = solution.model
    assert model is not None
    texts = sources(solution.scene, model.PROVENANCE["target"])
    written = [RESULT, "summary.txt", *texts]
    try:
        with working("writing") as step:
            write_whole(folder / "summary.txt", words)
            for name, text in texts.items():
                write_whole(folder / name, text)
            step(RESULT)
            if pictured:
                _let_ctrl_c_through()
                from rodgen.view.pictures import save_pictures

                written += [picture.name for picture in save_pictures(solution, folder)]
    except OSError as error:
        raise unwritable(folder, error) from None
    out.print(words, end="")
    out.print(f"Written to {folder}: {', '.join(written)}.")


def _hold_back_ctrl_c() -> None:
    """What was computed is to be written first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _let_ctrl_c_through() -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)
