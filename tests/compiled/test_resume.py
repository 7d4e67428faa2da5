"""Runs that are stopped, killed and taken up again, to the same bits."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import rodgen
from rodgen import Scene, SceneError
from rodgen.integrate.files.saver import Saver

SPAN = 20.0
RUN = """
import sys, rodgen
scene = rodgen.Scene.from_toml(sys.argv[1])
rodgen.simulate(scene, target="c", method=sys.argv[2], out=sys.argv[3], checkpoint=0.02)
"""
TOML = """
name = "swing"
[rod]
links = 12
length = 5.0
bending_stiffness = 100.0
mass = 50.0
boundary = "pinned"
[loads.gravity]
[loads.tip]
x = "sin(t) if t < 3 else 0.5"
[loads.internal_damping]
coefficient = 0.001
[initial]
phi = "-1.2 + 0.5*s"
[integrate]
span = [0.0, 20.0]
step = 1e-4
output_every = 0.05
[[events]]
quantity = "tip_x"
value = 0.0
direction = "rising"
"""


@pytest.fixture
def toml(tmp_path: Path) -> Path:
    """A scene of which a run takes some seconds."""
    file = tmp_path / "swing.toml"
    file.write_text(TOML)
    return file


@pytest.fixture
def swing(toml: Path) -> Scene:
    return Scene.from_toml(toml)


def _stop(t: float) -> None:
    raise KeyboardInterrupt


@pytest.mark.nightly
@pytest.mark.parametrize("method", ["dop853", "radau", "gauss", "rk4"])
def test_a_killed_run_goes_on_to_the_same_bits(
    tmp_path: Path, toml: Path, swing: Scene, method: str
) -> None:
    """SIGKILL at random moments, again and again, until it comes to its end."""
    model = rodgen.build(swing, "c")
    whole = rodgen.simulate(swing, model=model, method=method, out=tmp_path / "whole.nc")
    file = tmp_path / "killed.nc"
    moments = random.Random(method)
    process = subprocess.Popen([sys.executable, "-c", RUN, str(toml), method, str(file)])
    while not file.exists():
        assert process.poll() is None
        time.sleep(0.01)
    time.sleep(moments.uniform(0.0, 0.15))
    process.send_signal(signal.SIGKILL)
    process.wait()
    part = rodgen.load(file)
    if part.status == "interrupted":  # killed before its end
        assert "killed after" in part.message or len(part.t) == 0
        assert len(part.t) <= len(whole.t)
        same = whole.y[: len(part.t)].tobytes() == part.y.tobytes()
        assert same
        rodgen.resume(file)
    sol = rodgen.load(file)
    assert sol.status == "finished"
    assert sol.y.tobytes() == whole.y.tobytes()
    assert all(sol.work[term].tobytes() == whole.work[term].tobytes() for term in whole.work)
    assert [(e.t, e.y.tobytes()) for e in sol.events] == [
        (e.t, e.y.tobytes()) for e in whole.events
    ]
    assert sol.stats.steps == whole.stats.steps
    assert sol.stats.rhs == whole.stats.rhs


def test_an_interrupted_run_goes_on(tmp_path: Path, swing: Scene) -> None:
    """Ctrl-C as a callback sends it, at a time in the middle of a stretch."""
    file = tmp_path / "run.nc"

    how = {"target": "c", "method": "rk4", "step": 2e-4}
    with pytest.raises(rodgen.Interrupted) as caught:
        rodgen.simulate(swing, out=file, checkpoint=60.0, progress=_stop, **how)
    assert caught.value.solution.t[-1] < SPAN
    sol = rodgen.resume(file)
    assert sol.y.tobytes() == rodgen.simulate(swing, **how).y.tobytes()
    with pytest.raises(SceneError, match="is finished"):
        rodgen.resume(file)


def test_methods_in_python_start_again(tmp_path: Path, swing: Scene) -> None:
    scene = swing.with_integrate(span=[0.0, 1.5], method="rk45", rtol=1e-6)

    file = tmp_path / "run.nc"
    with pytest.raises(rodgen.Interrupted):
        rodgen.simulate(scene, target="numpy", out=file, checkpoint=60.0, progress=_stop)
    sol = rodgen.resume(file)
    whole = rodgen.simulate(scene, target="numpy")
    np.testing.assert_array_equal(sol.y, whole.y)


def test_streamed_and_kept_results_are_the_same(tmp_path: Path, missile: Scene) -> None:
    for target, method in (("c", "dop853"), ("numpy", "rk45")):
        kept = rodgen.simulate(missile, target=target, method=method, output_every=1e-3)
        rodgen.simulate(
            missile, target=target, method=method, output_every=1e-3, out=tmp_path / "a.nc"
        )
        streamed = rodgen.load(tmp_path / "a.nc")
        assert streamed.y.tobytes() == kept.y.tobytes()
        for term, work in kept.work.items():
            # In Python, work is added up in blocks that end where samples are written.
            np.testing.assert_allclose(streamed.work[term], work, rtol=1e-13, atol=1e-12)


def test_senseless_checkpoints_are_refused(missile: Scene, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="given with out"):
        rodgen.simulate(missile, checkpoint=1.0)
    with pytest.raises(SceneError, match="positive number"):
        rodgen.simulate(missile, out=tmp_path / "a.nc", checkpoint=-1.0)


def test_damaged_checkpoint_is_refused(missile: Scene, tmp_path: Path) -> None:
    file, beside = tmp_path / "a.nc", tmp_path / "a.nc.checkpoint"

    slow = missile.with_integrate(method="rk4", step=1e-6)
    with pytest.raises(rodgen.Interrupted):
        rodgen.simulate(slow, target="c", out=file, checkpoint=9.0, progress=_stop)
    beside.write_bytes(beside.read_bytes()[:-10] + b"0123456789")
    with pytest.raises(SceneError, match="checkpoint"):
        rodgen.resume(file)


def _interrupt(delay: float) -> None:
    """Ctrl-C so long after a run has begun; before, Python may raise it in any finaliser."""
    end = time.monotonic() + 60.0
    while signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        assert time.monotonic() < end, "no run begins"
        time.sleep(1e-4)
    time.sleep(delay)
    os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.nightly
@pytest.mark.parametrize("method", ["rk4", "dop853", "gauss"])
def test_ctrl_c_at_any_moment_loses_nothing(tmp_path: Path, swing: Scene, method: str) -> None:
    """Real signals at random moments, of which most fall into compiled steps."""
    accuracy = {"step": 2e-4} if method == "rk4" else {"rtol": 1e-12, "atol": 1e-13}
    scene = swing.with_integrate(method=method, **accuracy)
    model = rodgen.build(scene, "c")
    whole = rodgen.simulate(scene, model=model)
    moments = random.Random(method)
    stopped = 0
    for trial in range(3):
        file = tmp_path / f"run{trial}.nc"
        timer = threading.Thread(target=_interrupt, args=(moments.uniform(0.0, 0.2),))
        timer.start()
        try:
            rodgen.simulate(scene, model=model, out=file, checkpoint=0.05)
            timer.join()
        except KeyboardInterrupt:  # perhaps just after the end of the run
            pass
        if rodgen.load(file).status == "interrupted":
            stopped += 1
            rodgen.resume(file)
        sol = rodgen.load(file)
        assert sol.t.tobytes() == whole.t.tobytes()
        assert sol.y.tobytes() == whole.y.tobytes()
        assert [event.t for event in sol.events] == [event.t for event in whole.events]
    assert stopped > 0


@pytest.mark.parametrize("call", [1, 2])
def test_ctrl_c_while_a_run_is_set_up_leaves_one_to_go_on_with(
    tmp_path: Path, missile: Scene, monkeypatch: pytest.MonkeyPatch, call: int
) -> None:
    """While its file is made, and between that and the first step."""
    scene = missile.with_integrate(method="rk4", step=1e-5)
    model = rodgen.build(scene, "c")
    whole = rodgen.simulate(scene, model=model)
    calls = iter(range(1, 100))
    parameters = model.parameters

    def interrupting(**given: object) -> object:
        if next(calls) == call:
            signal.raise_signal(signal.SIGINT)
        return parameters(**given)

    monkeypatch.setattr(model, "parameters", interrupting)
    file = tmp_path / "a.nc"
    with pytest.raises(rodgen.Interrupted):
        rodgen.simulate(scene, model=model, out=file)
    assert rodgen.load(file).status == "interrupted"
    rodgen.resume(file)
    assert rodgen.load(file).y.tobytes() == whole.y.tobytes()


def test_ctrl_c_that_comes_too_late_for_the_run_is_not_lost(
    tmp_path: Path, missile: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    finish = Saver.finish

    def interrupted(self: Saver, *given: object) -> object:
        signal.raise_signal(signal.SIGINT)
        return finish(self, *given)

    monkeypatch.setattr(Saver, "finish", interrupted)
    with pytest.raises(KeyboardInterrupt):
        rodgen.simulate(missile, target="c", out=tmp_path / "a.nc")
    assert rodgen.load(tmp_path / "a.nc").status == "finished"


def test_long_results_are_thinned_honestly(tmp_path: Path, missile: Scene) -> None:
    scene = missile.with_integrate(output_every=2e-5)
    whole = rodgen.simulate(scene, target="c")
    part = rodgen.simulate(scene, target="c", out=tmp_path / "a.nc")
    assert len(whole.t) == 50001
    assert len(part.t) == 20000
    assert part.t[0] == 0.0
    assert part.t[-1] == 1.0
    assert part.energy_error == pytest.approx(whole.energy_error, rel=1e-3)
