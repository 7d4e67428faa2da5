"""What is taken away of a run: its file and film, and a page of it without a server."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from live.tests.runs import decoded, to
from live.tests.view import View, expect
from rodgen import simulate
from rodgen.errors import InputError
from rodgen.integrate import Solution
from rodgen.scene import Scene
from rodgen_live.page.export import FILES, export
from rodgen_live.replay import replay
from rodgen_live.run.live_run import LiveRun
from tests.palette import ROD

TAIL = {"kind": "time", "y": ["phi_4"]}
MOMENTS = {"kind": "profile", "y": ["bending_moment"]}


@pytest.fixture(scope="module")
def solution() -> Solution:
    return simulate(Scene.from_dict(ROD), span=[0.0, 0.4])


def test_messages_are_the_samples_of_the_run(solution: Solution) -> None:
    made = replay(solution, [TAIL, MOMENTS])
    assert made.times == pytest.approx(solution.t)
    _, standing = decoded(made.first)
    assert standing["plot!p0"].reshape(-1, 2)[:, 1] == pytest.approx(solution.values("phi")[:, -1])
    at_first = standing["plot!p1"].reshape(-1, 2)[:, 1]
    assert at_first == pytest.approx(solution.values("bending_moments")[0][-len(at_first) :])
    header, arrays = decoded(made.frames[37])
    assert (header["t"], header["line"]["past"]) == (solution.t[37], solution.t[37])
    joints = solution.joints[37] - np.array(header["origin"])
    assert arrays["joints"].reshape(-1, 2) == pytest.approx(joints, abs=1e-6)  # single precision
    moments = arrays["plot!p1"].reshape(-1, 2)[:, 1]
    assert moments == pytest.approx(solution.values("bending_moments")[37][-len(moments) :])
    assert [spec["window"] for spec in made.plots] == [0.4, 0.4]  # the whole run


def test_long_runs_are_shown_by_some_of_their_samples(
    solution: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rodgen_live.replay.MOST", most := 50)
    count = 2 * most
    y = np.resize(solution.y, (count, solution.y.shape[1]))
    made = replay(replace(solution, t=np.linspace(0.0, 1.0, count), y=y, work={}), [TAIL])
    assert len(made.times) == most
    assert (made.times[0], made.times[-1]) == (0.0, 1.0)
    assert np.ptp(np.diff(made.times)) <= 1.01 / (count - 1)  # evenly, but for one sample
    with pytest.raises(InputError):
        replay(replace(solution, t=solution.t[:1], y=solution.y[:1], work={}), [])  # of one


def test_changes_and_kicks_of_a_live_run_are_in_its_solution(run: LiveRun) -> None:
    """The energy that they gave, and what held when; both are marked."""
    to(run, 0.2)
    changes = {"rod.mass": 4.0, "loads.gravity.g": 1.0}
    run.submit(lambda: run.change(run.live.system.at(changes), "change")).result()
    to(run, 0.3)
    run.submit(lambda: run.kick(1, 0.25, (0.5, 2.0))).result()
    to(run, 0.4)
    sol = run.submit(run.solution).result()
    assert sol.energy_error < 1e-6  # rtol 1e-8 of some 100 J
    weight = np.where(sol.t <= 0.2, 3.0 * 9.81, 4.0 * 1.0)
    np.testing.assert_allclose(sol.energy.gravity, weight * sol.centre_of_gravity[:, 1], atol=1e-9)
    given = np.split(sol.changes.given, [21, 31])  # after the samples at 0.2 and 0.3 s
    assert [np.ptp(part) for part in given] == [0.0, 0.0, 0.0]
    assert np.abs(np.diff([part[0] for part in given])).min() > 0.1  # J
    header, _ = decoded(replay(sol, []).first)
    marks = header["line"]["marks"]
    assert [t for t, _ in marks] == pytest.approx([0.21, 0.31])  # the first samples after them
    assert all(what for _, what in marks)


def test_folder_holds_the_page_and_can_be_written_again(solution: Solution, tmp_path: Path) -> None:
    """One of others is left alone."""
    for _ in range(2):
        export(solution, tmp_path / "talk")
        assert {path.name for path in (tmp_path / "talk").iterdir()} == FILES
    assert [path.name for path in tmp_path.iterdir()] == ["talk"]  # nothing is left beside it
    text = (tmp_path / "talk" / "run.js").read_text()
    run = json.loads(text.removeprefix("window.rodgenRun = ").rstrip(";\n"))
    data = base64.b64decode(run["data"])
    assert len(data) == run["ends"][-1]
    header, _ = decoded(data[run["ends"][1] : run["ends"][2]])
    assert (header["t"], len(run["ends"])) == (0.0, len(run["times"]) + 2)
    for foreign in ("mine.txt", "index.html"):
        other = tmp_path / foreign.partition(".")[0]
        other.mkdir()
        (other / foreign).write_text("kept")
        with pytest.raises(InputError, match="--export"):
            export(solution, other)
        assert [(path.name, path.read_text()) for path in other.iterdir()] == [(foreign, "kept")]


def test_command_writes_scenes_and_results(
    solution: Solution, tmp_path: Path, rodgen: Callable[..., Any]
) -> None:
    (tmp_path / "dart.toml").write_text(solution.scene.to_toml())
    solution.save(tmp_path / "run.nc")
    for name in ("dart.toml", "run.nc"):
        page = tmp_path / f"page of {name}" / "index.html"
        done = rodgen("view", tmp_path / name, "--export", page.parent)
        assert (done.returncode, done.stderr) == (0, "")
        assert str(page) in done.stdout.replace("\n", "")
        assert page.exists()
    done = rodgen("view", tmp_path / "dart.toml", "--export", tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "--export" in done.stderr


@pytest.mark.slow
def test_exported_page_replays_its_run(solution: Solution, browser: Any, tmp_path: Path) -> None:
    """From the file system, without a server: it plays, goes to where the keys say, and asks for
    its own files alone."""
    export(solution, tmp_path / "talk")
    context = browser.new_context()
    view = View(context.new_page())
    view.page.goto((tmp_path / "talk" / "index.html").as_uri())
    view.sees("live.t > 0.1")
    view.line().press("Home")
    view.sees("live.t === 0")
    view.line().press("ArrowRight")
    view.sees("Math.abs(live.t - 0.01) < 1e-9")
    expect(view.line()).to_have_value("0.01")
    view.sees("Object.values(live.plots).every(({ draws }) => draws > 0)")
    # Of 0.4 s by 0.01 s, angles and energies; moments at both ends of five links.
    assert view.live("Object.values(live.plots).map(({ rows }) => rows)") == [41, 41, 6]
    expect(view.button("Another run")).to_have_count(0)
    context.close()
    folder = (tmp_path / "talk").as_uri()
    assert view.errors == []
    assert [url for url in view.asked if not url.startswith((folder, "data:"))] == []
