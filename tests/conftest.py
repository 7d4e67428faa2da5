"""Shared by all tests: a cache of their own, scenes as dictionaries, a way to run rodgen."""

from __future__ import annotations

import copy
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rodgen.scene import Scene
from rodgen.scene.tables import TABLES

ROOT = Path(__file__).parents[1]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update", action="store_true", help="rewrite the reference modules")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "compiler: needs a C compiler")
    config.addinivalue_line("markers", "long: takes long; `make test-all` alone runs it")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Where there is no C compiler, what needs one is skipped and says so."""
    if any(map(shutil.which, ("cc", "gcc", "clang"))):
        return
    skip = pytest.mark.skip(reason="no C compiler on PATH")
    for item in items:
        if item.get_closest_marker("compiler") or "compiled" in item.path.parts:
            item.add_marker(skip)


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Tests neither read nor fill the cache of whoever runs them; those that run side by side
    share one."""
    together = "PYTEST_XDIST_WORKER" in os.environ
    base = tmp_path_factory.getbasetemp()
    os.environ["RODGEN_CACHE"] = str((base.parent if together else base) / "cache")


LOADS: dict[str, dict[str, Any]] = {
    "follower": {"force": 40.0, "angle": 0.1},
    "gravity": {"g": 9.81},
    "internal_damping": {"coefficient": 0.2},
    "external_damping": {"coefficient": 0.7, "fin_factor": {"tail": 5.0}},
    "tip_load": {"x": 6.0, "y": "-4*cos(3*t)"},
}


@pytest.fixture
def make_scene() -> Callable[..., Scene]:
    """Scene of a short run; terms: which loads; other keywords: tables or keys of [rod]."""

    def make(
        links: int = 5,
        boundary: str = "free",
        terms: tuple[str, ...] = (),
        rod: dict[str, Any] | None = None,
        initial: dict[str, Any] | None = None,
        **integrate: Any,
    ) -> Scene:
        table: dict[str, Any] = {
            "name": "test",
            "rod": {
                "links": links,
                "length": 2.0,
                "bending_stiffness": 30.0,
                "mass": 3.0,
                "boundary": boundary,
                **(rod or {}),
            },
            "loads": {TABLES[term]: copy.deepcopy(LOADS[term]) for term in terms},
            "initial": {"phi": "0.4*cos(pi*s)", "omega": "0.5*s", **(initial or {})},
            "integrate": {"span": [0.0, 1.0], "rtol": 1e-10, "atol": 1e-12, **integrate},
        }
        return Scene.from_dict(table)

    return make


@pytest.fixture
def rodgen() -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run the command line in a process of its own."""

    def run(*arguments: object, **options: Any) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", "from rodgen.cli import main; main()"]
        return subprocess.run(
            [*command, *map(str, arguments)],
            capture_output=True,
            text=True,
            timeout=120,
            env={**os.environ, "COLUMNS": "100", **options.pop("env", {})},
            check=False,
            **options,
        )

    return run
