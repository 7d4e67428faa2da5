"""rodgen derive, check and show: equations proven, modules written and compared."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import rodgen as package
from rodgen.emit.targets import PARTS
from rodgen.scene import Scene
from tests.cli.conftest import ROOT, Run, python
from tests.told import numbers

# `python -m rodgen`, where SymPy cannot be imported.
WITHOUT_SYMPY = """
import runpy, sys
sys.modules["sympy"] = None
runpy.run_module("rodgen", run_name="__main__", alter_sys=True)
"""


def test_a_module_is_proven_written_and_checked(
    works: Run, short: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a scene; again from what was kept, without SymPy; anew where what was kept is damaged."""
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "out"
    given = ("--set", "rod.links=2", "--set", "loads.follower=")
    command = ("derive", "--scene", short, *given, "--out", folder, "--json")
    told = json.loads(works(*command).stdout)
    structure = Scene.from_toml(short).replace({"rod.links": 2, "loads.follower": None}).structure
    assert (told["module"], told["structure"]) == (structure.stem, structure.hash)
    assert {one["how"] for one in told["proven"]} == {"any n", "explicit n", "joint forces"}
    assert all(one["entries"] > 0 for one in told["proven"])
    module = folder / f"{structure.stem}.py"
    assert told["files"] == [str(module)]
    assert not told["proven_earlier"]
    before = module.stat().st_mtime_ns
    again = python(WITHOUT_SYMPY, *command, cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    assert json.loads(again.stdout) == {**told, "proven_earlier": True}
    assert module.stat().st_mtime_ns == before
    for path in (tmp_path / "cache").rglob("*.json"):
        path.write_bytes(path.read_bytes().replace(b'": 3', b'": 4')[:-40])
    assert json.loads(works(*command).stdout) == told
    checked = json.loads(works("check", module, "--json").stdout)
    assert checked["largest"] == max(checked["errors"])
    assert checked["largest"] <= checked["allowed"]


@pytest.mark.slow
def test_derive_beyond_sixty_links_says_how_it_was_proven(works: Run, tmp_path: Path) -> None:
    few = ("--boundary", "cantilever", "--terms", "gravity", "--out", tmp_path)
    told = json.loads(works("derive", 61, *few, "--json").stdout)
    assert "rational points" in {one["how"] for one in told["proven"]}


WRONG = """
from rodgen.derive.closed_form import ClosedForm
right = ClosedForm.M_link
ClosedForm.M_link = lambda self, i: right(self, i) * 2
from rodgen.cli import main
main()
"""


@pytest.mark.slow
def test_derive_stops_at_an_entry_that_differs(tmp_path: Path) -> None:
    """With a wrong closed form: exit status 1, the entry, and no module."""
    done = python(WRONG, "derive", 3, "--terms", "gravity", "--out", tmp_path, cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert re.search(r"\bM\b", done.stderr)
    assert list(tmp_path.iterdir()) == []


C_FILES = {f"rod_pinned_n2_gravity_c.{ending}" for ending in ("py", "c", "h")} | {"rodgen_native"}


@pytest.mark.parametrize(
    ("options", "names"),
    [
        pytest.param("--target c --with-steps", C_FILES, marks=pytest.mark.slow),
        ("--target both --parts rhs", {"rod_pinned_n2_gravity.py", *C_FILES}),
        ("--form dense --inertia lumped", {"rod_pinned_n2_gravity_lumped_dense.py"}),
    ],
)
def test_derive_writes_what_is_asked_for(
    works: Run, tmp_path: Path, options: str, names: set[str]
) -> None:
    """Without a compiler too: none is needed to write C."""
    given = ("--boundary", "pinned", "--terms", "gravity", *options.split())
    works("derive", 2, *given, "--out", tmp_path, env={"CC": "/nonexistent"})
    assert {path.name for path in tmp_path.iterdir()} == names


@pytest.mark.parametrize("part", ["lanes", pytest.param("tangents", marks=pytest.mark.slow)])
def test_step_loops_that_a_part_calls_are_beside_it(works: Run, tmp_path: Path, part: str) -> None:
    given = ("--boundary", "pinned", "--terms", "gravity", "--target", "c", "--parts", part)
    works("derive", 2, *given, "--out", tmp_path)
    alone = "import sys; sys.modules['rodgen'] = None; import rod_pinned_n2_gravity_c as rod"
    done = python(f"{alone}; rod.{PARTS[part][0]}", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


def test_check_passes_and_fails(works: Run, rodgen: Run, tmp_path: Path) -> None:
    good = ROOT / "generated" / "rod_cantilever_n5.py"
    works("check", good)
    works("check", ROOT / "generated" / "rod_free_n5_c.py")
    wrong = tmp_path / "wrong.py"
    text = good.read_text(encoding="utf-8").replace("    alpha = ", "    alpha = 1.001*", 1)
    wrong.write_text(text, encoding="utf-8")
    done = rodgen("check", wrong)
    assert done.returncode == 1
    assert 1e-10 in numbers(done.stderr)  # what is allowed


def test_show_tells_what_a_scene_is(works: Run, short: Path) -> None:
    """As JSON and in words, with a number that no expression names and an angle in degrees, which
    are doubtful."""
    short.write_text(f"{short.read_text()}[parameters]\nidle = 2.0\n")
    given = ("show", short, "--set", "loads.follower.angle=90")
    scene = Scene.from_toml(short).replace({"loads.follower.angle": 90})
    told = json.loads(works(*given, "--json").stdout)
    assert told["structure"] == scene.structure.hash
    assert told["parameters"] == scene.parameters
    assert told["breaks"] == scene.breaks()
    present = dict(zip(told["pieces"], told["present"], strict=True))
    assert (present["gravity"], present["follower"], present["drag"]) == (True, True, False)
    assert told["largest_stable_steps"]["rk4"] > 0
    for field in ("parameters.idle", "loads.follower.angle"):
        assert any(field in note["text"] for note in told["notes"] if note["kind"] == "doubt")
    done = works(*given)
    shown = done.stdout
    for word in (told["method"], "'low'", "tip_y", *present):
        assert word in " ".join(shown.split())
    assert 0.1 in numbers(shown)  # the break point
    said = [*done.stderr.splitlines(), *shown.splitlines()]
    assert sum(": warning: " in line or "note: " in line for line in said) == len(told["notes"])


def test_show_weighs_the_rod_and_counts_the_knots_of_tables(works: Run, short: Path) -> None:
    """A straight rod of 1 kg on the x axis with 3 kg at its tail, 0.1 m beside it; a table of ten
    knots, which is nowhere written out."""
    knots = ", ".join(f"0.0{at}" for at in range(10))
    body = '[[bodies]]\nname = "engine"\nat = 1.0\nmass = 3.0\noffset = [0.0, 0.1]\n'
    short.write_text(f"{short.read_text()}{body}")
    force = f"loads.follower.force=interp(t, [{knots}], {[at + 0.625 for at in range(10)]})"
    given = ("show", short, "--set", force, "--set", "initial.phi=0")
    env = {"CC": "/nonexistent"}  # a module of its own need not be compiled
    told = json.loads(works(*given, "--json", env=env).stdout)
    assert told["mass"] == 4.0
    assert told["centre_of_gravity"] == pytest.approx([(0.5 + 3) / 4, 0.3 / 4], rel=1e-14)
    done = works(*given, env=env)
    shown = numbers(done.stdout)
    assert {4.0, 0.875, 0.075, 10.0} <= {*shown}
    assert {1.625, 7.625}.isdisjoint(shown)
    assert not any(f"knot_{at}" in done.stdout for at in range(2, 11))


def test_show_lists_the_first_of_many_break_points_and_warns_of_a_method_that_drifts(
    works: Run, short: Path
) -> None:
    """The force is switched 100 times a second for 0.3 s; and the method keeps no energy."""
    often = ("--set", "loads.follower.force=1 if sin(2*pi*50*t) > 0 else 0")
    method = ("--set", "integrate.method=semi_implicit_euler", "--set", "integrate.step=1e-5")
    env = {"CC": "/nonexistent"}  # a module of its own need not be compiled
    done = works("show", short, *often, *method, env=env)
    shown = numbers(done.stdout)
    assert {0.01, 0.02, 0.03, 29} <= {*shown}
    assert 0.28 not in shown
    assert done.stderr.startswith("rodgen: warning: ")


def test_version_and_help(works: Run) -> None:
    assert works("--version").stdout.strip() == package.__version__
    alone = works()
    assert (alone.stdout, alone.stderr) == (works("--help").stdout, "")
