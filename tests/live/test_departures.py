"""What ends when a page is closed, or the server: runs, compilers, films."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

SCENES = Path(__file__).parents[2] / "scenes"
# Whether a run is there: where it is not, its WebSocket is closed with 4404.
PROBE = """address => new Promise(resolve => {
    const socket = new WebSocket(address);
    socket.onclose = event => resolve(event.code);
    socket.onmessage = () => socket.close(4000);
})"""


@pytest.mark.long
def test_closed_page_frees_its_run(serve: Callable[..., Any], another: Callable[[], Any]) -> None:
    served = serve(str(SCENES / "hanging_chain.toml"), "--port", "0")
    first, second = another().open(served.address).run(), another()
    asked: list[str] = []
    second.page.on("websocket", lambda socket: asked.append(socket.url))
    second.open(served.address)
    (address,) = (url for url in asked if "/live/channel/" in url)
    second.page.close()

    def freed() -> bool:
        first.page.wait_for_timeout(9000)  # 7 s are kept for a reload, also after this asks
        return bool(first.page.evaluate(PROBE, address) == 4404)

    first.until(freed, "the run goes on")
    t = first.live("t")
    first.until(lambda: first.live("t") > t, "the other run has ended too")


@pytest.mark.long
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="children are found in /proc")
def test_page_closed_while_its_module_is_made(
    serve: Callable[..., Any],
    another: Callable[[], Any],
    scene_file: Callable[..., Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its compiler ends before it is done."""
    started, ended = tmp_path / "started", tmp_path / "ended"
    scene, script = scene_file(links=2), tmp_path / "cc"
    script.write_text(f"#!/bin/sh\ntouch {started}\nsleep 30\ntouch {ended}\nexit 1\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))
    served = serve(str(scene), "--port", "0")
    page, other = another().page, another()
    page.goto(served.address)
    other.until(started.exists, "no compiler")
    begun = time.monotonic()
    page.close()
    mine = f"/proc/{served.process.pid}/task/{served.process.pid}/children"
    other.until(lambda: not Path(mine).read_text(), "the process goes on", 25.0)
    assert time.monotonic() - begun < 20.0  # it would have taken 30 s
    other.page.wait_for_timeout(1000)
    assert not ended.exists()


@pytest.fixture
def long_film(
    serve: Callable[..., Any],
    another: Callable[[], Any],
    scene_file: Callable[..., Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> tuple[Any, Any, Path]:
    """A server, a page that is having a film made of at least 90 frames, and the folder in which
    that is done, by an ffmpeg that takes a second for each of them."""
    folder, programs, begun = tmp_path / "tmp", tmp_path / "bin", tmp_path / "begun"
    folder.mkdir()
    programs.mkdir()
    frame = 1280 * 720 * 4
    script = f"touch {begun}; while [ $(head -c {frame} | wc -c) -gt 0 ]; do sleep 1; done"
    (programs / "ffmpeg").write_text(f"#!/bin/sh\n{script}\n")
    (programs / "ffmpeg").chmod(0o755)
    monkeypatch.setenv("PATH", f"{programs}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("TMPDIR", str(folder))
    served = serve(str(scene_file(links=2)), "--port", "0")
    view = another().open(served.address).pause_after(3.0)
    view.tab("Save").button("Animation as MP4").click()
    view.until(begun.exists, "no film is begun")
    return served, view, folder


@pytest.mark.long
def test_ctrl_c_does_not_wait_for_a_film(long_film: tuple[Any, Any, Path]) -> None:
    served, _, folder = long_film
    served.process.send_signal(signal.SIGINT)
    served.process.wait(timeout=10.0)
    assert not list(folder.glob("rodgen-*"))


@pytest.mark.long
def test_closed_page_ends_its_film(long_film: tuple[Any, Any, Path], blank: Any) -> None:
    _, view, folder = long_film
    view.page.close()
    blank.until(lambda: not list(folder.glob("rodgen-*")), "the film goes on", 20.0)
