"""rodgen run and show: methods, events, checkpoints, warnings."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import rodgen as package

Run = Callable[..., subprocess.CompletedProcess[str]]

SWING = """
name = "swing"
[rod]
links = 8
length = 2.0
bending_stiffness = 20.0
mass = 4.0
boundary = "pinned"
[loads.gravity]
[initial]
phi = "-1.2 + 0.5*s"
[integrate]
span = [0.0, 2.0]
output_every = 0.05
[[events]]
quantity = "tip_x"
value = 0.0
name = "through the middle"
"""


@pytest.fixture
def swing(tmp_path: Path) -> Path:
    path = tmp_path / "swing.toml"
    path.write_text(SWING, encoding="utf-8")
    return path


def test_show_prints_the_choice_with_its_reason(rodgen: Run, swing: Path) -> None:
    done = rodgen("show", swing, env={"COLUMNS": "200"})
    assert done.returncode == 0, done.stderr
    assert "integrated by dop853: the fastest motion (" in done.stdout
    assert "few enough to follow" in done.stdout
    assert "event 'through the middle'" in done.stdout


def test_run_tells_of_events_and_keeps_them(rodgen: Run, swing: Path, tmp_path: Path) -> None:
    done = rodgen("run", swing, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "Events: through the middle at t = " in done.stdout
    sol = package.load(tmp_path / "swing" / "solution.nc")
    assert sol.events
    assert sol.scene.integrate.method == "dop853"
    assert not (tmp_path / "swing" / "solution.nc.checkpoint").exists()


def test_unstable_step_is_warned_of_and_exits_3(rodgen: Run, swing: Path, tmp_path: Path) -> None:
    done = rodgen("run", swing, "--method", "rk4", "--step", 0.05, "--out", tmp_path)
    assert done.returncode == 3
    assert "rodgen: warning: the step of 0.05 s is beyond" in done.stderr
    assert "try a smaller step" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.compiler
def test_killed_run_is_resumed_to_the_same_bits(rodgen: Run, swing: Path, tmp_path: Path) -> None:
    long = swing.read_text(encoding="utf-8").replace("2.0]", "400.0]")
    swing.write_text(long, encoding="utf-8")
    steps = ("--method", "rk4", "--step", "5e-5")
    whole = tmp_path / "whole"
    assert rodgen("run", swing, *steps, "--out", whole).returncode == 0
    part = tmp_path / "part"
    program = "from rodgen.cli import main; main()"
    arguments = ["run", swing, *steps, "--out", part, "--checkpoint", "0.1"]
    command = [sys.executable, "-c", program, *map(str, arguments)]
    file = part / "swing" / "solution.nc"
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        deadline = time.monotonic() + 60
        while not file.exists() and time.monotonic() < deadline:
            time.sleep(0.02)
        time.sleep(0.5)
        process.send_signal(signal.SIGKILL)
    killed = package.load(file)
    assert killed.status == "interrupted"
    assert "--resume continues it" in killed.message
    done = rodgen("run", swing, *steps, "--out", part, "--resume")
    assert done.returncode == 0, done.stderr
    a, b = (package.load(folder / "swing" / "solution.nc") for folder in (whole, part))
    assert a.y.tobytes() == b.y.tobytes()
    assert [event.t for event in a.events] == [event.t for event in b.events]
    again = rodgen("run", swing, *steps, "--out", part, "--resume")
    assert again.returncode == 2
    assert "is finished" in again.stderr
    other = rodgen("run", swing, "--method", "rk4", "--step", "6e-5", "--out", part, "--resume")
    assert other.returncode == 2
    assert "changed" in other.stderr


def test_settings_of_a_run_are_given_on_the_command_line(
    rodgen: Run, swing: Path, tmp_path: Path
) -> None:
    given = ("--span", -0.5, 0.5, "--atol", 1e-7, "--rtol", 1e-6, "--output-every", 0.25)
    done = rodgen("run", swing, *given, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    sol = package.load(tmp_path / "swing" / "solution.nc")
    assert sol.t.tolist() == [-0.5, -0.25, 0.0, 0.25, 0.5]
    assert (sol.scene.integrate.rtol, sol.scene.integrate.atol) == (1e-6, 1e-7)
    for wrong, said in (
        (("--span", 1, 0), "integrate.span = [1.0, 0.0]: must be"),
        (("--method", "rk4", "--step", 0.01, "--atol", 1e-7), "--atol = 1e-07: must be absent"),
        (("--output-every", 0), "integrate.output_every"),
    ):
        done = rodgen("run", swing, *wrong, "--out", tmp_path / "none")
        assert done.returncode == 2
        assert said in done.stderr


def test_the_package_is_the_command_too() -> None:
    command = [sys.executable, "-m", "rodgen", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == package.__version__
