"""rodgen show: what a scene's module will hold, and what it leaves out."""

from __future__ import annotations

from rodgen.cli.console import print_result, show_work
from rodgen.cli.options import AsJson
from rodgen.scene import Scene


def show(scene: Scene, as_json: AsJson = False) -> None:
    """Show what the module of SCENE will hold, and what is left out and why."""
    from rodgen.analyse.description import describe

    with show_work("generating"):
        found = describe(scene)
    print_result(scene.name, found, as_json)
