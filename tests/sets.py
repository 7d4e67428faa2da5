"""Cases by the sets of tests that they belong to, where no covering array chooses them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import pytest

from rodgen.scene import Scene

Make = Callable[..., Scene]  # the fixture make_scene


def sets(quick: Iterable[Any], slow: Iterable[Any] = (), nightly: Iterable[Any] = ()) -> list[Any]:
    """Cases to parametrize a test by: those of `make test`, of `make check`, and of the night. A
    later set may name all of them, of which it has the others."""
    found: list[Any] = []
    seen: list[Any] = []
    for marks, some in (((), quick), (pytest.mark.slow, slow), (pytest.mark.nightly, nightly)):
        for case in some:
            if case not in seen:
                parts = case if isinstance(case, tuple) else (case,)
                found.append(pytest.param(*parts, marks=marks))
                seen.append(case)
    return found
