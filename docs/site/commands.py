"""The page of the command line, from rodgen's commands themselves."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import typer

from rodgen.cli.app import make_app

if TYPE_CHECKING:
    from sphinx.application import Sphinx

PAGE, MARK = "reference/command-line", "<!-- commands -->"


def _escaped(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def _row(parameter: Any, context: Any) -> str:
    """The row of an argument or an option, in a table."""
    name, text = parameter.get_help_record(context) or (parameter.make_metavar(context), "")
    return f"| `{_escaped(name).replace('&lt;', '<')}` | {_escaped(text)} |"


def _page(command: Any, name: str) -> Iterator[str]:
    context = command.make_context(name, [], resilient_parsing=True)
    yield f"## {name}\n"
    usage = command.get_usage(context).removeprefix("Usage: ")
    yield f"    {usage.replace('{', '').replace('}', '')}\n"
    yield f"{inspect.cleandoc(command.help or '')}\n"
    yield from ("| argument or option | what it is |", "|---|---|")
    yield from (_row(one, context) for one in command.get_params(context))
    yield ""


def _overview(commands: dict[str, Any]) -> Iterator[str]:
    """A table of the commands, each with the first line of its help."""
    yield from ("| command | what it does |", "|---|---|")
    for name, command in commands.items():
        summary = inspect.cleandoc(command.help or "").split("\n\n")[0]
        yield f"| [`rodgen {name}`](#rodgen-{name}) | {_escaped(summary)} |"
    yield ""


def _fill(_: Sphinx, page: str, source: list[str]) -> None:
    """Write all commands where the page has its mark."""
    if page == PAGE:
        group = typer.main.get_command(make_app())
        commands = vars(group)["commands"]
        pages = (line for one in commands for line in _page(commands[one], f"rodgen {one}"))
        source[0] = source[0].replace(MARK, "\n".join([*_overview(commands), *pages]))


def setup(site: Sphinx) -> dict[str, bool]:
    site.connect("source-read", _fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
