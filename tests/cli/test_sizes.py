"""Commands at sizes beyond what they can do are refused in a line, before they cost time or memory;
and what they can do they do in the memory that they say."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rodgen.scene.structure import MOST_LINKS
from tests.cli.conftest import Run, Write
from tests.sets import sets
from tests.told import numbers

FORCE, TIP = "loads.follower.force", "loads.tip.x"
LOADS = """
[loads.follower]
force = 5.0
[loads.internal_damping]
coefficient = 0.01
[loads.tip]
x = -0.1
[integrate]
span = [0.0, 0.001]
output_every = 0.001
"""
SMALL = 0.4  # GB that may be taken
OWN = 0.25e9  # bytes of Python with its libraries, and room to spare
VARIED = ("--vary", TIP, "--from", 0, "--to", -0.2, "--most", 4)
BOTH = ("--vary", f"{FORCE},{TIP}", "--a", "0:30", "--b=-1:1", "--most", 2)
# Of each command that can ask for too much: its arguments, and whether it can do what it says in a
# test: others take minutes.
COMMANDS: dict[str, tuple[tuple[Any, ...], bool]] = {
    "run": (("--output-every", 1e-8), False),
    "static": ((), True),
    "static all": (("--all",), False),
    "modes": ((), True),
    "modes many": (("--count", 100_000), False),
    "critical": (("--set", "loads.internal_damping="), True),
    "branch": (VARIED, True),
    "branch motion": ((*VARIED, "--motion", "initial"), False),
    "boundary": (BOTH, True),
    "exponents": ((), False),
    "exponents some": (("--count", 3), False),
    "cycle": ((), False),
    "cycle branch": (("--vary", FORCE, "--between", "1,2"), False),
    "cycle mode": (("--mode", 1, "--energy", 1.0), False),
    "precision": ((), False),
}
QUICK = ("critical", "modes many")

pytestmark = pytest.mark.usefixtures("work")


class Cost(NamedTuple):
    """What a process has taken: seconds of a processor, and bytes of memory at most."""

    done: subprocess.CompletedProcess[str]
    seconds: float
    memory: float


def measured(*words: Any, links: int, limit: float = SMALL) -> Cost:
    """A command in a process of its own, with so many links."""
    env = {**os.environ, "RODGEN_MEMORY": str(limit)}
    more = ("--set", f"rod.links={links}", "--no-pictures")
    command = [sys.executable, "-m", "rodgen", *map(str, (*words, *more))]
    with subprocess.Popen(
        command, env=env, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        out, err = process.communicate(timeout=600)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.CompletedProcess(command, process.returncode, out, err)
    return Cost(done, used.ru_utime + used.ru_stime, 1024.0 * used.ru_maxrss)


def _most(rodgen: Run, scene: Path, command: str, monkeypatch: pytest.MonkeyPatch) -> int:
    """How many links a command says that it can do."""
    monkeypatch.setenv("RODGEN_MEMORY", str(SMALL))
    name, *_ = command.split()
    done = rodgen(name, scene, *COMMANDS[command][0], "--set", f"rod.links={MOST_LINKS}")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert "rod.links" in done.stderr
    most = int(numbers(done.stderr.partition("must be")[2])[0])
    assert 10 < most < MOST_LINKS
    return most


@pytest.mark.parametrize("command", sets(QUICK, slow=[one for one in COMMANDS if one not in QUICK]))
def test_ten_times_too_much_is_one_line(
    rodgen: Run, write: Write, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    """In 2 s of a processor, and less memory than it may take."""
    boundary = "free" if "motion" in command else "clamped"
    loads = LOADS.replace("[loads.tip]\nx = -0.1\n", "") if boundary == "free" else LOADS
    scene = write(loads, 5, boundary)
    links = min(10 * _most(rodgen, scene, command, monkeypatch), MOST_LINKS)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    cost = measured(command.split()[0], scene, *COMMANDS[command][0], links=links)
    seconds = cost.seconds - before.ru_utime - before.ru_stime
    assert (cost.done.returncode, cost.done.stdout) == (2, ""), cost.done.stderr
    assert cost.done.stderr.count("\n") == 1
    assert seconds < 4.0  # twice, on a busy machine
    assert not list(Path("results").glob("*/*"))
    # Of all children so far, which are such commands.
    assert cost.memory < 0.5e9


@pytest.mark.nightly
@pytest.mark.parametrize("command", [one for one, (_, can) in COMMANDS.items() if can])
def test_what_is_said_to_fit_does(
    rodgen: Run, write: Write, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    """Somewhat less than the most links that are allowed."""
    scene = write(LOADS, 5)
    most = _most(rodgen, scene, command, monkeypatch)
    program = (
        "import resource, subprocess, sys\n"
        "done = subprocess.run(sys.argv[1:], capture_output=True, text=True)\n"
        "print(done.returncode, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)\n"
        "print(done.stderr)"
    )
    words = (command, scene, *COMMANDS[command][0], "--set", f"rod.links={most}", "--no-pictures")
    child = [sys.executable, "-m", "rodgen", *map(str, words)]
    done = subprocess.run(
        [sys.executable, "-c", program, *child], capture_output=True, text=True, check=True
    )
    first, *said = done.stdout.splitlines()
    status, memory = map(int, first.split())
    assert status in (0, 3), said  # 3: of so few points
    assert 1024.0 * memory < SMALL * 1e9 + OWN, f"{memory / 1e6:.3g} GB with {most} links"


def test_a_limit_is_a_number(refused: Run, write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    for text in ("much", "-1", "nan", "0"):
        monkeypatch.setenv("RODGEN_MEMORY", text)
        refused("modes", write(LOADS, 5), field="RODGEN_MEMORY")
