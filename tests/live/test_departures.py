"""Pages that are loaded again, cut off or closed: what is kept, and what ends with them."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.live.conftest import runs
from tests.live.view import View, expect, until

pytestmark = pytest.mark.nightly
# Whether a run is there: where it is not, its WebSocket is closed with 4404.
PROBE = """address => new Promise(resolve => {
    const socket = new WebSocket(address);
    socket.onclose = event => resolve(event.code);
    socket.onmessage = () => socket.close(4000);
})"""


def test_closed_page_frees_its_run(server: Any, another: Callable[[], View]) -> None:
    first, second = another().open(server.address).run(), another()
    asked: list[str] = []
    second.page.on("websocket", lambda socket: asked.append(socket.url))
    second.open(server.address)
    (address,) = {url for url in asked if "/live/channel/" in url}
    second.page.close()
    # Whoever asks is a page that comes, after which the run is kept for a while: each time it is
    # left in peace for longer.
    for wait in range(1, 6):
        first.page.wait_for_timeout(9000 * wait)
        if first.page.evaluate(PROBE, address) == 4404:
            break
    else:
        raise AssertionError("the run goes on")
    first.sees("live.t > given", first.live("live.t"))


def programs(folder: Path, monkeypatch: pytest.MonkeyPatch, **texts: str) -> None:
    """Scripts by their names, before all other programs."""
    folder.mkdir()
    for name, text in texts.items():
        (folder / name).write_text(f"#!/bin/sh\n{text}\n")
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")


@pytest.mark.compiler
@pytest.mark.parametrize("done", [False, True])
def test_page_closed_while_its_module_is_made(
    serve: Callable[..., Any],
    another: Callable[[], View],
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    done: bool,
) -> None:
    """Its compiler ends before it is done; done: or is done just then, and nothing goes wrong."""
    if not Path("/proc/self/task").exists():
        pytest.skip("the compiler's process is found in /proc, which this system lacks")
    started, free = tmp_path / "started", tmp_path / "free"
    wait = f"echo $$ > {started}; while [ ! -e {free} ]; do sleep 0.1; done"
    programs(tmp_path / "bin", monkeypatch, waits=f'{wait}; exec cc "$@"')
    monkeypatch.setenv("CC", str(tmp_path / "bin" / "waits"))
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))
    served = serve(folder / "dart.toml", reconnect=8.0)
    page = another().page
    page.goto(served.address)
    compiler = int(until(lambda: started.exists() and started.read_text(), bool, "no compiler"))
    mine = Path(f"/proc/{served.process.pid}/task/{served.process.pid}/children")
    page.close()
    if done:
        free.touch()
    until(mine.read_text, "", "the process goes on")
    until(lambda: runs(compiler), False, "the compiler goes on")


@pytest.mark.parametrize("ends", ["page", "server"])
def test_film_ends_with_its_page_and_with_its_server(
    serve: Callable[..., Any],
    another: Callable[[], View],
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    ends: str,
) -> None:
    """One of a quarter of an hour, by an ffmpeg that takes ten seconds for each frame."""
    temporary, begun = tmp_path / "tmp", tmp_path / "begun"
    temporary.mkdir()
    frames = f"while [ $(head -c {1280 * 720 * 4} | wc -c) -gt 0 ]; do sleep 10; done"
    programs(tmp_path / "bin", monkeypatch, ffmpeg=f"touch {begun}; {frames}")
    monkeypatch.setenv("TMPDIR", str(temporary))
    served = serve(folder / "dart.toml", reconnect=8.0)
    view = another().open(served.address).pause_after(3.0)
    view.tab("Save").button("Animation as MP4").click()
    until(begun.exists, True, "no film is begun")
    if ends == "page":
        view.page.close()
    else:
        served.end()
    until(lambda: list(temporary.glob("rodgen-*")), [], "the film goes on")


GROUND = "getComputedStyle(document.body).backgroundColor"


def test_two_pages_have_their_own_runs_and_reload_keeps_them(
    server: Any, another: Callable[..., View]
) -> None:
    """With view, panel and shade as they were; what differs from the file is marked, and in a link
    to it."""
    view, other = (another(apart=True).open(server.address) for _ in range(2))
    first = view.page.evaluate(GROUND)
    view.button("Light or dark").click()
    view.page.wait_for_function(f"first => {GROUND} !== first", arg=first)
    dark = view.page.evaluate(GROUND)
    view.fill("mass M", "4")
    view.shows("mass", 4.0).pause_after(0.2).line().press("PageDown")
    t = view.sees("live.past")
    view.tab("Save").button("Link to what").click()
    expect(view.field("link")).to_have_value(re.compile("scene="))
    view.page.reload()
    view.ready().shows("mass", 4.0)
    assert view.live("live.t") == t
    expect(view.page.get_by_role("tab", name="Save", selected=True)).to_be_visible()
    assert view.page.evaluate(GROUND) == dark
    assert other.live("[live.t, number(live.texts.mass)]") == [0.0, 3.0]


def test_page_that_was_cut_off_shows_what_is(server: Any, blank: View) -> None:
    """Its run has gone on meanwhile, and its buttons do what they say."""
    ends: list[Any] = []

    def passes(socket: Any) -> None:
        ends.extend((socket, socket.connect_to_server()))

    blank.page.route_web_socket("**", passes)
    blank.open(server.address).run()
    t = blank.live("live.t")
    for end in ends.copy():
        end.close()
    blank.sees("!live.connected")
    blank.sees("live.connected && live.t > given", t)
    blank.pause()
    blank.fill("mass M", "4")
    blank.shows("mass", 4.0)
