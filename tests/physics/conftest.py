"""Physics is tried with the NumPy target; that C gives the same is tested in tests/generated."""

from __future__ import annotations

import sys

import pytest

from rodgen.integrate import simulate
from rodgen.loading import build


@pytest.fixture(autouse=True)
def _numpy_unless_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules[simulate.__module__]
    monkeypatch.setattr(module, "build_fastest", lambda scene, *_: build(scene, "numpy"))
