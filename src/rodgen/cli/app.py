"""All commands together: rodgen's own, and those that installed packages add.

A package adds commands by entry points of the group `rodgen.commands`: a name, and a function that
is annotated for Typer.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points

import typer

from rodgen.cli import (
    animate,
    check,
    critical,
    cycle,
    derive,
    exponents,
    modes,
    precision,
    run,
    show,
    static,
    study,
    view,
)
from rodgen.cli.errors import BAD_INPUT, fail

GROUP = "rodgen.commands"
EVIDENCE = ("report", "thesis", "audit")  # what evidence/ adds, where it is installed
OWN: dict[str, Callable[..., object]] = {
    "derive": derive.derive,
    "run": run.run,
    "view": view.view,
    "animate": animate.animate,
    "check": check.check,
    "show": show.show,
    "modes": modes.modes,
    "static": static.static,
    "critical": critical.critical,
    "exponents": exponents.exponents,
