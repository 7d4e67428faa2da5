"""Options that commands share, added when a command is registered.

All take --quiet; those that ask for a Scene take SCENE, a file, and --set; those with an OutFolder
take --no-pictures.
"""

from __future__ import annotations

import inspect
import re
import tomllib
from collections.abc import Callable, Sequence
from functools import wraps
from inspect import Parameter
from pathlib import Path
from typing import Annotated, Any

import typer

from rodgen.cli.completion import complete_keys
from rodgen.cli.console import print_doubts, set_output
from rodgen.cli.options import OutFolder
from rodgen.errors import InputError
from rodgen.scene import Scene

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="A scene, in TOML.")]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Set a key of SCENE to another value, such as loads.follower.force=300. KEY= removes "
        "the key. Can be given several times.",
        autocompletion=complete_keys,
    ),
]
Quiet = Annotated[
    bool, typer.Option("--quiet", help="Print only errors, warnings and the output of --json.")
]
NoPictures = Annotated[bool, typer.Option("--no-pictures", help="Draw no pictures.")]
SCENE, SET, QUIET, NO_PICTURES = "scene", "changes", "quiet", "no_pictures"


def add_common_options(command: Callable[..., object]) -> Callable[..., object]:
    """Add the options that a command shares with others."""
    signature = inspect.signature(command, eval_str=True)
    asked = signature.parameters
    takes_scene = SCENE in asked and asked[SCENE].annotation is Scene
    draws = any(one.annotation == OutFolder for one in asked.values())
    added: dict[str, Any] = {QUIET: Quiet}
    added |= {SET: Changes} if takes_scene else {}
    added |= {NO_PICTURES: NoPictures} if draws else {}

    @wraps(command)
    def run_command(*args: Any, **given: Any) -> object:
        shared = {name: given.pop(name) for name in added}
        if takes_scene:
            given[SCENE] = read_scene(given[SCENE], shared[SET])
        how = set_output(quiet=shared[QUIET], pictures=not shared.get(NO_PICTURES))
        with how, print_doubts():
            return command(*args, **given)

    parameters = [
        one.replace(annotation=SceneFile) if takes_scene and name == SCENE else one
        for name, one in asked.items()
    ]
    parameters += [
        Parameter(
            name, Parameter.KEYWORD_ONLY, default=False if name != SET else None, annotation=kind
        )
        for name, kind in added.items()
    ]
    vars(run_command)["__signature__"] = signature.replace(parameters=parameters)
    run_command.__annotations__ = {one.name: one.annotation for one in parameters}
    return run_command


def read_scene(path: Path, changes: Sequence[str] | None) -> Scene:
    """Read a scene and set some keys, each given as KEY=VALUE. Raises InputError."""
    scene = Scene.from_toml(path)
    return scene.replace(dict(map(_parse_change, changes))) if changes else scene


def _parse_change(text: str) -> tuple[str, Any]:
    key, equals, value = (part.strip() for part in text.partition("="))
    if not (equals and re.fullmatch(r"[\w-]+(\.[\w-]+)*", key)):
        raise InputError("--set", text, "KEY=VALUE, such as loads.follower.force=300")
    return key, _parse_value(value)


def _parse_value(text: str) -> Any:
    """Parse a value of TOML, or else text, which needs no quotes; None for an empty text."""
    if not text:
        return None
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return table["value"] if len(table) == 1 else text
