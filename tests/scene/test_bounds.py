"""Masses and stiffness that are too small, or not finite, somewhere between samples."""

from __future__ import annotations

from typing import Any

import pytest

from rodgen.scene import Scene, SceneError

ROD = {"links": 10, "length": 1.0, "bending_stiffness": 1.0}
SPAN = {"span": [0.0, 7.0]}


def _stiff(law: str) -> dict[str, Any]:
    return {"rod": ROD | {"mass": 1.0, "bending_stiffness": law}}


def _heavy(law: str) -> dict[str, Any]:
    return {"rod": ROD | {"mass_per_length": law}}


def _carrying(law: str) -> dict[str, Any]:
    return _stiff("1") | {"bodies": [{"name": "tank", "at": 0.5, "mass": law}]}


@pytest.mark.parametrize(
    ("tables", "field", "where"),
    [
        (_stiff("abs(s - 0.123456789) - 1e-6"), "rod.bending_stiffness", "0.123457"),
        (_stiff("(s - 0.3141592)**2 - 1e-9"), "rod.bending_stiffness", "0.314159"),
        (_stiff("interp(s, [0, 0.12345, 1], [1, -1e-6, 1])"), "rod.bending_stiffness", "0.12345"),
        (_stiff("1/abs(s - 0.31415926)"), "rod.bending_stiffness", "0.314159"),
        (_stiff("2 if s < 0.2999999 else -1 if s < 0.3 else 2"), "rod.bending_stiffness", "0.3"),
        (_heavy("(s - 0.2)**2 + (t - 1.2345)**2 - 1e-7"), "rod.mass_per_length", "1.2345"),
        (_heavy("abs(s - 0.2345) + abs(t - 3.21) - 1e-7"), "rod.mass_per_length", "3.21"),
        (_heavy("2 if t < 1.2345 else -1 if t < 1.2346 else 2"), "rod.mass_per_length", "1.2345"),
        (_heavy("1/(t - 3.2123)**2"), "rod.mass_per_length", "3.2123"),
        (_carrying("1.0 - cos(t - 3.2123)"), "bodies[0].mass", "3.2123"),
        (_carrying("interp(t, [0, 3.3333, 7], [1, -1e-9, 1])"), "bodies[0].mass", "3.3333"),
    ],
)
def test_what_lies_between_samples_is_found(tables: Any, field: str, where: str) -> None:
    with pytest.raises(SceneError) as refused:
        Scene.from_dict({"name": "dip", "integrate": SPAN, **tables})
    assert refused.value.field == field
    assert where in refused.value.allowed


@pytest.mark.parametrize(
    "tables",
    [
        _stiff("(s - 0.3141592)**2"),  # a stiffness may be zero
        _stiff("1 - s"),
        _stiff("abs(sin(20*s))"),
        _heavy("1 + 0.999*sin(40*t + 3*s)"),
        _heavy("2 if s > t/7 else 1e-3"),
        _carrying("1.0001 - cos(t - 3.2123)"),
    ],
)
def test_what_is_large_enough_is_taken(tables: Any) -> None:
    Scene.from_dict({"name": "dip", "integrate": SPAN, **tables})
