"""The NumPy target: a Python module that needs NumPy and SciPy."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

from rodgen.emit.targets import Target

if TYPE_CHECKING:
    from rodgen.emit.outputs import Functions
    from rodgen.emit.statements import Program


def _programs(
    functions: Functions, form: str, parts: Collection[str]
) -> tuple[dict[str, Program], dict[str, Any]]:
    made = {}
    if "rhs" in parts:
        made["rhs"] = functions.dense() if form == "dense" else functions.chain()
    if "jac" in parts:
        made["jac"] = functions.jac()
    if "inputs" in parts:
        made |= {"inputs": functions.inputs(), **functions.measure_slopes()}
    return made, {}


TARGET = Target(
    templates={"chain": {"py": "numpy/chain.py.jinja"}, "dense": {"py": "numpy/dense.py.jinja"}},
    parts=("rhs", "jac", "inputs", "tangents"),
    programs=_programs,
)
