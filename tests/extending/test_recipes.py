"""The recipes of docs/extending.md, taken from the page and tried in a copy of the source tree.

Each is to touch so many files; then one process tries them all, in a tree that has followed all.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
FOLDERS = {"src/rodgen": "", "derive": "derive", "templates": "templates"}
BLOCK = re.compile(r"`([\w/]+\.\w+)`:\n\n```\w+\n(.*?)```", re.DOTALL)


def follow(recipe: str, tree: Path) -> list[str]:
    """Do what a section of the page says; the files of the project that it touches."""
    section = re.split(r"\n## ", PAGE.partition(f"\n## {recipe}\n")[2])[0]
    assert section, f"no recipe {recipe}"
    touched = []
    for name, text in BLOCK.findall(section):
        source = next(folder for folder in FOLDERS if name.startswith(folder))
        file = tree / "rodgen" / FOLDERS[source] / Path(name).relative_to(source)
        if file.exists():  # a row, at the end of the list that the page names
            (rows,) = re.findall(r"`([A-Z]+)`\s+(?:in|of)\s+`" + name, section)
            found = re.split(rf"(?ms)(^{rows}\b[^\n]*[({{]\n.*?)(?=^[)}}]\n)", file.read_text())
            assert len(found) == 3, f"no list {rows} in {name}"
            row = text.rstrip().removesuffix(",") + ",\n"
            text = "".join((*found[:2], row, found[2]))
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")
        touched.append(name)
    return touched


SCENE = """
import numpy as np
from rodgen import Scene, Structure, build, simulate
from rodgen.check.module_check import LIMIT, check_module
from rodgen.check.proofs import prove
def scene(boundary="pinned", links=2, loads=None, **integrate):
    return Scene.from_dict({
        "name": "toy",
        "rod": {"links": links, "length": 1.0, "bending_stiffness": 3.0, "mass": 2.0,
                "boundary": boundary},
        "loads": loads or {"gravity": {}}, "initial": {"phi": 0.3},
        "integrate": {"span": [0.0, 0.5], "output_every": 0.1, **integrate},
    })
"""
# What each recipe touches, and a program that fails if what it says does not hold.
RECIPES = {
    "A method": (
        ["src/rodgen/model/methods.py"],
        """
from rodgen.integrate.stability import step_limit
assert abs(step_limit("heun", -1.0 + 0j) - 2.0) < 1e-6  # 1 + z + z^2/2 is 1 at z = -2
exact = simulate(scene(), method="dop853", rtol=1e-12, atol=1e-14).y
errors = []
for step in (0.002, 0.001):
    ends = [simulate(scene(), method="heun", step=step, target=t).y for t in ("numpy", "c")]
    # Sums of a step are taken in another order: a few roundings a step, of 500 steps.
    assert np.allclose(*ends, rtol=0, atol=1e-12)
    errors.append(abs(ends[0] - exact).max())
order = np.log2(errors[0] / errors[1])
assert abs(order - 2) < 0.1, order
""",
    ),
    "A load": (
        ["derive/loads/nose_force.py", "src/rodgen/model/terms.py"],
        """
structure = Structure(4, "clamped", "uniform", ("gravity", "nose_force"))
assert prove(structure).comparisons
assert max(d.error for d in check_module(build(structure))) < LIMIT
loads = {"nose_force": {"x": 3.0, "y": "2*cos(5*t)"}, "gravity": {}}
toy = scene("clamped", 4, loads)
runs = [simulate(toy, method="dop853", target=t, rtol=1e-10, atol=1e-12) for t in ("numpy", "c")]
assert np.allclose(runs[0].y, runs[1].y, rtol=0, atol=1e-8)  # a hundred times rtol
assert runs[1].energy_error < 1e-8
assert "nose_force" in runs[1].work
acting = runs[1].forces["nose_force"]
assert np.allclose(acting[0, 1], (3.0, 2.0)) and not acting[0, [0, 2, 3, 4]].any()
# With a force along x alone on a rod that hangs from its pivot: statics by hand.
from rodgen import static_equilibrium
chain = Scene.from_dict({
    "name": "chain", "rod": {"links": 2, "length": 2.0, "bending_stiffness": 0.0, "mass": 2.0,
    "boundary": "pinned", "inertia": "lumped"},
    "loads": {"gravity": {"g": 10.0}, "nose_force": {"x": 5.0}},
})
phi = static_equilibrium(chain).phi
# Below joint 1 it hangs; link 0 bears 5 N aside and 1.5 kg, of which 0.5 kg are at the tail.
assert np.allclose(phi, [np.arctan2(-15.0, 5.0), -np.pi / 2], atol=1e-9)
""",
    ),
    "A boundary": (
        ["src/rodgen/model/rod.py"],
        """
terms = ("follower", "gravity", "internal_damping")
for links, inertia in ((1, "uniform"), (3, "uniform"), (4, "lumped"), (70, "uniform")):
    assert prove(Structure(links, "held_tail", inertia, terms)).comparisons
for links in (1, 3):
    structure = Structure(links, "held_tail", "uniform", terms)
    assert max(d.error for d in check_module(build(structure))) < LIMIT
loads = {"gravity": {}, "internal_damping": {"coefficient": 0.1}}
toy = scene("held_tail", 3, loads)
runs = [simulate(toy, method="dop853", target=t, rtol=1e-10, atol=1e-12) for t in ("numpy", "c")]
assert np.allclose(runs[0].y, runs[1].y, rtol=0, atol=1e-8)  # a hundred times rtol
implicit = simulate(toy, method="radau", target="c", rtol=1e-10, atol=1e-12)
assert np.allclose(implicit.y, runs[1].y, rtol=0, atol=1e-7)
assert runs[1].energy_error < 1e-8
# One link: J phi'' = -2 k phi with J = M L^2 / 3 and k = EI / L.
from rodgen import natural_modes
one = scene("held_tail", 1, {"follower": {"force": 0.0}})
rate = np.sqrt(2 * 3.0 / (2.0 / 3)) / (2 * np.pi)
assert abs(natural_modes(one).frequencies[0] / rate - 1) < 1e-10
""",
    ),
    "A quantity": (
        ["src/rodgen/model/quantities.py", "src/rodgen/integrate/quantity_formulas.py"],
        """
event = {"name": "bent", "quantity": "chord", "value": 0.995, "action": "stop"}
toy = Scene.from_dict(scene().model_dump(exclude_none=True) | {"events": [event]})
sol = simulate(toy, target="numpy")
data = sol.to_xarray()
# Two links of half a metre with the angle d between them: the chord is cos(d/2).
assert np.allclose(data["chord"], np.cos(np.diff(sol.phi)[:, 0] / 2), rtol=0, atol=1e-14)
assert data["chord"].attrs["units"] == "m"
assert [e.name for e in sol.events] == ["bent"]
assert abs(np.cos(np.diff(sol.y[-1, :2])[0] / 2) - 0.995) < 1e-9  # rounding of a crossing's time
""",
    ),
    "An analysis": (
        [
            "src/rodgen/analyse/half_lives.py",
            "src/rodgen/show/half_life_pictures.py",
            "src/rodgen/cli/half_life_command.py",
        ],
        """
import json, subprocess, sys, warnings
from rodgen.analyse.half_lives import half_lives
# One link on a root spring, Kelvin-Voigt: J phi'' + tau k phi' + k phi = 0, so amplitudes fall as
# exp(-tau k t / (2 J)), with J = M L^2 / 3 and k = 2 EI / L.
damped = scene("clamped", 1, {"material_damping": {"time": 0.01}})
found = half_lives(damped, 1)
due = 2 * (2.0 / 3) * np.log(2) / (0.01 * 2 * 3.0)
assert abs(found.times[0] / due - 1) < 1e-9 and not found.doubts
assert "half-life [s]" in str(found)
assert found.plot().get_ylabel() == "half-life [s]"
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    undamped = half_lives(scene("clamped", 1), 1)
assert [str(one.message) for one in told] == [undamped.doubts[0].text]
open("toy.toml", "w").write(damped.to_toml())
command = [sys.executable, "-m", "rodgen", "half-life", "toy.toml", "--count", "1"]
said = subprocess.run([*command, "--json"], capture_output=True, check=True, text=True).stdout
assert json.loads(said) == found.to_dict()
subprocess.run(command, capture_output=True, check=True)
from pathlib import Path
assert Path("results/toy/half_lives.png").stat().st_size > 0
""",
    ),
    "A target": (
        ["src/rodgen/emit/lists/__init__.py", "templates/lists/module.jinja"],
        """
from rodgen.check.module_check import LIMIT, check_module
loads = ("follower", "gravity", "internal_damping", "external_damping", "tip_load")
for links, boundary, inertia, terms in (
    (1, "free", "uniform", loads),
    (3, "free", "lumped", loads),
    (4, "cantilever", "uniform", loads),
    (5, "free", "uniform", loads),
    (5, "pinned", "lumped", ("gravity",)),
    (5, "clamped", "uniform", ("tip_load",)),
):
    module = build(Structure(links, boundary, inertia, terms), target="lists")
    assert module.PROVENANCE["target"] == "lists"
    assert max(d.error for d in check_module(module)) < LIMIT
steps = {"method": "dop853", "rtol": 1e-10, "atol": 1e-12}
runs = [simulate(scene(), target=target, **steps).y for target in ("numpy", "lists")]
# Sums are taken in another order: roundings, as the states of a span of a second see them.
assert np.allclose(*runs, rtol=0, atol=1e-10)
""",
    ),
}
# Prints what went wrong, by recipe.
TRY = """
import json, sys, traceback
import rodgen
failures = {}
for name, program in json.load(sys.stdin).items():
    try:
        exec(compile(program, name, "exec"), {})
    except Exception:
        failures[name] = traceback.format_exc()
print(json.dumps([rodgen.__file__, failures]))
"""


@pytest.fixture(scope="module")
def tried(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[list[str], str]]:
    """By recipe, the files that it touches, when all are followed one after the other in a copy of
    the packages as they lie in a wheel, and what went wrong after that."""
    tree = tmp_path_factory.mktemp("tree")
    ignore = shutil.ignore_patterns("__pycache__", "static")
    for folder, at in FOLDERS.items():
        shutil.copytree(ROOT / folder, tree / "rodgen" / at, ignore=ignore, dirs_exist_ok=True)
    touched = {recipe: follow(recipe, tree) for recipe in RECIPES}
    done = subprocess.run(
        [sys.executable, "-c", TRY],
        input=json.dumps({name: SCENE + program for name, (_, program) in RECIPES.items()}),
        capture_output=True,
        text=True,
        timeout=500,
        env={**os.environ, "PYTHONPATH": str(tree)},
        cwd=tree,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    used, failed = json.loads(done.stdout)
    assert Path(used).is_relative_to(tree)
    return {recipe: (files, failed.get(recipe, "")) for recipe, files in touched.items()}


@pytest.mark.nightly
@pytest.mark.compiler
@pytest.mark.parametrize("recipe", RECIPES)
def test_recipe(recipe: str, tried: dict[str, tuple[list[str], str]]) -> None:
    assert tried[recipe] == (RECIPES[recipe][0], "")
