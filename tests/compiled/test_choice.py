"""The rule of `auto`, from the eigenvalue that it looks at, and on scenes."""

from __future__ import annotations

import numpy as np

import rodgen
from rodgen import Scene
from rodgen.integrate.methods.method_choice import choose_by_rule, tolerance_doubt
from rodgen.integrate.stability import Dominant
from rodgen.system import System
from tests.compiled.conftest import NO_LOADS


def _damped(missile: Scene, coefficient: float, **integrate: object) -> Scene:
    """A rod with damping inside alone, over ten thousand radians and more."""
    alone = {"loads.gravity.g": 0.0, "rod.bending_stiffness": 100.0}
    damping = {"loads.internal_damping.coefficient": coefficient}
    given = {"initial": {"phi": "0.1*cos(pi*s)"}, "integrate": {"span": [0.0, 2000.0], **integrate}}
    return missile.replace({**NO_LOADS, **alone, **damping, **given})


def _dominant(value: complex, partner: complex | None = None) -> Dominant:
    other = value.conjugate() if partner is None else partner
    return Dominant(value, other, np.ones(1, dtype=complex), 1, True)


def test_rule() -> None:
    for value, partner, span, rtol, method in (
        (2000j, None, 1.0, 1e-8, "dop853"),  # few radians
        (2000j, None, 100.0, 1e-8, "dop853"),  # to be followed
        (2000j, None, 100.0, 1e-3, "dop853"),
        (2000j, None, 1e4, 1e-3, "gauss"),  # rates are not worth the time
        (2000j, None, 1e6, 1e-8, "gauss"),  # more steps than there may be
        (-1500 + 1300j, None, 100.0, 1e-8, "radau"),  # dies out
        (-200 + 1990j, None, 100.0, 1e-8, "dop853"),
        (-200 + 1990j, None, 1e3, 1e-8, "radau"),  # is gone long before the end
        (-1e6 + 0j, -1.0 + 0j, 1.0, 1e-8, "radau"),
        (-2000 + 0j, 2000 + 0j, 100.0, 1e-8, "dop853"),  # one of the pair grows
    ):
        choice = choose_by_rule(_dominant(value, partner), span, rtol)
        assert choice.method == method
        assert choice.reason


def test_tolerances_that_are_not_kept_are_warned_of(missile: Scene) -> None:
    model = rodgen.build(missile, "c")
    for method, rtol, damping, warned in (
        ("gauss", 1e-4, 20.0, True),  # what should die out does not
        ("gauss", 1e-6, 20.0, False),
        ("gauss", 1e-6, 1e-3, True),  # swings that are stepped over
        ("dop853", 1e-2, 20.0, False),
        ("radau", 1e-2, 20.0, False),
        ("gauss", 2.3e-14, 1e-3, True),  # rounding errors are larger
        ("dop853", 2.3e-14, 1e-3, False),
    ):
        scene = _damped(missile, damping, method=method, rtol=rtol)
        assert bool(tolerance_doubt(System(scene), model)) == warned
    for damping, expected in ((1e-3, "dop853"), (20.0, "radau")):
        scene = _damped(missile, damping, rtol=1e-6, method="auto")
        assert rodgen.choose(scene, model).method == expected
