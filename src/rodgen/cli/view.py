"""rodgen view: the live view of a scene, in a browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import out
from rodgen.cli.errors import BAD_INPUT, fail


def view(
    scene_file: Annotated[
        Path | None, typer.Argument(metavar="SCENE", help="A scene, in TOML.")
    ] = None,
    branch: Annotated[
        Path | None,
        typer.Option(
            "--from", metavar="FILE", help="Start in a state of a branch: FILE of rodgen branch."
        ),
    ] = None,
    at: Annotated[
        int | None, typer.Option(help="Number of the point of FILE; its last, if not given.")
    ] = None,
    folder: Annotated[
        Path | None, typer.Option(help="Scenes to choose from; if not given, those beside SCENE.")
    ] = None,
    host: Annotated[
        str, typer.Option(help="Address to listen on; other than the loopback, a token is needed.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port; 0 takes any that is free.")] = 8642,
    opened: Annotated[
        bool, typer.Option("--open/--no-open", help="Whether to open the page in a browser.")
    ] = True,
) -> None:
    """Watch SCENE move in a browser, change it while it runs, plot anything; Ctrl-C ends it."""
    from rodgen.scene import Scene, SceneError

    if (scene_file is None) == (branch is None):
        raise SceneError(
            "SCENE", scene_file and str(scene_file), "a scene, or --from with a branch"
        )
    if at is not None and branch is None:
        raise SceneError("--at", at, "absent without --from")
    if branch is not None:
        from rodgen.analyse.branches.branch_data import read, scene_at

        scene, beside = scene_at(read(branch), -1 if at is None else at), branch
    elif scene_file is not None:
        scene, beside = Scene.from_toml(scene_file), scene_file
    if not 0 <= port <= 65535:
        raise SceneError("--port", port, "a whole number from 0 to 65535")
    place = folder or beside.resolve().parent
    if not place.is_dir():
        raise SceneError("--folder", str(place), "a folder")
    try:
        from rodgen.live.page.server import Settings, serve
    except ModuleNotFoundError as error:
        # Whatever is not ours comes with the extra, or with what the extra brings.
        if (error.name or "").partition(".")[0] == "rodgen":
            raise
        fail(f'the live view needs more: pip install "rodgen[view]" ({error})', BAD_INPUT)

    def said(address: str) -> None:
        out.print(f"{scene.name} is shown at {address}\nCtrl-C ends it.")

    serve(Settings(scene, place, host, port, opened, said))
    out.print("\nEnded.")
