"""The C target: C99 with a header, and a Python module that builds it."""

from __future__ import annotations

from typing import Any

from rodgen.emit.targets import Target


def _programs(*args: Any) -> Any:
    from rodgen.emit.c.c_functions import programs  # SymPy is imported only where it is needed

    return programs(*args)


TARGET = Target(
    templates={
        "chain": {"py": "c/module.py.jinja", "c": "c/module.c.jinja", "h": "c/module.h.jinja"}
    },
    parts=("rhs", "batch", "jac", "tangents", "flow", "newton", "lanes"),
    programs=_programs,
    compiled=True,
)
