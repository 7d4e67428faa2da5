"""What a stranger installs: the wheel holds the tree, an editable install works."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from importlib import import_module
from pathlib import Path

import pytest

import rodgen

ROOT = Path(__file__).parents[2]
# Of what is installed.
SUFFIXES = (
    *(".py", ".pyi", ".jinja", ".typed", ".c", ".h", ".toml"),
    *(".js", ".css", ".html", ".LICENSE", ".svg", ".woff2"),
)
# What lies where in the wheels, by the folder of a package.
MAPPED = {
    ".": {
        "rodgen": "src/rodgen",
        "rodgen/derive": "derive",
        "rodgen/templates": "templates",
        "rodgen/scenes": "scenes",
    },
    "live": {"rodgen_live": "live/src/rodgen_live"},
}
SCRIPTS = (".js", ".css", ".html", ".woff2")  # of the live view alone


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
def wheels(tree: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The wheels of the packages, by their folders."""
    made = {}
    for package in MAPPED:
        folder = tmp_path_factory.mktemp("wheel")
        options = ("--no-deps", "--no-build-isolation", "--wheel-dir", str(folder))
        _pip("wheel", *options, ".", cwd=tree / package)
        (made[package],) = folder.glob("*.whl")
    return made


@pytest.fixture(scope="module")
def wheel(wheels: dict[str, Path]) -> Path:
    return wheels["."]


@pytest.mark.slow
@pytest.mark.parametrize("of", MAPPED)
def test_wheel_holds_the_tree(wheels: dict[str, Path], of: str) -> None:
    with zipfile.ZipFile(wheels[of]) as archive:
        packed = {name for name in archive.namelist() if ".dist-info/" not in name}
    expected = set()
    for package, folder in MAPPED[of].items():
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in SUFFIXES and "__pycache__" not in path.parts:
                expected.add(f"{package}/{path.relative_to(ROOT / folder).as_posix()}")
    assert packed == expected
    assert any(name.endswith(SCRIPTS) for name in packed) == (of == "live")
    with zipfile.ZipFile(wheels[of]) as archive:
        licences = [name for name in archive.namelist() if name.endswith("licenses/LICENSE")]
        assert [archive.read(name) for name in licences] == [(ROOT / "LICENSE").read_bytes()]
    packages = ("derive/general.py", "templates/numpy/chain.py.jinja", "native/steps.c")
    assert of == "live" or {f"rodgen/{name}" for name in packages} <= packed


@pytest.mark.nightly
def test_sdist_makes_the_same_wheel(wheel: Path, tree: Path, tmp_path: Path) -> None:
    """What is released as source holds what is installed, and neither tests nor evidence."""
    program = f"from setuptools import build_meta; build_meta.build_sdist({str(tmp_path)!r})"
    subprocess.run([sys.executable, "-c", program], cwd=tree, check=True, capture_output=True)
    (packed,) = tmp_path.glob("*.tar.gz")
    shutil.unpack_archive(packed, tmp_path, filter="data")
    (source,) = (path for path in tmp_path.iterdir() if path.is_dir())
    assert (source / "CHANGELOG.md").exists()
    assert not (source / "tests").exists()
    assert not (source / "evidence").exists()
    _pip("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", "made", ".", cwd=source)
    (again,) = source.glob("made/*.whl")
    assert _contents(again) == _contents(wheel)


def _contents(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


PROGRAM = """
import pathlib, sys
import rodgen
from rodgen.scene.structure import Structure
home = pathlib.Path(rodgen.__file__).resolve()
assert home.is_relative_to({home!r}), home
structure = Structure(2, "pinned", terms=("follower",))
model = rodgen.build(structure)
native = rodgen.build(structure, "c")
y, p = [0.1]*4, model.parameters(mass=1.0, length=1.0, bending_stiffness=1.0, follower_force=1.0)
assert abs(native.rhs(0.0, y, p) - model.rhs(0.0, y, p)).max() < 1e-12
import rodgen.derive
assert pathlib.Path(rodgen.derive.__file__).resolve().is_relative_to({home!r})
print(model.N)
"""


def _works(python: Path, home: Path, cwd: Path, **env: str) -> None:
    """rodgen is found below home, and can derive, emit and compile."""
    program = PROGRAM.format(home=str(home.resolve()))
    env = {**os.environ, "RODGEN_CACHE": str(cwd / "cache"), **env}
    command = [python, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, env=env, cwd=cwd, check=False)
    assert (done.returncode, done.stdout) == (0, "2\n"), done.stderr


@pytest.mark.nightly
def test_installed_wheel_derives_and_emits(wheel: Path, tmp_path: Path) -> None:
    home = tmp_path / "installed"
    _pip("install", "--no-deps", "--target", str(home), str(wheel), cwd=tmp_path)
    _works(Path(sys.executable), home, tmp_path, PYTHONPATH=str(home))


@pytest.mark.nightly  # `make` itself installs so
def test_editable_install_derives_and_emits(tree: Path, tmp_path: Path) -> None:
    home = tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(home)], check=True)
    python = home / "bin" / "python"
    (site,) = (home / "lib").glob("python*/site-packages")
    # The dependencies are those of this environment.
    here = next(p for p in map(Path, sys.path) if p.name == "site-packages")
    (site / "borrowed.pth").write_text(f"{here}\n", encoding="utf-8")
    options = ("--no-deps", "--no-build-isolation", "--editable", ".")
    _pip("--python", str(python), "install", *options, cwd=tree)
    _works(python, tree, tmp_path)


# What each extra is for, in an environment that has nothing else.
SCENE = "rodgen.Scene.example('becks_column').with_integrate(span=[0.0, 0.01])"
RUN = f"rodgen.simulate({SCENE}, progress=False, "
EXTRAS = {
    "c": f"{RUN} target='c')",
    "cvode": f"{RUN} method='cvode', target='numpy')",
    "film": "from rodgen.show.animation.film_files import find_ffmpeg as found; assert found()",
    "jax": "import rodgen.jax as r; r.rhs(rodgen.build(rodgen.Structure(2), 'c'))",
    "study": f"rodgen.study({SCENE}, {{'rod.mass': [1.0, 2.0]}}, analysis='modes', workers=2)",
    "view": "from rodgen_live.run.sweep_computation import sweep;"
    f"rows = [*sweep({SCENE}, 'loads.follower.force', 1.0, 2.0, 0.0)];"
    "import pathlib; from rodgen_live.page.export import export;"
    f"export({RUN[:-2]}), pathlib.Path('replay'))",
}


@pytest.mark.nightly
@pytest.mark.parametrize("extra", EXTRAS)
def test_an_extra_alone_is_enough(wheels: dict[str, Path], tmp_path: Path, extra: str) -> None:
    """Of the two wheels, and what they need."""
    home = tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(home)], check=True)
    python = home / "bin" / "python"
    links = [f"--find-links={path.parent}" for path in wheels.values()]
    _pip("--python", str(python), "install", *links, f"rodgen[{extra}]", cwd=tmp_path)
    env = {"RODGEN_CACHE": str(tmp_path / "cache"), "PATH": "/usr/bin:/bin", "HOME": str(tmp_path)}
    command = [
        python,
        "-c",
        f"if True:\n import rodgen\n if __name__ == '__main__':\n  {EXTRAS[extra]}",
    ]
    done = subprocess.run(command, capture_output=True, text=True, env=env, cwd=tmp_path)
    assert done.returncode == 0, done.stderr


LIGHT = """
import sys
import rodgen
{}
print(sorted({!r} & set(sys.modules)))
"""
HEAVY = {"sympy", "matplotlib", "xarray", "scipy.linalg", "scipy.optimize", "scipy.integrate"}


@pytest.mark.parametrize(
    ("use", "heavy"),
    [
        ("dir(rodgen), rodgen.__version__", HEAVY | {"scipy", "pydantic", "rich", "numpy"}),
        ("rodgen.simulate, rodgen.critical_load", HEAVY),
    ],
)
def test_import_is_light(use: str, heavy: set[str]) -> None:
    """A plain import loads none of the large packages, and functions only those that all need."""
    program = LIGHT.format(use, heavy)
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_running_a_built_scene_needs_no_sympy() -> None:
    rodgen.build(rodgen.Structure(5))
    program = "import sys; sys.modules['sympy'] = None; import rodgen; "
    program += "rodgen.build(rodgen.Structure(5))"
    subprocess.run([sys.executable, "-c", program], check=True)


def test_what_jax_is_needed_for_says_how_it_is_had(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "jax", None)
    monkeypatch.delitem(sys.modules, "rodgen.jax", raising=False)
    with pytest.raises(ImportError, match=r'pip install "\.\[jax\]"'):
        import_module("rodgen.jax")


def test_every_public_name_is_there() -> None:
    assert {"Scene", "simulate", "study"} < set(rodgen.__all__) <= set(dir(rodgen))
    assert all(getattr(rodgen, name) is not None for name in rodgen.__all__)
    with pytest.raises(AttributeError, match="nothing"):
        _ = rodgen.nothing
