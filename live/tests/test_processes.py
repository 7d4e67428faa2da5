"""What is made and computed in processes of their own: modules, answers, sweeps of a number."""

from __future__ import annotations

import asyncio
import json
import pickle
import queue
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest

import rodgen
from live.tests.conftest import SCENE, SCENES, SHORT, finished, runs, varied
from live.tests.view import PATIENT
from rodgen.errors import InputError
from rodgen.loading import build_fastest
from rodgen.scene import Scene, Structure
from rodgen.system import System
from rodgen_live.page import module_builder
from rodgen_live.page.build_process import PARTS
from rodgen_live.page.module_builder import ModuleBuilder
from rodgen_live.page.sweep_diagram import Diagram, SweepPoint
from rodgen_live.panel_rows import CriticalForce
from rodgen_live.run import critical_search
from rodgen_live.run.critical_search import COMPUTING, CriticalSearch
from rodgen_live.run.live_run import LiveRun
from rodgen_live.run.sweep_computation import sweep
from rodgen_live.run.worker_main import MOST_BEGUN, WORKS, Works
from rodgen_live.run.worker_process import Answer, PendingRequest, WorkerProcess
from tests.palette import ROD

FREE = Scene.from_dict({**ROD, "loads": {}})


def test_answers_refusals_and_defects_are_told_in_parts_by_turns(run: LiveRun) -> None:
    """In the process itself. What is begun and not asked for again is forgotten in the end."""
    works = Works()
    state = {"t": 0.0, "y": run.shown.y[-1].tolist(), "p": run.shown.p.tolist()}

    def answer(number: int, what: str, scene: Scene, more: dict[str, Any]) -> dict[str, Any]:
        table = json.loads(json.dumps(scene.model_dump(exclude_none=True)))
        return works.answer(number, what=what, scene=table, more=more)

    (modes,) = WORKS["modes"](SCENE, **state)
    assert answer(1, "modes", SCENE, state) == {"value": modes, "last": False}
    for number, what, scene, said in (
        (2, "critical", FREE, "follow"),
        (3, "no", SCENE, "KeyError"),
    ):
        refused = answer(number, what, scene, {})
        assert (said in refused["refused"], refused["last"]) == (True, True)
    assert works.answer(1) == {"value": None, "last": True}
    for number in range(4, 2 * MOST_BEGUN):
        answer(number, "no", SCENE, {})
    assert len(works._begun) == MOST_BEGUN


class Told(queue.Queue[Answer]):
    """Answers in the order in which they came."""

    def all(self) -> list[Answer]:
        """Up to the last."""
        found = [self.get(timeout=PATIENT)]
        while not found[-1].last:
            found.append(self.get(timeout=PATIENT))
        return found


@pytest.mark.slow
def test_process_answers_what_is_not_dropped_and_is_started_again_where_it_died() -> None:
    aside, dropped, told = WorkerProcess(), Told(), Told()
    try:
        for errand in [aside.submit("critical", SCENE, dropped.put) for _ in range(50)]:
            errand.cancel()
        aside.submit("critical", SCENE, told.put)
        found = rodgen.critical_load(SCENE)
        said = {"rows": dict(found.tables()[0].rows), "notes": [str(one) for one in found.notes]}
        wanted = [Answer({"value": found.value, **said}), Answer(last=True)]
        assert told.all() == wanted
        assert dropped.empty()
        aside.submit("critical", SCENE, told.put)
        assert aside._process is not None
        aside._process.send_signal(signal.SIGKILL)
        assert told.all()[-1].refused
        aside.submit("critical", SCENE, told.put)
        assert told.all() == wanted
    finally:
        aside.close()


def test_force_of_a_scene_that_changes_is_asked_for_once(
    clock: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """When nothing has changed for a while; an answer for the scene before is not taken, nor is
    it waited for."""
    asked: list[tuple[float, Any]] = []
    done: list[float] = []
    requests: list[PendingRequest] = []

    def submit(what: str, scene: Any, told: Any) -> PendingRequest:
        asked.append((scene.loads.follower.force, told))
        requests.append(PendingRequest({"what": what}, told))
        return requests[-1]

    monkeypatch.setattr(critical_search, "ASIDE", SimpleNamespace(submit=submit))
    one = CriticalSearch(lambda work: work(), lambda: done.append(one.found.value), clock)

    def look(force: float) -> None:
        one.restart(System(Scene.from_dict({**ROD, "loads": {"follower": {"force": force}}})))

    for force in (1.0, 2.0, 3.0):
        look(force)
        clock.now += 0.3
        one.tick()
    assert asked == []
    clock.now += 0.3
    for _ in range(2):
        one.tick()
    assert [force for force, _ in asked] == [3.0]
    look(4.0)
    assert requests[0].is_cancelled
    asked[0][1](Answer({"value": 30.0}))
    assert (one.found.value, done) == (COMPUTING, [])
    clock.now += 1.0
    one.tick()
    found = {"value": 40.0, "rows": {"kind": "flutter"}, "notes": ["it is doubtful"]}
    for answer in (Answer(found), Answer(last=True)):
        asked[1][1](answer)
    assert (one.found, done) == (CriticalForce(**found), [40.0])


@pytest.mark.slow
def test_sweep_of_a_dead_load_has_its_equilibria_unless_they_are_straight() -> None:
    """After the span: states lead on from there. Of the column that is loaded along its axis, the
    map of stability says all."""
    scene = Scene.from_toml(SCENES / "euler_column.toml")
    *_, lost, straight = sweep(scene, "loads.tip.y", -30.0, -1.0, t=1e3)
    assert (lost["change"], straight) == ("divergence ends", {})
    *_, found = sweep(scene.replace({"loads.tip.x": 0.5}), "loads.tip.y", -5.0, -1.0, t=1e3)
    assert len(found["branch"]["state"][0]) == len(scene.initial_state())
    assert max(found["branch"]["away"]) > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "at"), [("2*min(t/0.5, 1)", 0), ("interp(t, [0, 1, 9], [1, 3, 3])", 4)]
)
def test_number_in_an_expression_is_swept_as_a_load_of_that_size(text: str, at: int) -> None:
    """At a time when it is the load."""
    key, ends = "loads.follower.force", (2.0, 60.0)
    plain = Scene.from_dict(SHORT).replace({"loads.gravity.g": 0.0})
    timed = plain.replace({key: text})
    given, expected = (
        np.array([row for part in parts for row in part.get("rows", ())], dtype=float)
        for parts in (sweep(timed, f"{key}.{at}", *ends, t=1.0), sweep(plain, key, *ends, t=1.0))
    )
    assert np.ptp(expected[:, 1]) > 0.1  # 1/s: the number is felt
    np.testing.assert_allclose(given, expected, rtol=1e-9)  # the same, but for rounding


def test_rods_of_very_many_links_are_not_swept() -> None:
    with pytest.raises(InputError, match=r"^rod\.links = 300"):
        next(sweep(Scene.from_dict(varied(links=300)), "rod.mass", 1.0, 2.0, t=0.0))


def test_diagram_is_dashed_where_the_rod_is_not_stable() -> None:
    """As far as the next point that is: what lies between is not known."""
    points = [SweepPoint(k, h, s) for k, h, s in ((0.0, -1.0, True), (1.0, 0.5, False))]
    points += [SweepPoint(2.0, 3.0, None), SweepPoint(3.0, -2.0, True), SweepPoint(4.0, -3.0, True)]
    one = Diagram("P/growth", ("growth", "1/s"), ("P", "N"), Mock(), points)
    rows = np.array(one.rows, dtype=float).reshape(-1, 3)
    assert rows[:, 0].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    np.testing.assert_array_equal(rows[:, 1], [-1.0, np.nan, np.nan, -2.0, -3.0])
    np.testing.assert_array_equal(rows[:, 2], [-1.0, 0.5, 3.0, -2.0, np.nan])


def quiet(_: str) -> None:
    """Of no use is what is being done."""


async def come(true: Callable[[], bool]) -> None:
    async with asyncio.timeout(PATIENT):
        while not true():
            await asyncio.sleep(0.05)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are seen in /proc")
def test_cancelled_making_ends_its_compiler(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And none is begun while the server ends. A compiler that is started leaves a file, which has
    the id of its process for a name."""
    script, folder = tmp_path / "cc", tmp_path / "started"
    folder.mkdir()
    script.write_text(f"#!/bin/sh\ntouch {folder}/$$\nexec sleep 600\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))

    def started() -> set[int]:
        return {int(file.name) for file in folder.iterdir()}

    async def cancelled() -> None:
        stages: list[str] = []
        task = asyncio.create_task(ModuleBuilder().build(Structure(2, terms=()), stages.append))
        await come(lambda: any(map(runs, started())))
        assert stages
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    finished(cancelled())
    before = started()
    assert before
    assert not any(map(runs, before))
    modules = ModuleBuilder(lambda: True)
    with pytest.raises(InputError, match="module"):
        finished(modules.build(Structure(2, terms=()), quiet))
    assert started() == before


ENDED_AT_ONCE = """
import os, signal, subprocess
from rodgen_live.page import build_process

class Popen(subprocess.Popen):
    def __init__(self, command, **options):
        super().__init__(command, **options)
        print("compiler", self.pid, flush=True)
        os.kill(os.getpid(), signal.SIGTERM)

subprocess.Popen = Popen
build_process.main()
"""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are seen in /proc")
def test_making_that_is_ended_as_compilers_begin_ends_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where the process ignores Ctrl-C, as it does below a shell in the background."""
    script = tmp_path / "cc"
    script.write_text("#!/bin/sh\nexec sleep 600\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        done = subprocess.run(
            [sys.executable, "-c", ENDED_AT_ONCE],
            input=pickle.dumps(Structure(2, terms=())),
            capture_output=True,
            timeout=60,
        )
    finally:
        signal.signal(signal.SIGINT, before)
    compilers = re.findall(rb"compiler (\d+)", done.stdout)
    assert done.returncode == 1
    assert compilers
    assert not any(runs(int(one)) for one in compilers)


def test_a_module_in_the_cache_needs_no_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is loaded beside the page, even where processes are busy."""
    started = Mock()
    monkeypatch.setattr(module_builder, "_build", started)
    build_fastest(structure := Structure(2), PARTS)
    finished(ModuleBuilder().build(structure, quiet))
    started.assert_not_called()


def test_two_at_a_time_and_none_of_too_many_links(monkeypatch: pytest.MonkeyPatch) -> None:
    """The third begins when one of the others is given up."""
    begun: list[int] = []

    async def endless(structure: Structure, _: object) -> None:
        begun.append(structure.n_links)
        await asyncio.Event().wait()

    async def three() -> None:
        modules = ModuleBuilder()
        tasks = [asyncio.create_task(modules.build(Structure(n), quiet)) for n in (2, 3, 4)]
        await come(lambda: len(begun) == 2)
        for _ in range(10):  # nothing else is to be done
            await asyncio.sleep(0)
        assert begun == [2, 3]
        tasks[0].cancel()
        await come(lambda: len(begun) == 3)
        for task in tasks[1:]:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    monkeypatch.setattr(module_builder, "is_derived", lambda *_: False)
    monkeypatch.setattr(module_builder, "_build", endless)
    finished(three())
    with pytest.raises(InputError, match="2000"):
        finished(ModuleBuilder().build(Structure(2001), quiet))
