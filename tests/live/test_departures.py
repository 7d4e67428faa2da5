"""What ends when a page is closed, or the server: runs, compilers, films."""

from __future__ import annotations

import itertools
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.live.conftest import runs
from tests.live.view import PATIENT

SCENES = Path(__file__).parents[2] / "scenes"
# Whether a run is there: where it is not, its WebSocket is closed with 4404.
PROBE = """address => new Promise(resolve => {
    const socket = new WebSocket(address);
    socket.onclose = event => resolve(event.code);
    socket.onmessage = () => socket.close(4000);
})"""


@pytest.mark.nightly
def test_closed_page_frees_its_run(serve: Callable[..., Any], another: Callable[[], Any]) -> None:
    served = serve(str(SCENES / "hanging_chain.toml"), "--port", "0")
    first, second = another().open(served.address).run(), another()
    asked: list[str] = []
    second.page.on("websocket", lambda socket: asked.append(socket.url))
    second.open(served.address)
    (address,) = {url for url in asked if "/live/channel/" in url}
    second.page.close()
    waits = itertools.count(1)

    def left() -> int:
        """Whoever asks is a page that comes, after which the run is kept for a while: each time it
        is left in peace for longer."""
        first.page.wait_for_timeout(9000 * next(waits))
        return int(first.page.evaluate(PROBE, address))

    first.until(left, 4404, "the run goes on")
    first.passes(0.0)


class Waiting(NamedTuple):
    """A page without a run, as its module is being made by a compiler that waits: the id of that
    compiler's process, the file that it waits for, the processes that the server has begun, the
    page, and another one."""

    compiler: int
    free: Path
    begun: Callable[[], str]
    page: Any
    other: Any


@pytest.fixture
def waiting(
    serve: Callable[..., Any],
    another: Callable[[], Any],
    scene_file: Callable[..., Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Waiting:
    if not Path("/proc/self/task").exists():
        pytest.skip("the compiler's process is found in /proc, which this system lacks")
    started, free, script = tmp_path / "started", tmp_path / "free", tmp_path / "cc"
    wait = f"while [ ! -e {free} ]; do sleep 0.1; done"
    script.write_text(f'#!/bin/sh\necho $$ > {started}\n{wait}\nexec cc "$@"\n')
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))
    served = serve(str(scene_file(links=2)), "--port", "0", reconnect=8.0)
    page, other = another().page, another()
    page.goto(served.address)
    number = other.until(lambda: started.exists() and started.read_text(), bool, "no compiler")
    mine = Path(f"/proc/{served.process.pid}/task/{served.process.pid}/children")
    return Waiting(int(number), free, mine.read_text, page, other)


@pytest.mark.nightly
def test_page_closed_while_its_module_is_made(waiting: Waiting) -> None:
    """Its compiler ends before it is done."""
    waiting.page.close()
    waiting.other.until(waiting.begun, "", "the process goes on")
    waiting.other.until(lambda: runs(waiting.compiler), False, "the compiler goes on")


@pytest.mark.nightly
@pytest.mark.compiler
def test_page_closed_just_before_its_module_is_made(waiting: Waiting) -> None:
    """It might come back: nothing goes wrong as it is built without its browser (`serve` looks)."""
    waiting.page.close()
    waiting.free.touch()
    waiting.other.until(waiting.begun, "", "the process goes on")


@pytest.fixture
def long_film(
    serve: Callable[..., Any],
    another: Callable[[], Any],
    scene_file: Callable[..., Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> tuple[Any, Any, Path]:
    """A server, a page that is having a film made of at least 90 frames, and the folder in which
    that is done, by an ffmpeg that takes ten seconds for each of them."""
    folder, programs, begun = tmp_path / "tmp", tmp_path / "bin", tmp_path / "begun"
    folder.mkdir()
    programs.mkdir()
    frame = 1280 * 720 * 4
    script = f"touch {begun}; while [ $(head -c {frame} | wc -c) -gt 0 ]; do sleep 10; done"
    (programs / "ffmpeg").write_text(f"#!/bin/sh\n{script}\n")
    (programs / "ffmpeg").chmod(0o755)
    monkeypatch.setenv("PATH", f"{programs}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("TMPDIR", str(folder))
    served = serve(str(scene_file(links=2)), "--port", "0", reconnect=8.0)
    view = another().open(served.address).pause_after(3.0)
    view.tab("Save").button("Animation as MP4").click()
    view.until(begun.exists, True, "no film is begun")
    return served, view, folder


@pytest.mark.nightly
def test_ctrl_c_does_not_wait_for_a_film(long_film: tuple[Any, Any, Path]) -> None:
    served, _, folder = long_film
    served.process.send_signal(signal.SIGINT)
    served.process.wait(timeout=PATIENT)  # of a film of a quarter of an hour
    assert not list(folder.glob("rodgen-*"))


@pytest.mark.nightly
def test_closed_page_ends_its_film(long_film: tuple[Any, Any, Path], blank: Any) -> None:
    _, view, folder = long_film
    view.page.close()
    blank.until(lambda: list(folder.glob("rodgen-*")), [], "the film goes on")
