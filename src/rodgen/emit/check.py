"""A generated module against the hand-assembled form in 50-digit arithmetic.

The closed form is assembled entry by entry and solved by mpmath, so nothing is shared with the
module but its parameters and states.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
from mpmath import mpf

from rodgen.emit.by_hand import ByHand
from rodgen.scene.expression import Expression

DIGITS = 50
LIMIT = 1e-10  # relative; about a thousand times what n = 50 reaches


@dataclass(frozen=True)
class Deviation:
    """Largest relative error of one quantity over the states of one kind."""

    quantity: str
    states: str
    error: float


def check_module(module: ModuleType, states: int = 3, seed: int = 1) -> Iterator[Deviation]:
    """Compare all that a module computes at random states near to and far from straight.

    The error of a vector is its largest absolute error over its largest magnitude; that of
    energies or powers is taken relative to the largest among them.
    """
    draw = np.random.default_rng(seed)
    for kind, spread, speed in (("near straight", 1e-3, 1e-2), ("far from straight", 3.0, 3.0)):
        worst: dict[str, float] = {}
        for _ in range(states):
            values = _parameters(module, draw)
            y = _state(module, draw, spread, speed)
            t = float(draw.uniform(0.0, 1.0))
            for quantity, error in _compare(module, values, t, y):
                worst[quantity] = max(worst.get(quantity, 0.0), error)
        for quantity, error in worst.items():
            yield Deviation(quantity, kind, error)


def _parameters(module: ModuleType, draw: np.random.Generator) -> dict[str, Any]:
    names = [name for name in module.PARAMETERS if not name.startswith("fin_factor")]
    values: dict[str, Any] = {name: float(draw.uniform(0.5, 5.0)) for name in names}
    values["bending_stiffness"] *= 20.0
    if "external_damping" in module.TERMS:
        values["fin_factor"] = draw.uniform(0.5, 5.0, module.N + 1)
    return values


def _state(
    module: ModuleType, draw: np.random.Generator, spread: float, speed: float
) -> np.ndarray:
    half = len(module.STATE) // 2
    angle = draw.uniform(-3, 3)
    y = np.empty(2 * half)
    y[:half] = angle + spread * draw.standard_normal(half)
    y[half:] = speed * draw.standard_normal(half)
    return y


def _compare(
    module: ModuleType, values: dict[str, Any], t: float, y: np.ndarray
) -> Iterator[tuple[str, float]]:
    """Every quantity of a module at one state, with its relative error."""
    timed = {
        name: float(Expression(text, "t")(t))
        for name, text in getattr(module, "EXPRESSIONS", {}).items()
    }
    p = module.parameters(**values)
    with mpmath.workdps(DIGITS):
        exact = ByHand(module, values | timed, y)
        yield "rhs", _vector_error(module.rhs(t, y, p), exact.rhs())
        mass = [entry for row in exact.closed.M() for entry in row]
        yield "mass matrix", _vector_error(module.mass_matrix(y, p).ravel(), mass)
        yield "energy", _vector_error(module.energy(y, p), exact.energy())
        if hasattr(module, "power"):
            power, by_hand = module.power(t, y, p), exact.power()
            yield "power", _vector_error([power[x] for x in power], [by_hand[x] for x in power])
        joints = [c for joint in exact.joints() for c in joint]
        yield "joints", _vector_error(module.joints(y, p).ravel(), joints)
        centre = exact.centre_of_gravity()
        yield "centre of gravity", _vector_error(module.centre_of_gravity(y, p), centre)
        yield "inertia", _vector_error(module.inertia(y, p), exact.inertia())
        yield "bending moments", _vector_error(module.bending_moments(y, p), exact.moments())
        acting = exact.forces()
        if acting:
            forces, order = module.forces(t, y, p), sorted(acting)
            got = np.concatenate([forces[term].ravel() for term in order])
            yield "forces", _vector_error(got, [c for x in order for f in acting[x] for c in f])
        errors = []
        for link, share in ((0, 0.25), (module.N // 2, 0.0), (module.N - 1, 1.0)):
            force = values["mass"], -values["length"]  # any two numbers
            got = module.generalised_force(y, p, link, share, force)
            errors.append(_vector_error(got, exact.point_force(link, share, force)))
        yield "generalised force", max(errors)


def _vector_error(got: Sequence[Any] | np.ndarray, exact: Sequence[Any]) -> float:
    largest = max(abs(e) for e in exact)
    if not all(np.isfinite(float(g)) for g in got):
        return float("inf")
    off = max(abs(mpf(float(g)) - e) for g, e in zip(got, exact, strict=True))
    return float(off / largest) if largest else float(off)
