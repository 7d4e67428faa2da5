"""What is told of a run and of the making of its module, to a callback or in a bar."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import rodgen
from rodgen import progress
from rodgen.integrate import simulate as simulate_function
from rodgen.progress import COMPILING, DERIVING, EMITTING, INTEGRATING, Moment
from rodgen.scene import Scene, Structure

Make = Callable[..., Scene]


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> _Terminal:
    """Standard error, as somebody would see it; bars do not wait before they appear."""
    seen = _Terminal()
    monkeypatch.setattr(sys, "stderr", seen)
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    return seen


@pytest.fixture
def _empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))


@pytest.mark.usefixtures("_empty_cache")
def test_a_module_tells_of_its_stages_once() -> None:
    structure, told = Structure(2, "pinned", terms=()), list[str]()
    rodgen.build(structure, stage=told.append)
    assert told == [DERIVING, EMITTING]
    rodgen.build(structure, stage=told.append)  # from the cache
    assert told == [DERIVING, EMITTING]


@pytest.mark.compiler
def test_a_run_tells_of_making_and_of_time(
    make_scene: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same callback: of making, the time is that of the start."""
    monkeypatch.setattr(sys.modules[simulate_function.__module__], "TICK", 0.0)
    told = list[Moment]()
    rodgen.simulate(make_scene(3, span=[2.0, 3.0]), progress=told.append, method="dop853")
    making = [at for at in told if at.stage != INTEGRATING]
    assert making[-1].stage == COMPILING
    assert set(making) == {2.0}
    integrated = [at for at in told if at.stage == INTEGRATING]
    assert integrated == sorted(integrated)
    assert 2.0 < integrated[-1] <= 3.0


def test_a_bar_is_shown_where_somebody_looks(make_scene: Make, terminal: _Terminal) -> None:
    scene = make_scene(3, method="rk4", step=1e-4)  # long enough for a bar without patience
    rodgen.simulate(scene, target="numpy")
    assert "test" in terminal.getvalue()


def test_no_bar_where_it_is_not_wanted(make_scene: Make, terminal: _Terminal) -> None:
    scene = make_scene(3, span=[0.0, 0.1])
    rodgen.simulate(scene, target="numpy", progress=False)
    rodgen.simulate(scene, target="numpy", progress=lambda _: None)
    assert not terminal.getvalue()


def test_nobody_looks_on_where_errors_go_to_a_file(make_scene: Make) -> None:
    assert not progress.watched()


def test_one_bar_at_a_time(terminal: _Terminal) -> None:
    with progress.working("outer") as outer:
        with progress.working("inner") as inner:
            inner("what nobody sees")
        outer("what is done")
    assert "inner" not in terminal.getvalue()
    with progress.working("after"):
        pass
    assert progress._shown.acquire(blocking=False)
    progress._shown.release()
