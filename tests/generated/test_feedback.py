"""Modules whose loads follow the motion by sensors, and that have states of their own."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest

from rodgen.check.module import _drawn, check_module
from rodgen.scene.structure import Structure
from tests.palette import ALL, ENDS, LAWS, LONG, STATES

Built = Callable[..., ModuleType]


@pytest.mark.parametrize(
    ("boundary", "inertia", "links", "form", "uneven"),
    [
        ("free", "uniform", 1, "chain", ()),
        ("free", "lumped", 5, "dense", ("points",)),
        ("clamped", "uniform", 4, "chain", ("stiffness", "bodies")),
        ("cantilever", "uniform", 2, "dense", ()),
        ("pinned", "lumped", 8, "chain", ()),
    ],
)
def test_module_equals_fifty_digit_arithmetic(
    built: Built, boundary: str, inertia: str, links: int, form: str, uneven: tuple[str, ...]
) -> None:
    terms = ALL if links == 2 else ENDS
    structure = Structure(links, boundary, inertia, terms, LAWS, uneven, STATES)
    # Rounding of some hundred operations, amplified by the condition of M.
    assert max(d.error for d in check_module(built(structure, "numpy", form), states=2)) < 1e-12


def test_signals_are_what_laws_follow(built: Built) -> None:
    """Along leading axes, and by two routes: positions of the joints, and differences of them."""
    module = built(Structure(4, "free", "uniform", ENDS, LAWS, states=STATES))
    values, y = _drawn(module, 0.3, np.random.default_rng(1), 0.5, 0.5)
    p, h = module.parameters(**values), 1e-6
    moved = y + h * np.concatenate((y[6:12], np.zeros(8)))
    found = module.signals(0.3, np.stack((y, moved)), p)
    joints = module.joints(np.stack((y, moved)), p)
    at = joints[:, 2] + 0.4 * (joints[:, 3] - joints[:, 2])  # s = 0.6 of four links
    assert found["vx(0.6)"][0] == pytest.approx((at[1, 0] - at[0, 0]) / h, abs=1e-5)
    np.testing.assert_allclose(found["y(1.0)"], joints[:, -1, 1], rtol=1e-12)
    # Beyond its bounds the angle of the thrust is one of them.
    c, angle = values["c"], found["follower_angle"]
    assert (np.abs(angle) <= c * (1 + 1e-12)).all()


def test_a_module_without_feedback_has_nothing_of_it(
    written: Callable[..., dict[str, str]],
) -> None:
    text = "".join(written(LONG[0], "c").values())
    for word in ("sensor", "state_", "_by_", "STATES =", "signals"):
        assert word not in text
