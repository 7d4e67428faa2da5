"""The methods of integration, one a file: whatever lies in this folder is known everywhere."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from pkgutil import iter_modules

from rodgen.model.method import Method


def _load_methods() -> dict[str, Method]:
    names = [module.name for module in iter_modules(__path__)]
    found = {n: replace(import_module(f"{__name__}.{n}").METHOD, name=n) for n in names}
    return dict(sorted(found.items(), key=lambda pair: (pair[1].place, pair[0])))


METHODS = _load_methods()
FIXED_STEP = tuple(name for name, method in METHODS.items() if method.steps == "fixed")
ADAPTIVE = tuple(name for name, method in METHODS.items() if method.steps != "fixed")
# Adaptive methods that take equal steps where a step is given.
EITHER = tuple(name for name, method in METHODS.items() if method.steps == "either")
TABLEAUX = {name: method.tableau for name, method in METHODS.items() if method.tableau}
COLLOCATION = {name: method.collocation for name, method in METHODS.items() if method.collocation}
# What steps in C, by its number there.
COMPILED = (
    *(name for name, method in METHODS.items() if method.in_c),
    *(f"{name}_equal_steps" for name in EITHER if METHODS[name].in_c),
)
