"""rodgen run: what it writes, replaces and says, and how signals end it."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Timer

import numpy as np
import pytest

import rodgen as package
from tests.cli.conftest import Run
from tests.told import numbers

PYTHON_ONLY = {"rod_free_n4_follower_gravity.py"}
C_ONLY = {f"rod_free_n4_follower_gravity_c.{ending}" for ending in ("py", "c", "h")}


def files(folder: Path, pattern: str = "rod_*") -> set[str]:
    """Names of modules, or of all files; those of modules with expressions without the letters of
    their hash."""
    return {re.sub(r"^(rod_.*)_[0-9a-f]{6}\.", r"\1.", path.name) for path in folder.glob(pattern)}


@pytest.fixture
def pictures() -> set[str]:
    """Names of the pictures of a run, for tests that have them drawn."""
    names = ("shape", "trajectory", "energy", "phase", "tail", "moment", "envelope")
    return {f"{name}.png" for name in names}


@pytest.fixture(autouse=True)
def _few_pictures(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """They take longer than most runs."""
    if "pictures" not in request.fixturenames:
        monkeypatch.setattr("rodgen.show.run_pictures.save_pictures", lambda *_: [])


# What is written -------------------------------------------------------------------------------


@pytest.mark.compiler
def test_run_writes_everything_and_says_so(
    works: Run, short: Path, tmp_path: Path, pictures: set[str]
) -> None:
    """And no traces beside it, or where the command was called."""
    work, folder = tmp_path / "work", tmp_path / "results" / "short"
    work.mkdir()
    done = works("run", short, "--out", folder.parent, cwd=work)
    assert list(work.iterdir()) == []
    assert files(folder, "*") == {"solution.nc", "summary.txt", "rodgen_native", *C_ONLY, *pictures}
    for picture in pictures:
        assert (folder / picture).read_bytes().startswith(b"\x89PNG")
    words = (folder / "summary.txt").read_text(encoding="utf-8")
    assert words in done.stdout
    sol = package.load(folder / "solution.nc")
    assert (sol.t[-1], sol.stats.target) == (0.3, "c")
    shown = numbers(words)
    (event,) = (event for event in sol.events if event.name == "low")
    for number in (0.3, event.t):
        assert min(abs(one - number) for one in shown) < 1e-3  # of some digits
    assert np.abs(sol.energy_balance).max() < 1e-6


@pytest.mark.compiler
def test_a_run_in_json_without_pictures_with_settings_of_the_command_line(
    works: Run, short: Path, tmp_path: Path
) -> None:
    given = ("--span", -0.5, 0.5, "--atol", 1e-7, "--rtol", 1e-6, "--output-every", 0.25)
    options = ("--set", "name=other", "--json", "--no-pictures", "--out", tmp_path)
    told = json.loads(works("run", short, *given, *options).stdout)
    run = package.load(tmp_path / "other" / "solution.nc")
    assert run.t.tolist() == [-0.5, -0.25, 0.0, 0.25, 0.5]
    assert (run.scene.integrate.rtol, run.scene.integrate.atol) == (1e-6, 1e-7)
    assert (told["end"], told["tip"]) == (0.5, run.tip[-1].tolist())
    assert told["energy_error"] == run.energy_error
    assert (told["samples"], told["nsteps"]) == (len(run.t), run.stats.nsteps)
    assert told["files"][:2] == ["solution.nc", "summary.txt"]
    assert not any(name.endswith(".png") for name in told["files"])
    assert {name.rstrip("/") for name in told["files"]} == {
        path.name for path in (tmp_path / "other").iterdir()
    }


def test_run_without_a_compiler(works: Run, rodgen: Run, short: Path, tmp_path: Path) -> None:
    """By NumPy, which is said with what is missing, unless C is wanted."""
    env = {"CC": "/nonexistent", "RODGEN_CACHE": str(tmp_path / "cache")}
    folder = tmp_path / "short"
    command = ("run", short, "--out", tmp_path)
    done = rodgen(*command, "--target", "c", env=env)
    assert (done.returncode, done.stdout) == (2, "")
    assert "/nonexistent" in done.stderr
    assert not folder.exists()
    assert works(*command, env=env).stderr == ""
    assert files(folder) == PYTHON_ONLY
    assert package.load(folder / "solution.nc").stats.target == "numpy"
    assert "CC=/nonexistent" in (folder / "summary.txt").read_text(encoding="utf-8")


def test_blow_up_exits_3_with_the_time_and_keeps_samples(
    rodgen: Run, short: Path, tmp_path: Path
) -> None:
    """Warned of before, as the step is beyond what is stable."""
    far = ("--method", "rk4", "--step", 0.05, "--span", 0, 50)
    done = rodgen("run", short, *far, "--out", tmp_path)
    assert done.returncode == 3
    warning, failure = done.stderr.splitlines()
    assert warning.startswith("rodgen: warning: ")
    assert 0.05 in numbers(warning)
    sol = package.load(tmp_path / "short" / "solution.nc")
    assert sol.status == "failed"
    assert 0 < sol.t[-1] < 50.0
    # It stopped behind the last sample that is kept, at most some steps.
    assert any(0 <= number - sol.t[-1] < 1 for number in numbers(failure))
    assert np.isfinite(sol.y).all()


@pytest.mark.slow
def test_numbers_at_the_limit_are_no_traceback(
    rodgen: Run, short: Path, tmp_path: Path, pictures: set[str]
) -> None:
    """With pictures of them."""
    for k, key in enumerate(("rod.length=1e-59", "initial.position=[1e60, -1e60]")):
        done = rodgen("run", short, "--set", key, "--out", tmp_path / str(k))
        assert done.returncode in (0, 3)
        assert (tmp_path / str(k) / "short" / "solution.nc").is_file()


# What was there before -------------------------------------------------------------------------


def test_what_is_replaced_is_said_where_it_is_another_thing(
    works: Run, refused: Run, short: Path, tmp_path: Path
) -> None:
    """The result of another scene of the name, or a file that is no result; not the result of the
    scene integrated otherwise."""
    command = ("run", short, "--target", "numpy", "--out", tmp_path)
    file = tmp_path / "short" / "solution.nc"
    works(*command)
    refused(*command, "--resume")
    assert works(*command, "--span", 0, 0.2).stderr == ""
    text = short.read_text()
    longer = text.replace("length = 1.0", "length = 2.0")
    named = f"{text.replace('t/0.1', 't/lag')}[parameters]\nlag = 0.1\n"
    for changed, field in ((longer, "rod.length"), (named, "parameters")):
        short.write_text(changed)
        (line,) = works(*command).stderr.splitlines()
        assert str(file) in line
        assert field in line
    file.write_text("notes of mine", encoding="utf-8")
    (line,) = works(*command).stderr.splitlines()
    assert str(file) in line


@pytest.mark.compiler
def test_module_of_an_earlier_run_is_taken_away(works: Run, short: Path, tmp_path: Path) -> None:
    """Of another structure or target; but not what is another's, by its name or by its text."""
    folder, numpy = tmp_path / "short", ("--target", "numpy")

    def run(*options: object, links: int = 4) -> set[str]:
        works("run", short, "--set", f"rod.links={links}", *options, "--out", tmp_path)
        return files(folder)

    assert run() == C_ONLY
    assert run(*numpy) == PYTHON_ONLY
    (folder / "rod_free_n9.py").write_text("mine = 1\n", encoding="utf-8")
    names = [f"rod_free_n{n}_follower_gravity.py" for n in (1, 2)]
    assert run(*numpy, links=1) == {names[0], "rod_free_n9.py"}
    for path in folder.glob("rod_free_n1_*"):
        path.write_text("mine = 1\n", encoding="utf-8")
    assert run(*numpy, links=2) == {*names, "rod_free_n9.py"}


# Signals ---------------------------------------------------------------------------------------

# A signal comes as soon as a second state is kept, whatever the machine does beside.
STOPPED = """
import os, signal, sys
from rodgen.integrate.files import saver
kept, left, sent = saver.write_checkpoint, [2], getattr(signal, sys.argv.pop(1))
def write(*given):
    kept(*given)
    left[0] -= 1
    if not left[0]:
        os.kill(os.getpid(), sent)
saver.write_checkpoint = write
from rodgen.cli import main
main()
"""
STEPS = ("--method", "rk4", "--step", "1e-4")


@contextmanager
def _started(program: str, *arguments: object) -> Iterator[subprocess.Popen[str]]:
    """A command that runs on, with Ctrl-C as in a terminal, and that does not outlive the test, or
    ten minutes."""
    process = subprocess.Popen(
        [sys.executable, "-c", program, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # A test runner in the background ignores SIGINT, and its children would too.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    too_long = Timer(600, process.kill)
    too_long.start()
    try:
        yield process
    finally:
        too_long.cancel()
        process.kill()
        process.communicate()


@pytest.mark.compiler
@pytest.mark.slow
def test_killed_run_is_resumed_to_the_same_bits(
    works: Run, refused: Run, short: Path, tmp_path: Path
) -> None:
    whole, part = tmp_path / "whole", tmp_path / "part"
    file = part / "short" / "solution.nc"
    works("run", short, *STEPS, "--out", whole)
    given = ("SIGKILL", "run", short, *STEPS, "--out", part, "--checkpoint", 1e-9)
    with _started(STOPPED, *given) as process:
        process.wait()
    assert (process.returncode, package.load(file).status) == (-signal.SIGKILL, "interrupted")
    refused("run", short, "--method", "rk4", "--step", "2e-4", "--out", part, "--resume")
    works("run", short, *STEPS, "--out", part, "--resume")
    assert not file.with_name("solution.nc.checkpoint").exists()
    a, b = (package.load(folder / "short" / "solution.nc") for folder in (whole, part))
    assert a.y.tobytes() == b.y.tobytes()
    assert [event.t for event in a.events] == [event.t for event in b.events]


@pytest.mark.compiler
@pytest.mark.slow
@pytest.mark.parametrize("impatient", [False, True])
def test_ctrl_c_keeps_what_was_computed(short: Path, tmp_path: Path, impatient: bool) -> None:
    """Also when it comes again, as the states are being written."""
    given = ("run", short, *STEPS, "--out", tmp_path, "--output-every", 1e-3)
    with _started(STOPPED, "SIGINT", *given, "--checkpoint", 1e-9) as process:
        assert process.stderr is not None
        (stopped,) = numbers(process.stderr.readline())  # it says when
        if impatient:
            process.send_signal(signal.SIGINT)
        errors = process.stderr.read()  # `communicate` loses what came with that line
        process.wait()
    assert process.returncode == 130, errors
    assert len(errors.splitlines()) == 1
    sol = package.load(tmp_path / "short" / "solution.nc")
    assert 1 < len(sol.t) < 301
    assert sol.t[-1] == pytest.approx(stopped, abs=1e-3)  # a sample is as long
    assert sol.energy_error < 1e-6  # J, of some tenths


FINALIZED = """
import signal, time, rodgen.cli, rodgen.cli.app
class Interrupted:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)
def command(**_):
    Interrupted()
    time.sleep(1000)
rodgen.cli.app.make_app = lambda *_: command
rodgen.cli.main()
"""


@pytest.mark.slow
def test_ctrl_c_ends_in_one_line_in_finalizers_and_imports(tmp_path: Path) -> None:
    """It is lost by neither: what a finalizer raises is not, and commands are imported last."""
    importing = "import sys, rodgen.cli; print('up', flush=True); rodgen.cli.main()"
    for program in (FINALIZED, importing):
        with _started(program, "derive", 40, "--out", tmp_path) as process:
            if program == importing:
                assert process.stdout is not None
                assert process.stdout.readline() == "up\n"
                time.sleep(0.05)
                process.send_signal(signal.SIGINT)
            _, errors = process.communicate()
        assert process.returncode == 130, errors
        assert errors.count("\n") == 1
    assert list(tmp_path.glob("*.py")) == []
