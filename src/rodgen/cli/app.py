"""All commands together: rodgen's own, and those that installed packages add.

A package adds commands by entry points of the group `rodgen.commands`: a name, and a function that
is annotated for Typer.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points

import typer

from rodgen.cli import (
    animate,
    boundary,
    branch,
    check,
    critical,
    cycle,
    cycle_branch,
    derive,
    exponents,
    modes,
    nonlinear_mode,
    precision,
    run,
    scenes,
    show,
    static,
    study,
    view,
)
from rodgen.cli.errors import BAD_INPUT, fail
from rodgen.cli.shared import with_shared

GROUP = "rodgen.commands"
EVIDENCE = ("report", "thesis", "audit")  # what evidence/ adds, where it is installed
OWN: dict[str, Callable[..., object]] = {
    "scenes": scenes.scenes,
    "new": scenes.new,
    "derive": derive.derive,
    "run": run.run,
    "view": view.view,
    "animate": animate.animate,
    "check": check.check,
    "show": show.show,
    "modes": modes.modes,
    "static": static.static,
    "critical": critical.critical,
    "branch": branch.branch,
    "boundary": boundary.boundary,
    "exponents": exponents.exponents,
    "cycle": cycle.cycle,
    "cycle-branch": cycle_branch.cycle_branch,
    "nonlinear-mode": nonlinear_mode.nonlinear_mode,
    "precision": precision.precision,
    "study": study.study,
}
HOW = "`make report [NAME=thesis|audit]` in a clone of rodgen installs and runs them"


def commands() -> typer.Typer:
    """All commands: rodgen's, those of installed packages, and for those of evidence/ that are not
    installed how to get them."""
    added = {entry.name: entry for entry in entry_points(group=GROUP)}
    missing = [name for name in EVIDENCE if name not in added]
    app = typer.Typer(
        help="Derive, prove, generate and integrate the equations of motion of planar flexible "
        "rods.",
        epilog=f"Not installed: {', '.join(missing)} ({HOW})." if missing else None,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
    )
    for name, command in OWN.items():
        # A negative number is a value to refuse, not an option.
        _make_known(app, name, command, ignore_unknown_options=name == "derive")
    for name, entry in sorted(added.items()):
        if name not in OWN:  # a package cannot take the place of a command
            _add(app, entry)
    for name in missing:
        _refuse(app, name, f"{name} is not installed: {HOW}", hidden=True)
    app.callback(invoke_without_command=True)(_alone)
    return app


def _add(app: typer.Typer, entry: EntryPoint) -> None:
    """A command of another package; one that cannot be loaded says so when it is called, and leaves
    the others alone."""
    try:
        command = entry.load()
    except Exception as error:  # whatever another package does when it is imported
        _refuse(app, entry.name, f"{entry.name} cannot be loaded from {entry.value}: {error}")
    else:
        _make_known(app, entry.name, command)


def _make_known(
    app: typer.Typer, name: str, command: Callable[..., object], **settings: bool
) -> None:
    """A command with the options that all share, and its first sentence whole in the list."""
    about = " ".join((command.__doc__ or "").split())
    sentence = re.match(r".*?\.(?= |$)|.*", about)
    app.command(name, short_help=sentence and sentence[0], context_settings=settings)(
        with_shared(command)
    )


def _refuse(app: typer.Typer, name: str, why: str, hidden: bool = False) -> None:
    def tell() -> None:
        fail(why, BAD_INPUT)

    anything = {"ignore_unknown_options": True, "allow_extra_args": True}
    app.command(name, hidden=hidden, context_settings=anything, add_help_option=False)(tell)


def _alone(
    context: typer.Context,
    version: bool = typer.Option(False, "--version", help="Print the version and stop."),
) -> None:
    if version:
        import rodgen

        print(rodgen.__version__)
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help())


app = commands()
