"""The law of the springs: the moment of a joint, by its stiffness k and the angle d of its bend."""

from __future__ import annotations

import ast
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rodgen.errors import InputError
from rodgen.model.rod import SPRING
from rodgen.scene import grammar
from rodgen.scene.expression import Expression
from rodgen.scene.expression_text import Numbers

NAME, FIELD = SPRING.key, f"rod.{SPRING.key}"
BEND, STIFFNESS = "d", "k"
HOOKE = "k * d"
NEAR = 1e-6  # rad


@lru_cache(maxsize=64)
def parse_spring_law(text: str, numbers: Numbers) -> Expression:
    """Parse the spring law of a scene; numbers: those that it may name. Raises InputError."""
    found = Expression(text, BEND, FIELD, ((STIFFNESS, None), *numbers))
    known = dict(numbers)
    for name in found.names:
        value = known.get(name)
        if isinstance(value, float | int) and value < 0:
            allowed = f"at least 0 in {FIELD}: write a minus sign there"
            raise InputError(f"parameters.{name}", value, allowed)
    tree = grammar.parse(text, FIELD)
    assert tree is not None
    if list(grammar.find_tables(tree)):
        raise InputError(FIELD, text, "without tables: its energy is an integral over d")
    powers = (node for node in ast.walk(tree) if isinstance(node, ast.BinOp))
    for power in powers:
        if isinstance(power.op, ast.Pow) and not grammar.is_whole_number(power.right):
            allowed = "of whole exponents alone: for others it has sqrt, exp and log"
            raise InputError(FIELD, text, f"{allowed} (not {ast.unparse(power)})")
    if not np.isfinite(_moments_near_zero(found)).all():
        raise InputError(FIELD, text, "finite about d = 0")
    return found


def _moments_near_zero(law: Expression) -> NDArray[np.float64]:
    """Moments at and beside d = 0, over k."""
    known = {name: value for name, value in law.numbers if value is not None}
    values = law.with_values(known | {STIFFNESS: 1.0})
    return np.broadcast_to(values(np.array([-NEAR, 0.0, NEAR])), 3)


def has_no_tangent_stiffness(law: Expression) -> bool:
    """Whether a law has no tangent stiffness at d = 0."""
    below, _, above = _moments_near_zero(law)
    return bool((above - below) / (2 * NEAR) <= NEAR)


def is_hooke(text: str) -> bool:
    """Whether a law in canonical text is Hooke's, the default."""
    return text in (HOOKE, "d * k")


def refine(text: str, ratio: float) -> str:
    """Law of the same rod with `ratio` times as many links: of joints that a curvature bends by
    1/ratio of the angle, and whose k is ratio times as large."""
    grown = {BEND: f"({BEND}*{ratio!r})", STIFFNESS: f"({STIFFNESS}/{ratio!r})"}
    return grammar.replace_names(ast.parse(text.strip(), mode="eval").body, grown)
