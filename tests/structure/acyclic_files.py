"""Contract of import-linter: no circle of imports among files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from typing import Any

import grimp
from importlinter import Contract, ContractCheck, output


def circles(imports: Mapping[str, Set[str]]) -> Iterator[list[str]]:
    """Circles of imports, in order: one at least of each knot. imports: modules by module."""
    left = dict(imports)
    while left:
        # What imports nothing that is left is in no circle.
        fewer = {module: found for module, of in left.items() if (found := of & left.keys())}
        if fewer != left:
            left = fewer
            continue
        way = [min(left)]
        while (after := min(left[way[-1]])) not in way:
            way.append(after)
        circle = way[way.index(after) :]
        yield circle
        left = {module: of for module, of in left.items() if module not in circle}


class AcyclicFiles(Contract):
    """No circle of files, imports for types and inside functions included; folders may have one."""

    type_name = "acyclic_files"

    def check(self, graph: grimp.ImportGraph, verbose: bool) -> ContractCheck:
        """Look for circles in a graph of files."""
        files = {one: graph.find_modules_directly_imported_by(one) for one in graph.modules}
        found = list(circles(files))
        return ContractCheck(kept=not found, metadata={"circles": found})

    def render_broken_contract(self, check: Any) -> None:
        """Print the circles that were found."""
        for circle in check.metadata["circles"]:
            output.print_error(" -> ".join([*circle, circle[0]]))
