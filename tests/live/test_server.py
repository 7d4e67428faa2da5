"""The server as a process: addresses, tokens, ports, what a page may hand in, and how runs end."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

SCENES = Path(__file__).parents[2] / "scenes"
MISSILE = str(SCENES / "missile.toml")
COMMAND = (str(Path(sys.executable).with_name("rodgen")), "view")


def status(address: str, **headers: str) -> int:
    """Of a request for it."""
    request = urllib.request.Request(address, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=30) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        return error.code


def ended(*arguments: str) -> subprocess.CompletedProcess[str]:
    """A command that should end by itself."""
    return subprocess.run(
        [*COMMAND, *arguments, "--no-open"], capture_output=True, text=True, timeout=60
    )


def test_taken_port_is_named() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = ended(MISSILE, "--port", str(port))
    assert done.returncode == 2
    assert f"--port = {port}" in done.stderr
    assert "in use" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("nothing.toml",), "scene = 'nothing.toml'"),
        ((MISSILE, "--folder", "nowhere"), "--folder = 'nowhere'"),
        ((MISSILE, "--port", "70000"), "--port = 70000"),
        ((MISSILE, "--host", "256.1.1.1"), "--host = '256.1.1.1'"),
    ],
)
def test_bad_input_ends_in_a_line(arguments: tuple[str, ...], said: str) -> None:
    done = ended(*arguments)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr


def test_loopback_server_refuses_strangers(server: Any) -> None:
    assert status(server.address) == 200
    assert status(server.address, Host="evil.example") == 403
    assert status(server.address, Origin="http://evil.example") == 403
    for path in ("live/channel/x", "..%2f..%2fetc/passwd", "_nicegui/../../etc/passwd", "docs"):
        assert status(server.address + path) in (403, 404)


def test_token_opens_the_page_elsewhere(serve: Callable[..., Any], blank: Any) -> None:
    served = serve(MISSILE, "--host", "0.0.0.0", "--port", "0")
    address = served.address.replace("0.0.0.0", "127.0.0.1")
    place, _, token = address.partition("?token=")
    assert len(token) > 20
    assert status(place) == 403
    assert status(f"{place}?token=guess") == 403
    blank.open(address).run()
    blank.until(lambda: blank.live("t") > 0.2, "time does not pass")
    blank.page.goto(place)  # the token is kept by the browser
    blank.ready()


def threads(process: int) -> int:
    """Of a process, those of its runs among them."""
    return len(list(Path(f"/proc/{process}/task").iterdir()))


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="threads are counted in /proc")
def test_closed_page_frees_its_run(serve: Callable[..., Any], another: Callable[[], Any]) -> None:
    # Without thrust: the critical force would be computed in a thread that comes and goes.
    served = serve(str(SCENES / "hanging_chain.toml"), "--port", "0")
    first = another().open(served.address).run()
    first.until(lambda: first.live("t") > 0.2, "time does not pass")
    pages = [another() for _ in range(3)]
    before = threads(served.process.pid)
    for page in pages:
        page.open(served.address)
    first.until(lambda: threads(served.process.pid) >= before + 3, "runs have no threads")
    with_runs = threads(served.process.pid)
    for page in pages:
        page.page.close()
    start = time.monotonic()
    first.until(lambda: threads(served.process.pid) <= with_runs - 3, "runs are kept", 15.0)
    assert time.monotonic() - start < 10.0
    t = first.live("t")
    first.until(lambda: first.live("t") > t, "the other run has ended too")


def test_uploads_go_through_the_checks_of_files(view: Any, tmp_path: Path) -> None:
    good = (SCENES / "hanging_chain.toml").read_text()
    links = next(line for line in good.splitlines() if line.startswith("links"))
    good = good.replace(links, "links = 6")
    files = {
        "good": good,
        "evil": good.replace("phi", "phi = \"__import__('os').system('x')\" #", 1),
        "large": good + "#" * 2**20,
        "binary": "\x00\x01",
    }
    for name, text in files.items():
        (tmp_path / f"{name}.toml").write_text(text)
    view.tab("Scene")
    chooser = view.page.locator("input[type=file]")
    for name in ("evil", "large", "binary"):
        chooser.set_input_files(tmp_path / f"{name}.toml")
        note = view.page.locator(".q-notification").last
        note.wait_for()
        view.page.locator(".q-notification button").last.click()
        view.until(lambda: view.page.locator(".q-notification").count() == 0, "still said")
    view.tab("Values")
    assert view.text("links") == "20"
    view.tab("Scene")
    chooser.set_input_files(tmp_path / "good.toml")
    view.tab("Values")
    view.until(lambda: view.text("links") == "6", "not taken")


def test_page_answers_while_it_runs(view: Any) -> None:
    """A click reaches the run and comes back within 100 ms, of the best of some: others use the
    machine too."""
    view.run()
    took = []
    for name, other in (("Pause (", "Run ("), ("Run (", "Pause (")) * 5:
        took.append(
            view.page.evaluate(
                """async ([name, other]) => {
                    const find = n => [...document.querySelectorAll('button')]
                        .find(b => b.getAttribute('aria-label')?.startsWith(n));
                    const start = performance.now();
                    find(name).click();
                    while (!find(other)) await new Promise(r => setTimeout(r, 1));
                    return performance.now() - start;
                }""",
                [name, other],
            )
        )
    assert min(took) < 100.0
