"""What `make docs NAME=reference` writes, and what it finds out of date."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests import reference


def test_check_names_what_differs_and_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Line ends count; a file that is not there differs."""
    wanted = {tmp_path / name: f"text of {name}\n" for name in ("same", "other", "ends", "none")}
    monkeypatch.setattr(reference, "texts", lambda: wanted.items())
    (tmp_path / "same").write_text(wanted[tmp_path / "same"])
    (tmp_path / "other").write_text("another text\n")
    (tmp_path / "ends").write_bytes(b"text of ends\r\n")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(SystemExit) as end:
        reference.main("--check")
    assert end.value.code == 1
    named = [Path(line).name for line in capsys.readouterr().out.splitlines()]
    assert named == ["other", "ends", "none"]
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
    reference.main()
    assert {path: path.read_bytes().decode() for path in tmp_path.iterdir()} == wanted
    reference.main("--check")


def test_kept_modules_are_those_under_version_control() -> None:
    kept = {
        path.name for path in reference.GENERATED.glob("rod_*") if path.stem in reference.MODULES
    }
    listed = (reference.GENERATED / ".gitignore").read_text(encoding="utf-8")
    assert {*re.findall(r"^!(rod_\w+\.\w+)$", listed, re.M)} == kept
