"""Options of commands: those that several have, what is parsed of them, and their completion.

Some are added when a command is registered: all take --quiet; those that ask for a Scene take
SCENE, a file, and --set; those with an OutFolder take --no-pictures, --format and --width. With
--json pictures are drawn only where --format or --width asks for them.
"""

from __future__ import annotations

import inspect
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from inspect import Parameter
from pathlib import Path
from typing import Annotated, Any

import typer

from rodgen.cli.console import print_doubts, set_output
from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen.scene.keys import keys_of
from rodgen.scene.number_text import NumberText
from rodgen.show.picture_settings import FORMATS, PictureSettings, parse_width

Complete = Callable[[str], list[str]]


def complete_words(known: Iterable[str]) -> Complete:
    """Completion to one of these words."""
    listed = list(known)
    return lambda incomplete: [word for word in listed if word.startswith(incomplete)]


def complete_list(known: Iterable[str]) -> Complete:
    """Completion of the last word of a list with commas."""
    one = complete_words(known)

    def complete(incomplete: str) -> list[str]:
        before, comma, last = incomplete.rpartition(",")
        return [f"{before}{comma}{word}" for word in one(last)]

    return complete


def complete_keys(incomplete: str) -> list[str]:
    """Complete the dotted name of a key of scenes."""
    return complete_words(keys_of(Scene))(incomplete)


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
PictureFormat = Annotated[
    str | None,
    typer.Option(
        "--format",
        metavar="|".join(FORMATS),
        help=f"Format of pictures, by default {FORMATS[0]}. Those in vectors have no title, and "
        "their text is text. With --json, pictures are drawn only if --format or --width is given.",
        autocompletion=complete_words(FORMATS),
    ),
]
PictureWidth = Annotated[
    str | None,
    typer.Option(
        "--width",
        metavar="LENGTH",
        help="Width of every picture with its unit, such as 3.3in or 84mm. Fonts stay as they are.",
    ),
]
AtTime = Annotated[
    float | None,
    typer.Option(
        "--t",
        help="Time within the span at which loads are taken [s]. Default: the start of the span.",
    ),
]
CheckMesh = Annotated[
    bool,
    typer.Option(
        "--check-mesh",
        help="Also compute with twice as many links, and say what changes by more than 1 %.",
    ),
]
Speed = Annotated[
    float | None,
    typer.Option(
        help="Speed of a free rod along its axis, nose first [m/s]. Default: that of the initial "
        "state."
    ),
]
After = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS",
        help="Take loads, speed and direction from a run of SCENE after this time.",
    ),
]
OutFolder = Annotated[
    Path,
    typer.Option(
        "--out", help="Folder for results. A folder of the scene's or study's name is made in it."
    ),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object instead of tables and pictures.")
]
Bounds = Annotated[str, typer.Option("--bounds", metavar="A,B", help="Range of the number.")]
Vary = Annotated[
    str,
    typer.Option(
        metavar="KEY",
        help="Number that is varied, such as loads.follower.force.",
        autocompletion=complete_keys,
    ),
]
ResumeFile = Annotated[
    Path | None,
    typer.Option(
        "--resume",
        metavar="FILE",
        help="Continue the same command, which was stopped and writes FILE, where it was; or the "
        "curve in FILE of such a command from its last point.",
    ),
]
PointNumber = Annotated[
    int | None, typer.Option("--point", help="Number of a point of FILE. Default: the last.")
]
LongestStep = Annotated[
    float, typer.Option("--step", help="Longest step along the curve, as a share of the range.")
]
Segments = Annotated[int, typer.Option(help="Number of parts into which the period is cut.")]
MostPoints = Annotated[
    int, typer.Option("--max-points", help="Largest number of points, to each side.")
]
LAST = -1  # the number of a point, if not given
SCENE, SET, QUIET, NO_PICTURES = "scene", "changes", "quiet", "no_pictures"
FORMAT, WIDTH, JSON = "format", "width", "as_json"
DEFAULTS = dict.fromkeys((SET, FORMAT, WIDTH))  # of the others: False


def parse_bounds(text: str) -> tuple[float | None, float | None]:
    """Parse a range that is given as A,B, either of which may be left out. Raises InputError."""
    parts = text.split(",")
    try:
        low, high = (_parse_number(part) if part.strip() else None for part in parts)
    except ValueError:
        raise InputError("--bounds", text, "two numbers, as 0,20") from None
    if any(one is not None and not math.isfinite(one) for one in (low, high)):
        raise InputError("--bounds", text, "two finite numbers, as 0,20")
    return low, high


def _parse_number(text: str) -> float:
    """Parse a number, or an expression such as deg(30). Raises ValueError."""
    try:
        return float(text)
    except ValueError:
        return float(NumberText.parse(text, {}))


def parse_both_bounds(text: str) -> tuple[float, float]:
    """Parse a range that is given as A,B, both of which are needed. Raises InputError."""
    low, high = parse_bounds(text)
    if low is None or high is None:
        raise InputError("--bounds", text, "two numbers, as 0,20: the range of the number")
    return low, high


def point_number(file: Path | None, point: int | None, option: str) -> int:
    """Number of a point of a file, by default the last; option: gives the file. Raises InputError
    for a number without a file."""
    if point is not None and file is None:
        raise InputError("--point", point, f"given with {option}, the file whose point it is")
    return LAST if point is None else point


def add_common_options(command: Callable[..., object]) -> Callable[..., object]:
    """Add the options that a command shares with others."""
    signature = inspect.signature(command, eval_str=True)
    asked = signature.parameters
    takes_scene = SCENE in asked and asked[SCENE].annotation is Scene
    draws = any(one.annotation == OutFolder for one in asked.values())
    added: dict[str, Any] = {QUIET: Quiet}
    added |= {SET: Changes} if takes_scene else {}
    if draws:
        added |= {NO_PICTURES: NoPictures, FORMAT: PictureFormat, WIDTH: PictureWidth}

    @wraps(command)
    def run_command(*args: Any, **given: Any) -> object:
        shared = {name: given.pop(name) for name in added}
        if takes_scene:
            given[SCENE] = read_scene(given[SCENE], shared[SET])
        as_json = bool(given.get(JSON))
        pictures = _picture_settings(shared, as_json) if draws else None
        with set_output(shared[QUIET], as_json, pictures), print_doubts():
            return command(*args, **given)

    parameters = [
        one.replace(annotation=SceneFile) if takes_scene and name == SCENE else one
        for name, one in asked.items()
    ]
    parameters += [
        Parameter(name, Parameter.KEYWORD_ONLY, default=DEFAULTS.get(name, False), annotation=kind)
        for name, kind in added.items()
    ]
    vars(run_command)["__signature__"] = signature.replace(parameters=parameters)
    run_command.__annotations__ = {one.name: one.annotation for one in parameters}
    return run_command


def _picture_settings(shared: Mapping[str, Any], as_json: bool) -> PictureSettings | None:
    """Return how pictures are written, None for none. Raises InputError for what is wrong, even
    where nothing is drawn."""
    form, text = shared[FORMAT], shared[WIDTH]
    width = None if text is None else parse_width(text)
    settings = PictureSettings(FORMATS[0] if form is None else form, width)
    asked = not as_json or form is not None or width is not None
    return settings if asked and not shared[NO_PICTURES] else None


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
