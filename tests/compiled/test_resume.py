"""Runs that are stopped and taken up again, to the same bits."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import rodgen
from rodgen import Scene
from rodgen.integrate.files.saver import Saver
from tests.told import refused

EVENT = {"quantity": "tip_x", "value": 2.0, "direction": "rising"}


@pytest.fixture
def stop(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Ctrl-C as a callback sends it, after the first steps, in the middle of a stretch."""
    monkeypatch.setattr(sys.modules["rodgen.integrate.simulate"], "TICK", -1.0)

    def told(t: float) -> None:
        raise KeyboardInterrupt

    return told


@pytest.mark.parametrize(
    ("target", "integrate"),
    [
        ("c", {"method": "rk4", "step": 1e-4}),
        *(("c", {"method": method, "rtol": 1e-12}) for method in ("dop853", "radau", "gauss")),
        # Methods in Python start again.
        ("numpy", {"method": "rk45", "rtol": 1e-6}),
    ],
)
def test_an_interrupted_run_goes_on(
    tmp_path: Path, missile: Scene, stop: Any, target: str, integrate: dict[str, Any]
) -> None:
    scene = missile.replace({"events": [EVENT]}).with_integrate(**integrate)
    whole, file = rodgen.simulate(scene, target=target), tmp_path / "a.nc"
    assert whole.events
    with pytest.raises(rodgen.Interrupted) as caught:
        rodgen.simulate(scene, target=target, out=file, checkpoint=60.0, progress=stop)
    assert 0 < len(caught.value.solution.t) < len(whole.t)
    sol = rodgen.resume(file)
    assert sol.y.tobytes() == whole.y.tobytes()
    assert all(sol.work[term].tobytes() == whole.work[term].tobytes() for term in whole.work)
    events = [[(e.t, e.y.tobytes()) for e in each.events] for each in (sol, whole)]
    assert events[0] == events[1]
    if target == "c":
        assert (sol.stats.nsteps, sol.stats.nfev) == (whole.stats.nsteps, whole.stats.nfev)
    assert refused(rodgen.resume, file).field


def test_checkpoints_that_cannot_be_are_refused(missile: Scene, tmp_path: Path, stop: Any) -> None:
    """Without a file, of no time, and one that was damaged."""
    assert refused(rodgen.simulate, missile, checkpoint=1.0)[:2] == ("checkpoint", 1.0)
    file, beside = tmp_path / "a.nc", tmp_path / "a.nc.checkpoint"
    told = refused(rodgen.simulate, missile, out=file, checkpoint=-1.0)
    assert told[:2] == ("checkpoint", -1.0)
    with pytest.raises(rodgen.Interrupted):
        rodgen.simulate(missile, target="c", out=file, checkpoint=9.0, progress=stop)
    beside.write_bytes(beside.read_bytes()[:-10] + b"0123456789")
    assert refused(rodgen.resume, file).field == "checkpoint"


@pytest.mark.parametrize("name", ["STATE", "Run"])
def test_ctrl_c_while_a_run_is_set_up_leaves_one_to_go_on_with(
    tmp_path: Path, missile: Scene, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """While its file is made, and between that and the first step."""
    scene = missile.with_integrate(method="rk4", step=1e-4)
    whole = rodgen.simulate(scene, target="c")
    model = Interrupting(whole.model, name)
    file = tmp_path / "a.nc"
    with pytest.raises(rodgen.Interrupted):
        rodgen.simulate(scene, model=model, out=file)
    assert rodgen.load(file).status == "interrupted"
    rodgen.resume(file)
    assert rodgen.load(file).y.tobytes() == whole.y.tobytes()


class Interrupting(ModuleType):
    """A module that interrupts whoever asks for one of its names."""

    def __init__(self, model: ModuleType, name: str):
        super().__init__(model.__name__)
        self.__dict__.update(_model=model, _name=name)

    def __getattr__(self, name: str) -> Any:
        if name == self._name:
            self.__dict__["_name"] = ""
            signal.raise_signal(signal.SIGINT)
        return getattr(self._model, name)


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
