"""A recorded run as a page without a server: its messages, its files, and the page in a browser."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("nicegui", reason="the extra view is not installed")

from rodgen import simulate
from rodgen.integrate.solution import Solution
from rodgen.live.page.export import FILES, export
from rodgen.live.replay import MOST, replay
from rodgen.live.run.live_run import LiveRun
from rodgen.scene import Scene, SceneError
from tests.live.conftest import ROD, WIDE
from tests.live.view import expect

TAIL = {"kind": "time", "y": ["phi_4"]}
MOMENTS = {"kind": "profile", "y": ["bending_moment"]}
Browser = Any  # see conftest.py


@pytest.fixture(scope="module")
def solution() -> Solution:
    scene = Scene.from_dict({**ROD, "integrate": {**ROD["integrate"], "span": [0.0, 1.0]}})
    return simulate(scene)


def decoded(message: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    (length,) = struct.unpack_from("<I", message)
    header, at = json.loads(message[4 : 4 + length]), 4 + length
    arrays = {}
    for name, kind, count in header["arrays"]:
        arrays[name] = np.frombuffer(message, f"<{kind}", count, at)
        at += -(-arrays[name].nbytes // 8) * 8
    return header, arrays


def test_messages_are_the_samples_of_the_run(solution: Solution) -> None:
    made = replay(solution, [TAIL, MOMENTS])
    assert made.times == pytest.approx(solution.t)
    _, standing = decoded(made.first)
    rows = standing["plot!p0"].reshape(-1, 2)
    assert rows[:, 1] == pytest.approx(solution.values("phi")[:, -1])
    at_first = standing["plot!p1"].reshape(-1, 2)[:, 1]
    assert at_first == pytest.approx(solution.values("bending_moments")[0][-len(at_first) :])
    header, arrays = decoded(made.frames[37])
    assert (header["t"], header["line"]["past"]) == (solution.t[37], solution.t[37])
    joints = solution.joints[37] - np.array(header["origin"])
    assert arrays["joints"].reshape(-1, 2) == pytest.approx(joints, abs=1e-6)  # single precision
    moments = arrays["plot!p1"].reshape(-1, 2)[:, 1]
    assert moments == pytest.approx(solution.values("bending_moments")[37][-len(moments) :])
    assert [spec["window"] for spec in made.plots] == [1.0, 1.0]  # the whole run


def test_long_runs_are_shown_by_some_of_their_samples(solution: Solution) -> None:
    scene = solution.scene.replace({"integrate.output_every": 1.0 / (2 * MOST)})
    made = replay(simulate(scene), [TAIL])
    assert len(made.times) == MOST
    assert (made.times[0], made.times[-1]) == (0.0, 1.0)
    assert np.ptp(np.diff(made.times)) <= 1.01 / (2 * MOST)  # evenly, but for one sample


def test_changes_of_a_live_run_are_marked(tmp_path: Path) -> None:
    run = LiveRun(Scene.from_dict(ROD))
    run.do(lambda: run._took(run.live.advance(0.2, 10.0))).result()
    run.do(lambda: run.kick(4, 1.0, (0.0, 0.1))).result()
    run.do(lambda: run._took(run.live.advance(0.4, 10.0))).result()
    recorded = run.do(run.solution).result()
    run.close()
    header, _ = decoded(replay(recorded, []).first)
    assert header["line"]["marks"] == [[pytest.approx(0.21), "a change or a kick"]]


def test_run_of_a_single_sample_is_refused(solution: Solution) -> None:
    with pytest.raises(SceneError, match="two samples"):
        replay(replace(solution, t=solution.t[:1], y=solution.y[:1], work={}), [])


def test_folder_holds_the_page_and_can_be_written_again(solution: Solution, tmp_path: Path) -> None:
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


@pytest.mark.parametrize("foreign", ["mine.txt", "index.html"])
def test_folder_of_others_is_left_alone(solution: Solution, tmp_path: Path, foreign: str) -> None:
    (tmp_path / foreign).write_text("kept")
    with pytest.raises(SceneError, match="--export"):
        export(solution, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [foreign]
    assert (tmp_path / foreign).read_text() == "kept"


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


@pytest.mark.nightly
def test_page_opens_from_the_file_system(
    solution: Solution, tmp_path: Path, browser: Browser
) -> None:
    """It plays, goes to where the keys say, and asks for its own files alone."""
    export(solution, tmp_path / "talk")
    page = browser.new_context(viewport=WIDE).new_page()
    errors: list[str] = []
    asked: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto((tmp_path / "talk" / "index.html").as_uri())
    page.wait_for_function("window.rodgenLive?.t > 0.1")
    line = page.get_by_role("slider", name="Time that is shown")
    line.press("Home")
    page.wait_for_function("rodgenLive.t === 0")
    line.press("ArrowRight")
    page.wait_for_function("Math.abs(rodgenLive.t - 0.01) < 1e-9")
    expect(line).to_have_attribute("aria-valuetext", "0.01 s, looking back")
    page.wait_for_function("Object.values(rodgenLive.plots).every(({ draws }) => draws > 0)")
    assert page.evaluate("Object.values(rodgenLive.plots).map(({ rows }) => rows)") == [101, 101, 6]
    assert page.get_by_role("button", name="Another run").count() == 0
    page.context.close()
    assert errors == []
    folder = (tmp_path / "talk").as_uri()
    assert [url for url in asked if not url.startswith((folder, "data:"))] == []
