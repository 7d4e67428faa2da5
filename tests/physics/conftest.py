"""Physics is tried with the NumPy target; that C gives the same is tested in tests/generated."""

from __future__ import annotations

import sys

import pytest

from rodgen.loading import build
from rodgen.system import System


@pytest.fixture(autouse=True)
def _numpy_unless_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    module = sys.modules[System.__module__]
    monkeypatch.setattr(module, "build_fastest", lambda structure, *_: build(structure, "numpy"))
