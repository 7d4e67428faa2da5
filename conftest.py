"""Shared by all tests: a cache of their own, scenes as dictionaries, ways to run rodgen."""

from __future__ import annotations

import copy
import io
import os
import shutil
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from threadpoolctl import threadpool_limits

from rodgen.model.term import AIR
from rodgen.model.terms import TERMS
from rodgen.native.library import FLAGS
from rodgen.scene import Scene
from tests.cache import CACHES, cache
from tests.times import Times


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update", action="store_true", help="write pictures and pages of the docs anew"
    )
    parser.addoption("--times", metavar="NAME", help="keep times for `make bench NAME=tests`")


def pytest_configure(config: pytest.Config) -> None:
    settings.register_profile("any machine", deadline=None)  # A busy one is no fault.
    settings.load_profile("any machine")
    if name := config.getoption("times"):
        config.pluginmanager.register(Times(name, worker=hasattr(config, "workerinput")))
    # Matrices of tests are small, and test processes are as many as cores: threads of OpenBLAS,
    # here and in what is loaded or started later, would only wait for each other.
    threadpool_limits(int(os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")))
    # A shell has what it starts in the background ignore Ctrl-C, which tests send.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Where there is no C compiler, what needs one is skipped and says so."""
    if any(map(shutil.which, ("cc", "gcc", "clang"))):
        return
    skip = pytest.mark.skip(reason="no C compiler on PATH")
    for item in items:
        if item.get_closest_marker("compiler") or "compiled" in item.path.parts:
            item.add_marker(skip)


@pytest.fixture(autouse=True)
def _signals() -> Iterator[None]:
    """Commands that are called within the process of the tests leave their answers to signals."""
    ends = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
    before = {one: signal.getsignal(one) for one in ends}
    yield
    for one, answer in before.items():
        signal.signal(one, answer)


# Of other generators, caches of the last day stay, for who goes to and fro.
DAY = 86400.0

# A compilation takes a third of the time; the nightly run, and tests of what the compiler makes of
# the loops (`flags_of_users`), have all that users have.
QUICK = " ".join(("-O1", *FLAGS[1:]))


@pytest.fixture(scope="session", autouse=True)
def _own_cache(pytestconfig: pytest.Config) -> None:
    """Tests neither read nor fill the cache of whoever runs them; all runs of tests share one."""
    if pytestconfig.getoption("markexpr") != "nightly":
        os.environ.setdefault("RODGEN_CFLAGS", QUICK)
    folder = cache()
    os.utime(folder)
    for other in CACHES.iterdir():
        with suppress(OSError):
            if time.time() - other.stat().st_mtime > DAY:
                shutil.rmtree(other)
    os.environ["RODGEN_CACHE"] = str(folder)


@pytest.fixture
def flags_of_users(monkeypatch: pytest.MonkeyPatch) -> None:
    """C is compiled as it is for users."""
    monkeypatch.delenv("RODGEN_CFLAGS", raising=False)


START = time.time()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say how many structures were compiled in this run, in whatever parts: they cost most."""
    found = set()
    for path in cache().rglob("rod_*.so"):
        with suppress(OSError):  # of what is being built meanwhile, some vanishes
            if path.stat().st_mtime >= START:
                found.add(path.stem)
    terminalreporter.write_line(f"{len(found)} structures compiled")


LOADS: dict[str, Any] = {
    "follower": {"force": 40.0, "angle": 0.1},
    "gravity": {"g": 9.81},
    "internal_damping": {"coefficient": 0.2},
    "external_damping": {"coefficient": 0.7, "fin_factor": {"tail": 5.0}},
    "tip_load": {"x": 6.0, "y": "-4*cos(3*t)"},
    "distributed_follower": {"force_per_length": "3*(1 + s)"},
    "material_damping": {"time": 0.005},
    "foundation": {"stiffness": "2*(1 + s)", "damping": 0.3},
    "drag": {"normal": 0.5, "tangential": 0.1, "wind": [2.0, "sin(t)"]},
    "viscous_drag": {"normal": 0.4, "tangential": 0.2, "wind": [1.0, "cos(t)"]},
    "moment": {"moment": 5.0},
    "fins": {"at": 1.0, "normal_slope": 6.0, "area": 0.02},
    "nose": {"at": 1.0, "area": 0.02},
    "axial_drag": {"at": 1.0, "coefficient": 0.4, "area": 0.02},
    "joint_friction": {"moment_per_joint": 0.2, "rate": 0.3},
    "supports": [{"at": 1.0, "stiffness": [3.0, 1.0], "damping": [0.2, 0.1], "rotation": 0.5}],
}


AIR_OF_SCENES: dict[str, Any] = {"density": 1.3, "wind": [1.5, "0.5*sin(2*t)"]}


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
            "loads": {
                TERMS[term].table: copy.deepcopy(LOADS[term])
                for term in terms
                if TERMS[term].is_load
            },
            **{
                TERMS[term].table: copy.deepcopy(LOADS[term])
                for term in terms
                if not TERMS[term].is_load
            },
            **({"air": AIR_OF_SCENES} if any(TERMS[x].kind == AIR for x in terms) else {}),
            "initial": {"phi": "0.4*cos(pi*s)", "omega": "0.5*s", **(initial or {})},
            "integrate": {"span": [0.0, 1.0], "rtol": 1e-10, "atol": 1e-12, **integrate},
        }
        return Scene.from_dict(table)

    return make


Done = subprocess.CompletedProcess[str]


@pytest.fixture
def rodgen(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Done]:
    """Run the command line in this process: rodgen(*arguments, cwd=..., env=...). What it writes
    and its exit status come back; an exception that it does not explain is raised."""
    from rodgen.cli import console, main

    def run(*arguments: object, cwd: Path | None = None, env: dict[str, str] | None = None) -> Done:
        out, err = io.StringIO(), io.StringIO()
        with monkeypatch.context() as patch, warnings.catch_warnings():
            warnings.simplefilter("default")
            for name, value in {"COLUMNS": "100", **(env or {})}.items():
                patch.setenv(name, value)
            for printed in (console.out, console.err):
                printed.width = int(os.environ["COLUMNS"])
            patch.setattr(sys, "argv", ["rodgen", *map(str, arguments)])
            patch.chdir(cwd or Path.cwd())
            with redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as end:
                main()
        status = int(end.value.code or 0)
        return subprocess.CompletedProcess(sys.argv, status, out.getvalue(), err.getvalue())

    return run


@pytest.fixture
def process() -> Callable[..., Done]:
    """Run the command line in a process of its own, where it is the process that is looked at."""

    def run(*arguments: object, **options: Any) -> Done:
        return subprocess.run(
            [sys.executable, "-m", "rodgen", *map(str, arguments)],
            capture_output=True,
            text=True,
            timeout=120,
            env={**os.environ, "COLUMNS": "100", **options.pop("env", {})},
            check=False,
            **options,
        )

    return run
