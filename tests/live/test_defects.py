"""What goes wrong on the server is said on the page: files that cannot be written, and defects."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.live.view import expect

pytestmark = pytest.mark.nightly
View = Any  # see conftest.py


def test_what_cannot_be_written_is_said(
    serve: Callable[..., Any],
    another: Callable[[], View],
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A folder for temporary files that is gone stands for a full disk."""
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    monkeypatch.setenv("TMPDIR", str(temporary))
    served = serve(str(folder / "dart.toml"), "--port", "0", reconnect=8.0)
    view = another().open(served.address).tab("Save")
    temporary.rmdir()
    view.button("Run as NetCDF").click()
    expect(view.page.get_by_text("No such file")).to_be_visible()
    temporary.mkdir()
    assert view.download(view.button("Run as NetCDF")).stat().st_size > 0  # it can be done again
    expect(view.page.get_by_text("dart.nc: ")).to_be_visible()
    view.download(view.button("Run as NetCDF"))
    assert len(list(temporary.glob("rodgen-*"))) == 1  # one file at a time is kept
    view.page.close()
    another().until(lambda: list(temporary.glob("rodgen-*")), [], "the file is kept")


def test_defect_is_said_on_the_page(blank: View, folder: Path, tmp_path: Path) -> None:
    """An event that no browser sends raises what nobody expects."""
    command = [Path(sys.executable).with_name("rodgen"), "view", folder / "dart.toml"]
    with open(tmp_path / "said", "w") as said:
        process = subprocess.Popen(
            [*command, "--port", "0", "--no-open", "--paused"],
            stdout=subprocess.PIPE,
            stderr=said,
            text=True,
        )
        with process:
            assert process.stdout is not None
            blank.open(next(word for word in process.stdout.readline().split() if "://" in word))
            canvas = blank.page.get_by_role("img", name="dart")
            identity = canvas.evaluate("e => e.closest('[id^=c]').id.slice(1)")
            blank.page.evaluate(f"getElement({identity}).$emit('kick', {{link: 'x'}})")
            blank.noted("rodgen has failed")
            process.send_signal(signal.SIGINT)
    assert "Traceback" in (tmp_path / "said").read_text()
