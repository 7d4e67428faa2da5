"""What README shows runs where nothing of the repository lies."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

README = Path(__file__).parents[2] / "README.md"


@pytest.mark.nightly
def test_snippets_run_in_an_empty_folder(tmp_path: Path) -> None:
    text = README.read_text(encoding="utf-8")
    commands = re.findall(r"^    rodgen (derive .*?)(?: {2,}#.*)?$", text, re.MULTILINE)
    programs = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert len(commands) == len(programs) == 2
    for command in (["-m", "rodgen", *commands[0].split()], *(["-c", one] for one in programs)):
        done = subprocess.run(
            [sys.executable, *command], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "missile.nc").is_file()
