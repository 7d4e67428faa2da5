"""A recorded run as a page without a server: a folder, by the JavaScript of the live view."""

from __future__ import annotations

import base64
import itertools
import json
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from rodgen.errors import InputError
from rodgen.integrate.solution import Solution
from rodgen.scene import Scene
from rodgen_live.page.elements import FIRST, ICONS, LIBRARY, LOOK, STATIC, style_sheet
from rodgen_live.page.plots import first_plots
from rodgen_live.page.rod_view import first_view, scene_props
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.replay import Replay, replay

GENERATOR = "rodgen view --export"
PAGE, RUN, PLOTTER = "index.html", "run.js", "uPlot.iife.min.js"
FILES = {PAGE, RUN, ICONS.name, PLOTTER}
VUE = "vue.esm-browser.prod.js"
ICON = (
    "@font-face { font-family: 'Material Icons'; src: url(%s); }\n"
    ".material-icons { font: normal 20px 'Material Icons'; display: inline-block; }\n"
    ".rodgen-buttons .material-icons { line-height: 1; vertical-align: middle; }"
)
BESIDE = re.compile(r'from "\./')  # another of our modules
MOMENTS = "bending_moment"


def export(solution: Solution, folder: Path) -> None:
    """Write a run as a page, with rod, time line and plots: index.html opens from the file system.
    Raises InputError for a folder that holds anything else than such a page, and for a run that
    cannot be shown."""
    check_folder(folder)
    catalogue = Catalogue(solution.system, solution.model)
    profiles = [{"kind": "profile", "y": [MOMENTS]}] if MOMENTS in catalogue.along else []
    recorded = replay(solution, [*first_plots(catalogue), *profiles])
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}-") as made:
            _write(Path(made), solution.scene, recorded)
            folder.mkdir(exist_ok=True)
            for name in FILES:
                shutil.move(Path(made, name), folder / name)
    except OSError as error:
        raise _refusal(folder, f"a folder to write into ({error.strerror or error})") from None


def check_folder(folder: Path) -> None:
    """Refuse a folder with files that `export` has not written. Raises InputError."""
    if not folder.exists():
        return
    if not folder.is_dir():
        raise _refusal(folder, "a folder")
    found = {path.name for path in folder.iterdir()}
    own = PAGE in found and GENERATOR in (folder / PAGE).read_text("utf-8", errors="replace")
    if found and not (own and found <= FILES):
        raise _refusal(folder, "a new folder, an empty one, or one that --export has written")


def _refusal(folder: Path, allowed: str) -> InputError:
    return InputError("--export", str(folder), allowed)


def _write(folder: Path, scene: Scene, recorded: Replay) -> None:
    shutil.copyfile(ICONS, folder / ICONS.name)
    shutil.copyfile(STATIC / "vendor" / PLOTTER, folder / PLOTTER)
    (folder / RUN).write_text(f"window.rodgenRun = {_run_json(scene, recorded)};\n", "utf-8")
    template = Environment(
        loader=FileSystemLoader(STATIC), autoescape=True, undefined=StrictUndefined
    ).get_template("replay.html")
    styles = [style_sheet(), ICON % ICONS.name]
    modules = json.dumps({"imports": dict(_module_addresses())})
    text = template.render(title=scene.name, generator=GENERATOR, styles=styles, modules=modules)
    (folder / PAGE).write_text(text, "utf-8")


def _run_json(scene: Scene, recorded: Replay) -> str:
    """Run as JSON for the page: title, rod, plots, times, and the messages in base64."""
    messages = [recorded.first, *recorded.frames]
    ends = list(itertools.accumulate(map(len, messages), initial=0))
    data = base64.b64encode(b"".join(messages)).decode()
    run: dict[str, Any] = {
        "title": scene.name,
        "rod": FIRST | scene_props(scene) | {"view": first_view(scene), "tool": LOOK, "rod": 1},
        "plots": recorded.plots,
        "times": recorded.times,
        "ends": ends,
        "data": data,
    }
    return json.dumps(run, allow_nan=False)


def _module_addresses() -> Iterator[tuple[str, str]]:
    """JavaScript modules by the names that they are imported by, each as a data address: a page
    from the file system cannot load modules from files."""
    yield "vue", _data_address((LIBRARY / VUE).read_text("utf-8"))
    for path in sorted(STATIC.glob("*.js")):
        text = BESIDE.sub('from "rodgen-live/', path.read_text("utf-8"))
        yield f"rodgen-live/{path.name}", _data_address(text)


def _data_address(text: str) -> str:
    return "data:text/javascript;base64," + base64.b64encode(text.encode()).decode()
