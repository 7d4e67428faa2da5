"""Commands at sizes beyond what they can do are refused in a line, before they cost time or memory;
and what they can do they do in the memory that they say."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import pytest

from rodgen.check.module_check import check_module
from rodgen.errors import InputError
from rodgen.scene.term_texts import MOST_LINKS
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
VARIED = ("--vary", TIP, "--bounds", "0,-0.2", "--max-points", 4)
BOTH = ("--vary", f"{FORCE},{TIP}", "--bounds", "0,30", "--bounds=-1,1", "--max-points", 2)
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
    "cycle-branch": (("--vary", FORCE, "--bounds", "1,2"), False),
    "nonlinear-mode": (("--mode", 1, "--energy", 1.0), False),
    "precision": ((), False),
    "show": ((), True),
}
QUICK = ("critical", "modes many")

pytestmark = pytest.mark.usefixtures("work")


# Runs a command, of which alone it is asked what memory its children took.
CHILD = """
import json, resource, subprocess, sys
done = subprocess.run(sys.argv[1:], capture_output=True, text=True)
used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
print(json.dumps([done.returncode, done.stdout, done.stderr, 1024.0 * used]))
"""


class Done(NamedTuple):
    """What a process has said, and the bytes of memory that it took at most."""

    status: int
    out: str
    err: str
    memory: float


def measured(*words: Any, links: int) -> Done:
    """A command in a process of its own, with so many links."""
    env = {**os.environ, "RODGEN_MEMORY": str(SMALL)}
    more = ("--set", f"rod.links={links}", *["--no-pictures"] * (words[0] != "show"))
    command = [sys.executable, "-m", "rodgen", *map(str, (*words, *more))]
    done = subprocess.run(
        [sys.executable, "-c", CHILD, *command], env=env, capture_output=True, text=True, check=True
    )
    return Done(*json.loads(done.stdout))


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
    """In less memory than it may take."""
    boundary = "free" if "motion" in command else "clamped"
    loads = LOADS.replace("[loads.tip]\nx = -0.1\n", "") if boundary == "free" else LOADS
    scene = write(loads, 5, boundary)
    links = min(10 * _most(rodgen, scene, command, monkeypatch), MOST_LINKS)
    done = measured(command.split()[0], scene, *COMMANDS[command][0], links=links)
    assert (done.status, done.out) == (2, ""), done.err
    assert done.err.count("\n") == 1
    assert not list(Path("results").glob("*/*"))
    assert done.memory < 0.5e9


@pytest.mark.nightly
@pytest.mark.parametrize("command", [one for one, (_, can) in COMMANDS.items() if can])
def test_what_is_said_to_fit_does(
    rodgen: Run, write: Write, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    """Somewhat less than the most links that are allowed."""
    scene = write(LOADS, 5)
    most = _most(rodgen, scene, command, monkeypatch)
    done = measured(command, scene, *COMMANDS[command][0], links=most)
    assert done.status in (0, 3), done.err  # 3: of so few points
    assert done.memory < SMALL * 1e9 + OWN, f"{done.memory / 1e9:.3g} GB with {most} links"


def test_a_module_with_too_many_links_is_not_compared() -> None:
    module = ModuleType("large")
    vars(module)["N"] = 1_000_000  # whose matrices have a million million numbers
    with pytest.raises(InputError) as info:
        next(check_module(module))
    assert info.value.field == "N"


def test_a_limit_is_a_number(refused: Run, write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    for text in ("much", "-1", "nan", "0"):
        monkeypatch.setenv("RODGEN_MEMORY", text)
        refused("modes", write(LOADS, 5), field="RODGEN_MEMORY")
