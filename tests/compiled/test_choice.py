"""The rule of `auto`, from the eigenvalue that it looks at, and on scenes."""

from __future__ import annotations

import numpy as np
import pytest

import rodgen
from rodgen import Scene
from rodgen.integrate.methods.choose import by_rule, warn_of_tolerance
from rodgen.integrate.stability import Dominant


def _dominant(value: complex, partner: complex | None = None) -> Dominant:
    other = value.conjugate() if partner is None else partner
    return Dominant(value, other, np.ones(1, dtype=complex), 1, True)


@pytest.mark.parametrize(
    ("value", "partner", "span", "rtol", "method"),
    [
        (2000j, None, 1.0, 1e-8, "dop853"),  # few radians
        (2000j, None, 100.0, 1e-8, "dop853"),  # to be followed
        (2000j, None, 100.0, 1e-3, "gauss"),  # noise
        (2000j, None, 1e6, 1e-8, "gauss"),  # more steps than there may be
        (-1500 + 1300j, None, 100.0, 1e-8, "radau"),  # dies out
        (-1e6 + 0j, -1.0 + 0j, 1.0, 1e-8, "radau"),
        (-2000 + 0j, 2000 + 0j, 100.0, 1e-8, "dop853"),  # one of the pair grows
    ],
)
def test_rule(
    value: complex, partner: complex | None, span: float, rtol: float, method: str
) -> None:
    choice = by_rule(_dominant(value, partner), span, rtol)
    assert choice.method == method
    assert "radians in the span" in choice.reason


@pytest.mark.nightly
def test_choice_is_that_of_the_run_and_not_far_from_the_best(missile: Scene) -> None:
    """What auto takes costs at most a few times as many evaluations as the cheapest method that
    is as exact, in a scene of either kind."""
    table = missile.model_dump(exclude_none=True)
    table["integrate"] = {"span": [0.0, 10.0], "rtol": 1e-6}
    stiff = {**table, "loads": {"internal_damping": {"coefficient": 20.0}}}
    stiff["rod"] = {**table["rod"], "links": 10}
    stiff["initial"] = {"phi": "0.1*cos(pi*s)"}
    for scene, expected in ((Scene.from_dict(table), "dop853"), (Scene.from_dict(stiff), "radau")):
        model = rodgen.build(scene, "c")
        choice = rodgen.choose(scene, model)
        assert choice.method == expected, choice
        sol = rodgen.simulate(scene, model=model)
        assert sol.scene.integrate.method == expected
        costs = {}
        for method in ("dop853", "radau"):
            costs[method] = rodgen.simulate(scene, model=model, method=method).stats.rhs
        assert costs[expected] < 3 * min(costs.values())


@pytest.mark.parametrize(
    ("method", "rtol", "damping", "words"),
    [
        ("dop853", 1e-2, 20.0, "leave noise in its rates; take radau"),
        ("dop853", 1e-6, 20.0, ""),
        ("dop853", 1e-2, 1e-3, ""),  # nothing dies out
        ("radau", 1e-2, 20.0, ""),
        ("gauss", 2.3e-14, 1e-3, "rounding errors that are larger"),
        ("dop853", 2.3e-14, 1e-3, ""),
    ],
)
def test_tolerances_that_are_not_kept_are_warned_of(
    missile: Scene, method: str, rtol: float, damping: float, words: str
) -> None:
    """A rod with or without strong damping inside, over a thousand radians and more."""
    table = missile.model_dump(exclude_none=True)
    table["loads"] = {"internal_damping": {"coefficient": damping}}
    table["rod"]["links"] = 10
    table["integrate"] = {"method": method, "rtol": rtol, "span": [0.0, 10.0]}
    scene = Scene.from_dict(table)
    text = warn_of_tolerance(scene, rodgen.build(scene, "c")) or ""
    assert words in text
    assert bool(words) == bool(text)
