"""Numbers and tables of a scene that no expression names."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from rodgen.scene import grammar
from rodgen.scene.grammar import TABLE
from rodgen.scene.keys import NUMBERS, expression_texts, numbers_in_use
from rodgen.scene.scene_files import TABLES


def find_unused_names(
    given: dict[str, Any], numbers: Collection[str], tables: Collection[str]
) -> Iterator[str]:
    """Yield a sentence on each number and table that no expression in the tables of a scene
    names."""
    named = numbers_in_use(given)
    for name in numbers:
        if name not in named:
            yield f"no expression names {NUMBERS}.{name}"
    trees = [
        grammar.parse(text, "") for text in expression_texts(given) if tables and TABLE in text
    ]
    read = {name for tree in trees if tree for name in grammar.table_names(tree)}
    for name in tables:
        if repr(name) not in read:
            yield f"no expression names {TABLES}.{name}"
