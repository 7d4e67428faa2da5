"""Ctrl-C in commands that take long: each shows on a terminal how far it is, and ends at once in
one line, with nothing begun left behind."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from select import select
from typing import Any

import psutil
import pytest

import rodgen
from rodgen.studies.study import Study
from tests.cli.conftest import Write, python
from tests.sets import sets

FORCE, DAMPING = "loads.follower.force", "loads.internal_damping.coefficient"
# The column of other tests, flexible enough to flutter.
SCENE = """
[loads.follower]
force = 20.0
[loads.internal_damping]
coefficient = 0.01
[initial]
phi = "0.2*s"
[integrate]
span = SPAN
max_steps = 1000000000
output_every = 100.0
"""
ALONG = ("--vary", FORCE)
# Of every command that can take long: its arguments, and what is seen when it is interrupted.
COMMANDS: dict[str, tuple[tuple[Any, ...], str]] = {
    "run": ((), "t = "),
    "view": (("--export", "page"), "t = "),
    "derive": ((40,), "comparing"),
    "check": ((), "comparing"),
    "show": (("--set", "rod.links=60"), "generating"),
    "animate": (("--out", "film.gif", "--speed", 0.001), "t = "),
    "static --all": (("--set", "rod.links=100", "--set", "loads.tip.x=-300"), "looking"),
    "modes": (("--set", "rod.links=1200", "--count", 1200), "eigenvalues"),
    "critical": (("--simulate", 3e3), "simulating"),
    "branch": ((*ALONG, "--bounds", "0,10", "--step", 1e-6), FORCE),
    "boundary": (("--vary", f"{FORCE},{DAMPING}", "--step", 1e-6), "following"),
    "exponents": ((), "t = "),
    "cycle": ((), "t = "),
    "cycle-branch": ((*ALONG, "--bounds", "5,40", "--step", 1e-6), FORCE),
    "precision": (("--seconds", 1000), "measuring"),
    "study": (("--workers", 1), "points"),
    "study 2": (("--workers", 2), "points"),
}
SECONDS = 10.0  # on a busy machine; on another it takes one or two
LIMIT = 120.0  # until there is something to be seen
STUDY = """
name = "sweep"
scene = "rod.toml"
[vary]
"loads.follower.force" = {bounds = [1.0, 2.0], count = 1000}
[compute]
analysis = "run"
keep = ["last(tip_y)"]
"""

# Stages of all kinds: a run, a derivation, what a command follows, processes of its own.
SOME = ("run", "derive", "branch", "cycle", "study 2")

pytestmark = pytest.mark.usefixtures("work")


def _given(command: str, column: Write) -> tuple[Any, ...]:
    """The words of a command, with what it reads."""
    name, *more = command.split()
    span = "[0.0, 100.0]" if name == "study" else "[0.0, 1e6]"
    scene = column(SCENE.replace("SPAN", span), length=1.0, mass=1.0, bending_stiffness=1.0)
    words, _ = COMMANDS[command]
    if name == "study":
        file = scene.with_name("sweep.toml")
        file.write_text(STUDY, encoding="utf-8")
        Study.from_toml(file)  # it is none that is refused
        return name, file, *words
    if name == "derive":
        return name, *words
    if name == "check":
        texts = rodgen.loading.sources(rodgen.Structure(400, "clamped"))
        ((module, text),) = texts.items()
        Path(module).write_text(text, encoding="utf-8")
        return name, module
    if name == "animate":
        short = rodgen.Scene.from_toml(scene).with_integrate(span=(0, 1), output_every=0.01)
        rodgen.simulate(short, progress=False).save("run.nc")
        return name, "run.nc", *words
    return name, scene, *(one for one in more if one == "--all"), *words


@pytest.mark.parametrize("command", sets((), slow=SOME, nightly=COMMANDS))
def test_ctrl_c_in_a_terminal(
    command: str, column: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given, seen = _given(command, column), COMMANDS[command][1]
    before = {path.name for path in Path().iterdir()}
    if given[0] in ("derive", "show"):  # is what takes long
        monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "empty"))
    terminal, end = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "rodgen", *map(str, given)],
        stdout=subprocess.DEVNULL,
        stderr=end,
        start_new_session=True,
        # A test runner in the background ignores SIGINT, and its children would too.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    os.close(end)
    try:
        _read(terminal, seen, LIMIT)
        start = time.monotonic()
        os.killpg(process.pid, signal.SIGINT)
        said = _read(terminal, None, LIMIT)
        process.wait()
        assert time.monotonic() - start < SECONDS, said
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        os.close(terminal)
    assert process.returncode == 130, said
    assert said.count("rodgen: ") == 1 + (given[0] == "run"), said  # which says that it writes
    assert "Traceback" not in said
    while left := _group(process.pid):
        assert time.monotonic() < start + SECONDS, left
        time.sleep(0.01)
    if given[0] not in ("run", "branch", "boundary", "study") and "--vary" not in given:
        assert {path.name for path in Path().iterdir()} == before


def _group(number: int) -> list[psutil.Process]:
    """Who runs in a process group."""
    found = []
    for one in psutil.process_iter():
        with suppress(ProcessLookupError, psutil.NoSuchProcess):
            if os.getpgid(one.pid) == number and one.status() != psutil.STATUS_ZOMBIE:
                found.append(one)
    return found


def _read(terminal: int, until: str | None, limit: float) -> str:
    """What comes from a terminal until it has a text, or to its end."""
    text, last = "", time.monotonic() + limit
    while until is None or until not in text:
        ready, _, _ = select([terminal], [], [], max(0.0, last - time.monotonic()))
        assert ready, text
        try:
            got = os.read(terminal, 1 << 16)
        except OSError:  # as Linux tells the end of it
            got = b""
        if not got:
            assert until is None, text
            break
        text += got.decode(errors="replace")
    return text


AT_WORK = """
import signal, time, numpy as np, rodgen.cli, rodgen.cli.app
from pathlib import Path
from threading import Timer
from rodgen.cli.result_folders import output_folder
from rodgen.cli.exits import call_at_end
matrix = np.random.default_rng(0).standard_normal((3000, 3000))
def command(**_):
    with output_folder(Path("results/rod")), call_at_end(lambda: "; 7"):
        Timer(1.0, signal.raise_signal, [signal.SIGINT]).start()
        np.linalg.eig(matrix)
rodgen.cli.app.make_app = lambda *_: command
rodgen.cli.main()
"""
CLEANING = """
import signal, time, rodgen.cli, rodgen.cli.app
def command(**_):
    try:
        signal.raise_signal(signal.SIGINT)
    finally:
        time.sleep(2)
        print("cleaned", flush=True)
rodgen.cli.app.make_app = lambda *_: command
rodgen.cli.main()
"""
HOLDING = """
import signal, time, rodgen.cli, rodgen.cli.app
from rodgen.native.library import DeferredInterrupt
def command(**_):
    end = time.monotonic() + 2
    try:
        with DeferredInterrupt():
            signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        pass
    while time.monotonic() < end:
        pass
    print("went on", flush=True)
rodgen.cli.app.make_app = lambda *_: command
rodgen.cli.main()
"""


@pytest.mark.slow
def test_ctrl_c_ends_a_library_at_work() -> None:
    """LAPACK, for example, which hears nothing; folders are taken away, and what is kept is
    said."""
    start = time.monotonic()
    done = python(AT_WORK)
    assert time.monotonic() - start < 10.0  # the eigenvalues take a minute
    assert (done.returncode, done.stderr.count("\n")) == (130, 1), done.stderr
    assert done.stderr.strip().endswith("; 7")
    assert not Path("results").exists()


@pytest.mark.slow
def test_ctrl_c_leaves_time_to_what_has_heard_it() -> None:
    done = python(CLEANING)
    assert (done.returncode, done.stdout) == (130, "cleaned\n"), done.stderr
    held = python(HOLDING)  # by whom it was not left to the program
    assert (held.returncode, held.stdout) == (0, "went on\n"), held.stderr
    assert done.stderr.count("\n") == 1
