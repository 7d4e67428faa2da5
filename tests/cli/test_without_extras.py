"""Commands where packages of the extras are not installed: each says what to install."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import rodgen as package
from rodgen.scene import Scene

ROOT = Path(__file__).parents[2]

# An import of one of the packages in the first argument fails as if it were not there.
BLOCKED = """
import importlib.abc, sys
blocked = sys.argv.pop(1).split(",")
class Absent(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in blocked:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Absent())
from rodgen.cli import main
main()
"""
VIEW = ("nicegui", "tomli_w", "uvicorn", "fastapi", "starlette")
EXTRAS = ",".join((*VIEW, "imageio_ffmpeg", "cffi", "sksundae"))


def without(packages: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", BLOCKED, packages, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


@pytest.fixture
def scene_file(tmp_path: Path) -> Path:
    path = tmp_path / "short.toml"
    path.write_text(
        'name = "short"\n[rod]\nlinks = 4\nlength = 1.0\nbending_stiffness = 2.0\nmass = 1.0\n'
        "[integrate]\nspan = [0.0, 0.1]\n",
        encoding="utf-8",
    )
    return path


@pytest.mark.parametrize("missing", [*VIEW, EXTRAS])
def test_view_says_what_to_install(missing: str) -> None:
    done = without(missing, "view", ROOT / "scenes" / "missile.toml", "--no-open", "--port", 0)
    assert done.returncode == 2
    assert 'pip install "rodgen[view]"' in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_run_by_cvode_says_what_to_install(scene_file: Path, tmp_path: Path) -> None:
    done = without(EXTRAS, "run", scene_file, "--method", "cvode", "--out", tmp_path)
    assert done.returncode == 2
    assert 'pip install "rodgen[cvode]"' in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_run_in_c_says_what_to_install(scene_file: Path, tmp_path: Path) -> None:
    done = without(EXTRAS, "run", scene_file, "--target", "c", "--out", tmp_path)
    assert done.returncode == 2
    assert "pip install cffi" in done.stderr
    assert "Traceback" not in done.stderr


def test_run_by_numpy_says_why(scene_file: Path, tmp_path: Path) -> None:
    done = without(EXTRAS, "run", scene_file, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "target numpy" in done.stdout
    assert "cannot be built: cffi is missing" in done.stdout


def test_animate_takes_gif_without_extras(scene_file: Path, tmp_path: Path) -> None:
    result, film = tmp_path / "run.nc", tmp_path / "film.gif"
    package.simulate(Scene.from_toml(scene_file), target="numpy").save(result)
    size = ("--width", 480, "--height", 320, "--speed", 0.2)
    done = without(EXTRAS, "animate", result, "--out", film, *size)
    assert done.returncode == 0, done.stderr
    assert film.is_file()
