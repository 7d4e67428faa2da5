"""The application: rodgen's own commands, and those that installed packages add.

A package adds commands by entry points of the group `rodgen.commands`: a name, and a function that
is annotated for Typer.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from inspect import getmembers, isfunction
from pathlib import Path
from pkgutil import iter_modules

import typer

from rodgen.cli.exits import BAD_INPUT, fail
from rodgen.cli.options import add_common_options

GROUP = "rodgen.commands"
IN_CLONE = "`{}` in a clone of rodgen installs and runs it"
# Commands of packages that need not be installed, and how to get them.
ELSEWHERE = {
    "view": IN_CLONE.format("make view"),
    "report": IN_CLONE.format("make report"),
    "thesis": IN_CLONE.format("make report NAME=thesis"),
    "audit": IN_CLONE.format("make report NAME=audit"),
}
# The order of commands in the list; others follow by name.
ORDER = (
    *("scenes", "new", "derive", "run", "view", "animate", "check", "show", "modes", "static"),
    *("critical", "branch", "boundary", "exponents", "cycle", "cycle-branch", "nonlinear-mode"),
    *("linearise", "precision", "study"),
)


def own_commands(asked: str = "") -> dict[str, Callable[..., object]]:
    """Find the commands of rodgen: the public functions of the files *_command.py beside this, or
    of the one that is named after the command that is asked for."""
    files = [file.name for file in iter_modules([str(Path(__file__).parent)])]
    named = f"{asked.replace('-', '_')}_command"
    found: dict[str, Callable[..., object]] = {}
    for file in [named] if named in files else files:
        if file.endswith("_command"):
            module = import_module(f"rodgen.cli.{file}")
            for name, one in getmembers(module, isfunction):
                if one.__module__ == module.__name__ and not name.startswith("_"):
                    found[name.replace("_", "-")] = one
    return found


def make_app(asked: str = "") -> typer.Typer:
    """Make the application: rodgen's commands, those of installed packages, and for known ones that
    are not installed how to get them; no others than the one that is asked for, if it is known."""
    added = {entry.name: entry for entry in entry_points(group=GROUP)}
    missing = [name for name in ELSEWHERE if name not in added]
    app = typer.Typer(
        help="Derive, prove, generate and integrate the equations of motion of planar flexible "
        "rods.",
        epilog=f"Not installed: {', '.join(missing)}. Each says how to get it."
        if missing
        else None,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
    )
    alone = asked in ELSEWHERE and asked in added
    own = {} if alone else own_commands(asked)
    if alone or asked in own:
        added = {name: entry for name, entry in added.items() if name == asked}
    place = {name: number for number, name in enumerate(ORDER)}
    for name in sorted({*own, *added}, key=lambda name: (place.get(name, len(place)), name)):
        if name in own:  # a package cannot take the place of a command
            # A negative number is a value to refuse, not an option.
            _register(app, name, own[name], ignore_unknown_options=name == "derive")
        else:
            _add_from_package(app, added[name])
    for name in missing:
        why = f"{name} is not installed: {ELSEWHERE[name]}"
        _add_unavailable(app, name, why, hidden=True)
    app.callback(invoke_without_command=True)(_run_without_command)
    return app


def _add_from_package(app: typer.Typer, entry: EntryPoint) -> None:
    """Add a command of another package; one that cannot be loaded says so when it is called, and
    leaves the others alone."""
    try:
        command = entry.load()
    except Exception as error:  # whatever another package does when it is imported
        _add_unavailable(
            app, entry.name, f"{entry.name} cannot be loaded from {entry.value}: {error}"
        )
    else:
        _register(app, entry.name, command)


def _register(
    app: typer.Typer, name: str, command: Callable[..., object], **settings: bool
) -> None:
    """Register a command with the options that all share, and its first sentence as short help."""
    about = " ".join((command.__doc__ or "").split())
    sentence = re.match(r".*?\.(?= |$)|.*", about)
    app.command(name, short_help=sentence and sentence[0], context_settings=settings)(
        add_common_options(command)
    )


def _add_unavailable(app: typer.Typer, name: str, why: str, hidden: bool = False) -> None:
    def explain() -> None:
        fail(why, BAD_INPUT)

    anything = {"ignore_unknown_options": True, "allow_extra_args": True}
    app.command(name, hidden=hidden, context_settings=anything, add_help_option=False)(explain)


def _run_without_command(
    context: typer.Context,
    version: bool = typer.Option(False, "--version", help="Print the version and stop."),
) -> None:
    if version:
        import rodgen

        print(rodgen.__version__)
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help())
