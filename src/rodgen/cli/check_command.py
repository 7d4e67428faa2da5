"""rodgen check: a generated module against the hand-assembled form."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import print_result, show_work
from rodgen.cli.exits import DISPROVEN, fail
from rodgen.cli.options import AsJson
from rodgen.cli.result_folders import is_generated
from rodgen.errors import InputError
from rodgen.loading import load_module


def check(
    module_file: Annotated[Path, typer.Argument(metavar="MODULE", help="A generated module.")],
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random states.")] = 1,
    as_json: AsJson = False,
) -> None:
    """Run MODULE and compare it with hand-assembled equations in 50-digit arithmetic."""
    from rodgen.check.module_check import LIMIT, check_module

    if not module_file.exists():
        raise InputError("module", str(module_file), "a file that is there")
    if module_file.suffix != ".py" or not is_generated(module_file):  # nothing else is run
        allowed = "a .py that rodgen derive wrote (of a C module, the .py beside the .c)"
        raise InputError("module", str(module_file), allowed)
    module = load_module(module_file)
    with show_work(f"comparing {module_file.name}"):
        found = check_module(module, seed=seed)
    print_result(f"{module_file.name} against hand-assembled equations", found, as_json)
    if not found.equal:
        fail(f"largest relative error {found.largest:.2e} is above {LIMIT:g}", DISPROVEN)
