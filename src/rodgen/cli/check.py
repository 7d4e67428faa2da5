"""rodgen check: a generated module against the hand-assembled form."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rodgen.cli.console import out, print_json, print_table, working
from rodgen.cli.errors import DISPROVEN, fail
from rodgen.cli.options import AsJson
from rodgen.cli.results import is_generated
from rodgen.errors import InputError
from rodgen.loading import load_module


def check(
    module_file: Annotated[Path, typer.Argument(metavar="MODULE", help="A generated module.")],
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random states.")] = 1,
    as_json: AsJson = False,
) -> None:
    """Run MODULE and compare it with hand-assembled equations in 50-digit arithmetic."""
    from rodgen.check.module import DIGITS, LIMIT, check_module
    from rodgen.show.result_tables import ResultTable

    if not module_file.exists():
        raise InputError("module", str(module_file), "a file that is there")
    if module_file.suffix != ".py" or not is_generated(module_file):  # nothing else is run
        allowed = "a .py that rodgen derive wrote (of a C module, the .py beside the .c)"
        raise InputError("module", str(module_file), allowed)
    module = load_module(module_file)
    deviations = []
    with working(f"comparing {module_file.name}") as step:
        for deviation in check_module(module, seed=seed):
            deviations.append(deviation)
            step(f"{deviation.quantity}, {deviation.states}")
    worst = max(d.error for d in deviations)
    if as_json:
        rows = [{"quantity": d.quantity, "states": d.states, "error": d.error} for d in deviations]
        print_json({"deviations": rows, "largest": worst, "allowed": LIMIT})
    else:
        table = ResultTable.of_rows(
            ("quantity", "states", "largest relative error"),
            ((d.quantity, d.states, f"{d.error:.2e}") for d in deviations),
        )
        print_table(f"{module_file.name} against {DIGITS}-digit arithmetic", table)
    if not worst <= LIMIT:
        fail(f"largest relative error {worst:.2e} is above {LIMIT:g}", DISPROVEN)
    if not as_json:
        out.print(f"largest relative error {worst:.2e}, allowed {LIMIT:g}")
