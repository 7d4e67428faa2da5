"""Several processes at one library, some of which are ended half way."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rodgen.native import library
from tests.generated.library.conftest import DECLARATIONS, REAL, SOURCE, Place, alive, until

LOAD = f"""
import signal, sys
from pathlib import Path
from rodgen.native.library import load_library
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background shell has it ignored
_, lib = load_library("rod", Path(sys.argv[1]), {DECLARATIONS!r})
print(lib.twice(21.0))
"""


def _start(place: Place) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", LOAD, str(place.folder)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.fixture
def slow(place: Place) -> Iterator[Path]:
    """A compiler that never ends; its process id is written to the file that is yielded."""
    pid = place.log.with_name("pid")
    place.compiler(f'echo $$ > "{pid}.part"; mv "{pid}.part" "{pid}"; exec sleep 1000')
    yield pid
    if pid.exists() and alive(int(pid.read_text())):
        os.kill(int(pid.read_text()), signal.SIGKILL)


@pytest.mark.parametrize(
    "damaged", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["empty", "damaged"]
)
def test_many_processes_at_once(damaged: bool, place: Place) -> None:
    place.compiler(f'sleep 0.3; exec {REAL} "$@"')
    if damaged:
        assert place.works()
        (library,) = place.cache.glob("*/rod.so")
        library.unlink()
        library.write_bytes(b"garbage")
    processes = [_start(place) for _ in range(3)]
    for process in processes:
        output, errors = process.communicate(timeout=120)
        assert (process.returncode, output, errors) == (0, "42.0\n", "")
    assert place.left() == [next(place.cache.iterdir()).name]
    before = len(place.built())
    assert place.works()
    assert len(place.built()) == before


def test_build_killed_half_way(place: Place, slow: Path) -> None:
    process = _start(place)
    until(slow.exists)
    process.kill()
    process.communicate(timeout=60)
    (left,) = place.cache.iterdir()
    place.patch.delenv("CC")
    assert place.works()
    assert left.exists()  # another process may still be at work there
    old = time.time() - 2 * 86400
    os.utime(left, (old, old))
    place.write(SOURCE + "\n")
    assert place.works()
    assert not left.exists()


def test_ctrl_c_ends_the_compiler_too(place: Place, slow: Path) -> None:
    process = _start(place)
    until(slow.exists)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert "KeyboardInterrupt" in errors
    until(lambda: not alive(int(slow.read_text())))
    assert place.left() == []


def test_ctrl_c_while_the_compiler_is_started(
    place: Place, slow: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It comes before anybody has been told of the process."""

    class Popen(subprocess.Popen[bytes]):
        def __init__(self, *arguments: Any, **settings: Any):
            super().__init__(*arguments, **settings)
            if settings.get("start_new_session") and "--version" not in arguments[0]:
                until(slow.exists)
                signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(library.subprocess, "Popen", Popen)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            place.load()
    finally:
        signal.signal(signal.SIGINT, before)
    until(lambda: not alive(int(slow.read_text())))
    assert place.left() == []


def test_source_changes_while_it_is_built(place: Place) -> None:
    """What is stored under the hash of a text is built from that text."""
    other = SOURCE.replace("2.0*x", "3.0*x")
    script = f"cat > '{place.folder}/rod.c' <<'END'\n{other}\nEND\n"
    place.compiler(f'{script}exec {REAL} "$@"')
    assert place.works()
    place.compiler()
    assert place.load().twice(21.0) == 63.0
    place.write()
    assert place.works()
