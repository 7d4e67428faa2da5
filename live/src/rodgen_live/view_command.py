"""rodgen view: the live view of a scene, in a browser."""

from __future__ import annotations

import gc
import sys
import webbrowser
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Annotated

import typer

from rodgen.cli.console import out
from rodgen.cli.options import Changes, PointNumber, point_number, read_scene
from rodgen.errors import InputError
from rodgen.scene.examples import find_example
from rodgen_live.page.address import address_of, listen

if TYPE_CHECKING:
    from rodgen.scene import Scene

FIRST = "flutter"  # scene of rodgen that is shown by default
RESULT = ".nc"  # what a file of a result ends in


def view(
    scene_file: Annotated[
        Path | None,
        typer.Argument(
            metavar="SCENE",
            help=f"A scene, in TOML. With --export also a result. Default: the scene {FIRST} of"
            " rodgen, a column that flutters.",
        ),
    ] = None,
    branch: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="FILE",
            help="Start in a state of a branch, or on one of its cycles. FILE is written by rodgen"
            " branch or rodgen cycle-branch.",
        ),
    ] = None,
    point: PointNumber = None,
    folder: Annotated[
        Path | None,
        typer.Option(help="Folder of the scenes to choose from. Default: that of SCENE."),
    ] = None,
    changes: Changes = None,
    host: Annotated[
        str,
        typer.Option(help="Address to listen on. Other addresses than the loopback need a token."),
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port. 0 takes any free port.")] = 8642,
    paused: Annotated[
        bool, typer.Option("--paused/--moving", help="Whether the rod waits or moves at first.")
    ] = False,
    export: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Write the run of SCENE, or a result in NetCDF, as a page that needs no server. "
            "FOLDER/index.html opens from the file system.",
        ),
    ] = None,
    opened: Annotated[
        bool, typer.Option("--open/--no-open", help="Whether to open the page in a browser.")
    ] = True,
) -> None:
    """Watch SCENE move in a browser, change it while it runs, and plot it. Ctrl-C ends it."""
    if scene_file is not None and branch is not None:
        raise InputError("SCENE", str(scene_file), "absent beside --from")
    if branch is None:
        scene_file = scene_file or find_example(FIRST)
    if changes and branch is not None:
        raise InputError("--set", changes, "absent beside --from")
    if export is not None and scene_file is not None and scene_file.suffix == RESULT:
        if changes:
            raise InputError("--set", changes, "absent beside a result")
        _export_page(export, scene_file)
        return
    number = point_number(branch, point, "--from")
    text = ""
    if branch is not None:
        scene, beside = _scene_at_point(branch, number), branch
    elif scene_file is not None:
        scene, beside = read_scene(scene_file, changes), scene_file
        text = scene_file.read_text("utf-8")
        if changes:
            from rodgen_live.run.scene_text import edited_text

            text = edited_text(text, read_scene(scene_file, None), scene)
    if export is not None:
        _export_page(export, scene)
        return
    if not 0 <= port <= 65535:
        raise InputError("--port", port, "a whole number from 0 to 65535")
    place = folder or beside.resolve().parent
    if not place.is_dir():
        raise InputError("--folder", str(place), "a folder")
    with listen(host, port) as listening:
        address = address_of(host, listening)
        out.print(f"{scene.name} is shown at {address.told}\nCtrl-C ends it.")
        if opened:
            Thread(target=webbrowser.open, args=(address.here,), daemon=True).start()
        # NiceGUI's access from afar, which is not used: to import it reads all certificates.
        sys.modules["aiohttp"] = None  # type: ignore[assignment]
        gc.disable()
        from rodgen_live.page.server import ServerSettings, serve  # while the browser starts

        gc.enable()
        serve(ServerSettings(scene, place, text, not paused), listening, address)
    out.print("\nEnded.")


def _export_page(folder: Path, run: Scene | Path) -> None:
    """Write the run of a scene, or that in a file, as many samples of it as the live view keeps, as
    a page, once it is known that the folder can be written."""
    from rodgen.integrate.files.reader import load
    from rodgen.integrate.simulate import simulate
    from rodgen_live.page.export import check_folder, export
    from rodgen_live.sample_store import MOST

    check_folder(folder)
    export(load(run, MOST) if isinstance(run, Path) else simulate(run), folder)
    out.print(f"Written: {folder / 'index.html'}")


def _scene_at_point(file: Path, number: int) -> Scene:
    """The scene that starts in the state of a point of a branch in a file."""
    from rodgen.analyse.branches import equilibrium_data
    from rodgen.analyse.curves.curve_datasets import read_curve
    from rodgen.analyse.cycles import cycle_data

    data = read_curve(
        file, "--from", "a branch", equilibrium_data.FORMAT.name, cycle_data.FORMAT.name
    )
    if data.attrs["format"] == cycle_data.FORMAT.name:
        return cycle_data.scene_at(data, number)
    return equilibrium_data.scene_at(data, number)
