"""Expressions of quantities, and their derivatives by time, as somebody types them for a plot."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np

from rodgen.integrate.stepper import Array
from rodgen.live.samples import Chunk
from rodgen.scene import SceneError
from rodgen.scene.expression import Expression

LONGEST = 200  # letters
TURN = 1e-5  # rad or m by which the state moves in a difference: errors are its square
RATE = re.compile(r"d\s*/\s*dt\s*(\(.*\)|\w+)", re.DOTALL)
# What does not follow from the state alone: its rate is not told by where the state goes.
PATHS = re.compile(r"work_\w+|energy_balance|total_work")

Columns = Callable[[Sequence[str], Chunk], Array]  # of quantities at samples, (K, names)


@dataclass(frozen=True)
class OwnQuantity:
    """An expression; rate: it is the derivative of that by time which is meant."""

    expression: Expression
    rate: bool

    @classmethod
    def of(cls, text: str, known: Container[str], field: str) -> OwnQuantity:
        """From a text in the grammar of scenes, over quantities, t and numbers; d/dt before
        brackets or a name that hold all of the rest. Raises SceneError."""
        if len(text) > LONGEST:
            raise SceneError(field, text, f"at most {LONGEST} letters")
        found = RATE.fullmatch(text.strip())
        inner = found[1] if found else text
        names = tuple(dict.fromkeys(re.findall(r"[^\W\d]\w*", inner)))
        here = tuple(name for name in names if name in known and name != "t")
        expression = Expression(inner.strip(), "t", field, states=here)
        if expression.sensors:
            raise SceneError(field, text, "without sensors: quantities have names, such as phi_0")
        if found and (paths := [name for name in here if PATHS.fullmatch(name)]):
            what = f"without {paths[0]} under d/dt: the rate of work is a power"
            raise SceneError(field, text, what)
        return cls(expression, bool(found))

    def values(self, model: ModuleType, columns: Columns, chunk: Chunk) -> Array:
        """Its values at the samples of a chunk, (K,)."""
        if not self.rate:
            return self._at(columns, chunk)
        rates = np.array([model.rhs(t, y, chunk.p) for t, y in zip(chunk.t, chunk.y, strict=True)])
        fastest = np.abs(rates.reshape(len(chunk), -1)).max(axis=1, initial=0.0)
        h = TURN / np.maximum(fastest, 1.0)
        sides = [
            replace(chunk, t=chunk.t + step, y=chunk.y + step[:, None] * rates) for step in (h, -h)
        ]
        up, down = (self._at(columns, side) for side in sides)
        found: Array = (up - down) / (2 * h)
        return found

    def _at(self, columns: Columns, chunk: Chunk) -> Array:
        names = self.expression.signals
        values = columns(names, chunk) if names else np.empty((len(chunk), 0))
        given = dict(zip(names, values.T, strict=True))
        found = self.expression.value(chunk.t, given)
        return np.array(np.broadcast_to(found, chunk.t.shape), dtype=float)
