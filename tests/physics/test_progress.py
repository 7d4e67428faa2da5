"""What is told of a run and of the making of its module, to a callback or in a bar."""

from __future__ import annotations

import io
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr
from pathlib import Path
from types import ModuleType

import pytest

import rodgen
from rodgen import progress
from rodgen.integrate import simulate as simulate_function
from rodgen.progress import COMPILING, DERIVING, EMITTING, report_stages_to
from rodgen.scene import Structure
from tests.sets import Make
from tests.told import numbers


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@contextmanager
def _looked_at() -> Iterator[_Terminal]:
    """Standard error, as somebody would see it; bars do not wait before they appear."""
    seen = _Terminal()
    with redirect_stderr(seen), pytest.MonkeyPatch.context() as patch:
        patch.setattr(progress, "PATIENCE", 0.0)
        yield seen


@pytest.fixture
def _empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))


@pytest.mark.usefixtures("_empty_cache")
def test_a_module_tells_of_its_stages_once() -> None:
    structure, told = Structure(2, "pinned", terms=()), list[str]()
    with report_stages_to(told.append):
        rodgen.build(structure)
    assert told == [DERIVING, EMITTING]
    with report_stages_to(told.append):
        rodgen.build(structure)  # from the cache
    assert told == [DERIVING, EMITTING]


class _Told:
    """Stages and times, as they were told."""

    def __init__(self) -> None:
        self.stages, self.times = list[str](), list[float]()

    def stage(self, name: str) -> None:
        assert not self.times
        self.stages.append(name)

    def __call__(self, t: float) -> None:
        self.times.append(t)


@pytest.mark.compiler
def test_a_run_tells_of_making_and_of_time(
    make_scene: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules[simulate_function.__module__], "TICK", 0.0)
    told = _Told()
    scene = make_scene(3, span=[2.0, 3.0])
    rodgen.simulate(scene, progress=told, target="c", method="dop853")
    assert told.stages[-1] == COMPILING
    assert told.times == sorted(told.times)
    assert 2.0 < told.times[-1] <= 3.0


def _wait_for(terminal: _Terminal, text: str) -> None:
    until = time.monotonic() + 30.0
    while text not in terminal.getvalue() and time.monotonic() < until:
        time.sleep(0.01)
    assert text in terminal.getvalue()


def test_a_bar_tells_of_stages_and_of_time() -> None:
    with _looked_at() as terminal, progress.show_run("swing", 0.0, 2.0) as update:
        progress.report_stage(DERIVING)
        _wait_for(terminal, DERIVING)
        update(1.0)
        _wait_for(terminal, "t = 1.000 s of 2 s")
    assert "swing" in terminal.getvalue()


def test_a_bar_in_a_notebook_is_one_output_that_goes_away(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[dict[str, str]] = []

    class Place:
        def update(self, data: dict[str, str], raw: bool) -> None:
            assert raw
            seen.append(data)

    def display(data: dict[str, str], raw: bool, display_id: bool) -> Place:
        assert raw
        assert display_id
        seen.append(data)
        return Place()

    kernel = ModuleType("IPython.display")
    kernel.display = display
    monkeypatch.setitem(sys.modules, "IPython.display", kernel)
    monkeypatch.setitem(sys.modules, "ipykernel", ModuleType("ipykernel"))
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    monkeypatch.setattr(progress, "TOLD", 0.0)
    with redirect_stderr(io.StringIO()) as text, progress.show_run("<a>", 0.0, 2.0) as update:
        for t in (0.5, 1.0):
            while len(seen) < 3 and not any(f"t = {t:.3f}" in one["text/plain"] for one in seen):
                update(t)
    assert text.getvalue() == ""
    halfway = next(one for one in seen if "t = " in one["text/plain"])
    assert halfway["text/html"].startswith('<progress max="2.0" value="')
    assert "&lt;a&gt;, t = " in halfway["text/html"]
    assert "s left" in seen[-2]["text/plain"]
    assert seen[-1] == {"text/plain": "", "text/html": ""}


def test_no_bar_where_it_is_not_wanted(make_scene: Make) -> None:
    scene = make_scene(2, span=[0.0, 0.1])
    with _looked_at() as terminal:
        rodgen.simulate(scene, target="numpy", progress=False)
        rodgen.simulate(scene, target="numpy", progress=_Told())
        vary = {"initial.phi": [0.1, 0.2]}
        rodgen.study(scene, vary, analysis="static", workers=1, progress=False)
    assert not terminal.getvalue()


def test_lines_where_there_is_no_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    """Now and then, of what was done and what is left; none to whoever is told already."""
    monkeypatch.setattr(progress, "FIRST", 0.0)
    lines: list[str] = []
    with progress.show_count("map", 10, 2, lines.append) as count:
        count(3, 1)
    progress.announce("a map", lines.append)
    assert len(lines) == 2
    assert numbers(lines[0])[:2] == [5, 10]
    with report_stages_to(lambda _: None), progress.show_count("map", 10, 2, lines.append) as count:
        count(3, 1)
        progress.announce("a map", lines.append)
    with _looked_at(), progress.show_count("map", 10, 2, lines.append) as count:
        count(3, 1)
        progress.announce("a map", lines.append)
    assert len(lines) == 2


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(3e-9, "3 ns"), (0.0421, "42.1 ms"), (90.0, "90 s"), (150.0, "2.5 min"), (9000.0, "2.5 h")],
)
def test_a_time_in_the_unit_that_suits_it(seconds: float, text: str) -> None:
    assert progress.format_duration(seconds) == text


def test_a_bar_within_another_speaks_in_that() -> None:
    with _looked_at() as terminal:
        with progress.show_work("outer") as outer:
            outer("first")
            with progress.show_work("inner") as inner:
                inner(DERIVING)
                _wait_for(terminal, DERIVING)
            with progress.show_run("run", 0.0, 1.0) as update:
                update(0.5)
            _wait_for(terminal, "t = 0.500 s of 1 s")
        assert progress._can_show_bar()  # again
    assert "inner" not in terminal.getvalue()
    assert "run" not in terminal.getvalue()
