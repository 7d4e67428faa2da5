"""The loads and kinds of damping that a rod may have: a file each, named as the term is.

A file holds one object, LOAD, of a kind (kinds.py): its law and, where the thesis has one, its
closed form. What a load is called, and its parameters, is a row of the vocabulary. Nothing else in
derive/ names a load.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module

from rodgen.model.term import BASE
from rodgen.model.terms import TERMS as ROWS
from rodgen.model.terms import load_places

from ..link_properties import Rod
from .kinds import Load

# By term, in the order in which names list them.
LOADS: dict[str, Load] = {term: import_module(f".{term}", __name__).LOAD for term in ROWS}
# Those that need no keys to be something.
TERMS = tuple(term for term in LOADS if ROWS[term].kind != BASE)


def loads_of(terms: Sequence[str], rod: Rod) -> dict[str, Load]:
    """The loads of a structure, by name, on its rod."""
    found = {}
    for text, (name, place) in zip(terms, load_places(terms).items(), strict=True):
        load = LOADS[text.partition("@")[0]]
        load = load.at_place(name, place) if "@" in text or name != text else load
        found[name] = load.on(rod)
    return found
