"""The law of the springs: the moment of a joint, by its stiffness k and the angle d of its bend."""

from __future__ import annotations

import ast
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError
from rodgen.model.rod import SPRING
from rodgen.scene import grammar
from rodgen.scene.expression import Expression, Numbers

NAME, FIELD = SPRING.key, f"rod.{SPRING.key}"
BEND, STIFFNESS = "d", "k"
HOOKE = "k * d"
NEAR = 1e-6  # rad


@lru_cache(maxsize=64)
def law(text: str, numbers: Numbers) -> Expression:
    """The law that a scene gives, in the numbers that it has by name. Raises InputError for what is
    no such law."""
    found = Expression(text, BEND, FIELD, ((STIFFNESS, None), *numbers))
    known = dict(numbers)
    for name in found.names:
        value = known.get(name)
        if isinstance(value, float | int) and value < 0:
            allowed = f"at least 0 in {FIELD}: write a minus sign there"
            raise InputError(f"parameters.{name}", value, allowed)
    tree = grammar.parse(text, FIELD)
    assert tree is not None
    if list(grammar.tables(tree)):
        raise InputError(FIELD, text, "without tables: its energy is an integral over d")
    powers = (node for node in ast.walk(tree) if isinstance(node, ast.BinOp))
    for power in powers:
        if isinstance(power.op, ast.Pow) and not grammar.is_whole(power.right):
            allowed = "of whole exponents alone: for others it has sqrt, exp and log"
            raise InputError(FIELD, text, f"{allowed} (not {ast.unparse(power)})")
    if not np.isfinite(_near(found)).all():
        raise InputError(FIELD, text, "finite about d = 0")
    return found


def _near(law: Expression) -> NDArray[np.float64]:
    """Moments about d = 0, over k."""
    known = {name: value for name, value in law.numbers if value is not None}
    values = law.with_values(known | {STIFFNESS: 1.0})
    return np.broadcast_to(values(np.array([-NEAR, 0.0, NEAR])), 3)


def is_slack(law: Expression) -> bool:
    """Whether the moment does not grow with the angle where there is none."""
    below, _, above = _near(law)
    return bool((above - below) / (2 * NEAR) <= NEAR)


def is_hooke(text: str) -> bool:
    """Whether a law in canonical text is the one that a rod has that names none."""
    return text in (HOOKE, "d * k")


def remeshed(text: str, ratio: float) -> str:
    """The law of the same rod with so many times the links: of the joint that a curvature bends by
    1/ratio of the angle and whose k is ratio times as large."""
    grown = {BEND: f"({BEND}*{ratio!r})", STIFFNESS: f"({STIFFNESS}/{ratio!r})"}

    class Renamed(ast.NodeTransformer):
        def visit_Name(self, node: ast.Name) -> ast.expr:
            return ast.parse(grown.get(node.id, node.id), mode="eval").body

    return ast.unparse(Renamed().visit(ast.parse(text.strip(), mode="eval")))
