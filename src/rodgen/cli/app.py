"""All commands together."""

from __future__ import annotations

import typer

from rodgen.cli import (
    animate,
    audit,
    check,
    critical,
    derive,
    modes,
    report,
    run,
    show,
    static,
    thesis,
    view,
)

app = typer.Typer(
    help="Equations of motion of planar flexible rods: derived, proven, generated, integrated.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
# A negative number is a value to refuse, not an option.
app.command(context_settings={"ignore_unknown_options": True})(derive.derive)
app.command()(run.run)
app.command()(view.view)
app.command()(animate.animate)
app.command()(check.check)
app.command()(show.show)
app.command()(modes.modes)
app.command()(static.static)
app.command()(critical.critical)
app.command()(audit.audit)
app.command()(thesis.thesis)
app.command()(report.report)


@app.callback(invoke_without_command=True)
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
