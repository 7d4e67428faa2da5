"""What a stranger installs: the wheel holds the tree, an editable install works."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SUFFIXES = (".py", ".jinja", ".typed", ".c", ".js", ".css")  # of what is installed
MAPPED = {"rodgen": "src/rodgen", "rodgen/derive": "derive", "rodgen/templates": "templates"}


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The project as it would be packed, without anything built."""
    copy = tmp_path_factory.mktemp("tree") / "rodgen"
    ignore = shutil.ignore_patterns(".*", "build", "results", "__pycache__", "*.egg-info")
    shutil.copytree(ROOT, copy, ignore=ignore)
    return copy


def _pip(*arguments: str, cwd: Path) -> None:
    command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", *arguments]
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def wheel(tree: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    _pip("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), ".", cwd=tree)
    (path,) = folder.glob("*.whl")
    return path


def test_wheel_holds_the_tree(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        packed = {name for name in archive.namelist() if ".dist-info/" not in name}
    expected = set()
    for package, folder in MAPPED.items():
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in SUFFIXES and "__pycache__" not in path.parts:
                expected.add(f"{package}/{path.relative_to(ROOT / folder).as_posix()}")
    assert packed == expected
    for name in ("numpy_dense.py.jinja", "numpy_chain.py.jinja", "c.c.jinja", "c.h.jinja"):
        assert f"rodgen/templates/{name}" in packed
    assert {"rodgen/templates/c.py.jinja", "rodgen/templates/c_build.py"} <= packed
    assert "rodgen/derive/general.py" in packed


PROGRAM = """
import pathlib, sys
import rodgen
from rodgen.scene.structure import Structure
home = pathlib.Path(rodgen.__file__).resolve()
assert home.is_relative_to({home!r}), home
model = rodgen.build(Structure(3))
native = rodgen.build(Structure(3), "c")
y, p = [0.1]*10, model.parameters(
    mass=1.0, length=1.0, bending_stiffness=1.0,
    follower_force=1.0, internal_damping=1.0, external_damping=1.0,
)
assert abs(native.rhs(0.0, y, p) - model.rhs(0.0, y, p)).max() < 1e-12
import rodgen.derive
assert pathlib.Path(rodgen.derive.__file__).resolve().is_relative_to({home!r})
print(model.N)
"""


def _works(home: Path, path: Path, tmp_path: Path) -> None:
    """rodgen is found below home when the path comes first, and can derive and emit."""
    env = {**os.environ, "RODGEN_CACHE": str(tmp_path / "cache")}
    program = f"import site, sys; sys.path.insert(0, {str(path)!r}); site.addsitedir({str(path)!r})"
    # The environment's own editable install must not answer in place of the one tested.
    program += "\nsys.meta_path = [f for f in sys.meta_path if 'editable' not in repr(f)] + ["
    program += "f for f in sys.meta_path if 'editable' in repr(f)][-1:]"
    program += PROGRAM.format(home=str(home))
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, env=env, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "3"


def test_installed_wheel_derives_and_emits(wheel: Path, tmp_path: Path) -> None:
    target = tmp_path / "installed"
    _pip("install", "--no-deps", "--target", str(target), str(wheel), cwd=tmp_path)
    _works(target.resolve(), target, tmp_path)


def test_editable_install_derives_and_emits(tree: Path, tmp_path: Path) -> None:
    home = tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(home)], check=True)
    python = home / "bin" / "python"
    (site,) = (home / "lib").glob("python*/site-packages")
    # The dependencies are those of this environment.
    here = next(p for p in map(Path, sys.path) if p.name == "site-packages")
    (site / "borrowed.pth").write_text(f"{here}\n", encoding="utf-8")
    _pip(
        "--python",
        str(python),
        "install",
        "--no-deps",
        "--no-build-isolation",
        "--editable",
        ".",
        cwd=tree,
    )
    env = {**os.environ, "RODGEN_CACHE": str(tmp_path / "cache")}
    program = PROGRAM.format(home=str(tree.resolve()))
    done = subprocess.run(
        [str(python), "-c", program], capture_output=True, text=True, env=env, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "3"


LIGHT = """
import sys
import rodgen
dir(rodgen), rodgen.__version__
heavy = {"sympy", "matplotlib", "xarray", "scipy", "pydantic", "rich", "typer", "numpy"}
print(sorted(heavy & set(sys.modules)))
"""


def test_import_is_light() -> None:
    """A plain import loads none of the large packages, so it takes next to no time."""
    done = subprocess.run([sys.executable, "-c", LIGHT], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_running_a_built_scene_needs_no_sympy() -> None:
    program = (
        "import sys, rodgen\n"
        "s = rodgen.Structure(3)\n"
        "rodgen.build(s)\n"
        "for m in [m for m in sys.modules if m.split('.')[0] == 'sympy']: del sys.modules[m]\n"
        "sys.modules['sympy'] = None\n"
        "rodgen.build(s)\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_every_public_name_is_there() -> None:
    import rodgen

    for name in rodgen.__all__:
        assert getattr(rodgen, name) is not None
    with pytest.raises(AttributeError, match="nothing"):
        _ = rodgen.nothing
