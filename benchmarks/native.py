"""The C of modules and of the yardstick, compiled for a loop in C."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import rodgen
from rodgen.judge.peers.native import Native, compiled
from rodgen.judge.surroundings import flags
from rodgen.loading import sources

HERE = Path(__file__).parent


def of_module(module: ModuleType) -> Native:
    """The right-hand side of a module of the C target, its C file compiled as it is there."""
    structure = rodgen.Structure(module.N, module.BOUNDARY, module.INERTIA, module.TERMS)
    texts = sources(structure, "c")
    source = next(name for name in texts if name.endswith(".c"))
    files = {source: texts[source]} | {name: texts[name] for name in texts if name.endswith(".h")}
    return compiled(files, f"{Path(source).stem}_rhs", flags().split())


def yardstick(links: int) -> Native:
    """The plain elimination for so many links, by the same flags."""
    file = HERE / "yardstick.c"
    own = [*flags().split(), f"-DN={links}"]
    return compiled({file.name: file.read_text()}, "yardstick_rhs", own)
