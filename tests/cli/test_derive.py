"""rodgen derive, check and show: equations proven, modules written and compared."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import rodgen as package
from rodgen.emit.targets import PARTS
from tests.cli.conftest import Run

ROOT = Path(__file__).parents[2]


def test_derive_proves_and_writes(works: Run, tmp_path: Path) -> None:
    """Again from what was kept, without SymPy; and anew where that is damaged."""
    folder, empty = tmp_path / "out", {"RODGEN_CACHE": str(tmp_path / "cache")}
    few = ("2", "--terms", "gravity")
    done = works("derive", *few, "--out", folder, env=empty)
    for words in ("n = 2 (LagrangesMethod)", "any n (symbolic)", "proven in"):
        assert words in done.stdout
    (module,) = folder.iterdir()
    assert module.name == "rod_free_n2_gravity.py"
    before = module.stat().st_mtime_ns
    program = (
        "import sys\nfrom rodgen.cli import main\n"
        f"sys.argv[1:] = ['derive', *{few!r}, '--out', {str(folder)!r}]\n"
        "try:\n    main()\nexcept SystemExit as end:\n    assert not end.code\n"
        "assert 'sympy' not in sys.modules"
    )
    again = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env={**os.environ, **empty},
        check=False,
    )
    assert again.returncode == 0, again.stderr
    assert "proven earlier" in again.stdout
    assert "up to date" in again.stdout
    assert module.stat().st_mtime_ns == before
    for path in (tmp_path / "cache").rglob("*.json"):
        path.write_bytes(path.read_bytes().replace(b'": 3', b'": 4')[:-40])
    assert "proven in" in works("derive", *few, "--out", folder, env=empty).stdout


def test_derive_beyond_sixty_links_says_how_it_was_proven(works: Run, tmp_path: Path) -> None:
    few, wide = ("--boundary", "cantilever", "--terms", "gravity"), {"COLUMNS": "200"}
    done = works("derive", 61, *few, "--out", tmp_path, env=wide)
    assert "random rational" in done.stdout
    assert "not by LagrangesMethod" in done.stdout
    assert (tmp_path / "rod_cantilever_n61_gravity.py").stat().st_size < 60_000


WRONG = """
from rodgen.derive.closed_form import ClosedForm
right = ClosedForm.M_link
ClosedForm.M_link = lambda self, i: right(self, i) * 2
from rodgen.cli import main
import sys
sys.argv[1:] = ["derive", "3", "--out", sys.argv[1], "--terms", "gravity"]
main()
"""


def test_derive_stops_at_an_entry_that_differs(tmp_path: Path) -> None:
    """With a wrong closed form: exit status 1, the entry, and no module."""
    done = subprocess.run(
        [sys.executable, "-c", WRONG, str(tmp_path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "not proven: M" in done.stderr
    assert "derived" in done.stderr
    assert list(tmp_path.iterdir()) == []


C_FILES = {f"rod_pinned_n2_c.{ending}" for ending in ("py", "c", "h")} | {"rodgen_native"}
LUMPED = "rod_pinned_n2_tip_load_lumped.py"


@pytest.mark.parametrize(
    ("options", "names"),
    [
        ("--target c --with-steps", C_FILES),
        ("--target both --parts rhs", {"rod_pinned_n2.py", *C_FILES}),
        ("--form dense --inertia lumped --terms tip_load", {LUMPED.replace(".py", "_dense.py")}),
        pytest.param("--inertia lumped --terms tip_load", {LUMPED}, marks=pytest.mark.nightly),
    ],
)
def test_derive_writes_what_is_asked_for(
    works: Run, tmp_path: Path, options: str, names: set[str]
) -> None:
    """Without a compiler too: none is needed to write C."""
    env = {"CC": "/nonexistent", "COLUMNS": "200"}
    given = ("--boundary", "pinned", *options.split())
    done = works("derive", 2, *given, "--out", tmp_path, env=env)
    assert {path.name for path in tmp_path.iterdir()} == names
    assert "from the joint forces, exact" in done.stdout
    assert all(name in done.stdout.replace("\n", "") for name in names)


ALONE = "import sys; sys.modules['rodgen'] = None; import rod_pinned_n2_c as rod; rod.{name}"


@pytest.mark.parametrize(
    "part", ["lanes", "tangents", pytest.param("flow", marks=pytest.mark.nightly)]
)
def test_step_loops_that_a_part_calls_are_beside_it(works: Run, tmp_path: Path, part: str) -> None:
    works("derive", 2, "--boundary", "pinned", "--target", "c", "--parts", part, "--out", tmp_path)
    program = ALONE.format(name=PARTS[part][0])
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_check_passes_and_fails(works: Run, rodgen: Run, tmp_path: Path) -> None:
    works("check", ROOT / "generated" / "rod_free_n5_c.py")
    good = ROOT / "generated" / "rod_cantilever_n5.py"
    assert "far from straight" in works("check", good).stdout
    wrong = tmp_path / "wrong.py"
    text = good.read_text(encoding="utf-8").replace("    alpha = ", "    alpha = 1.001*", 1)
    wrong.write_text(text, encoding="utf-8")
    done = rodgen("check", wrong)
    assert done.returncode == 1
    assert "above 1e-10" in done.stderr


def test_show_says_what_is_left_out_and_why(works: Run, short: Callable[..., Path]) -> None:
    done = works("show", short(), env={"COLUMNS": "200"})
    lines = {line.split("│")[1].strip(): line for line in done.stdout.splitlines() if "│" in line}
    assert "yes" in lines["gravity"]
    assert "part of the code" in lines["follower"]
    assert "no table [loads.internal_damping]" in lines["internal damping"]
    assert "break points: 0.1 s" in done.stdout
    assert "integrated by dop853: the fastest motion (" in done.stdout
    assert "few enough to follow" in done.stdout
    assert "event 'low'" in done.stdout
    assert "note:" not in done.stdout


def test_show_tells_of_a_number_that_no_expression_names_and_of_degrees(
    works: Run, refused: Run, short: Callable[..., Path]
) -> None:
    """Such a number cannot be changed; and the file of a mistake is named."""
    file = short(("[rod]", "[parameters]\nidle = 2.0\n\n[rod]"))
    shown = works("show", file, "--set", "loads.follower.angle=90").stdout
    assert "note: no expression names parameters.idle" in shown
    assert "note: loads.follower.angle = 90 is 14.3 turns" in shown
    refused("show", file, "--set", "parameters.idle=3", says="parameters.idle = 3")
    wrong = short(("5*min(t/0.1, 1)", "5*min(t/0.1, 1"))
    refused("show", wrong, says=f"in {wrong}")


def test_show_lists_the_first_of_many_break_points_and_warns_of_a_method_that_drifts(
    works: Run, short: Callable[..., Path]
) -> None:
    """The force is switched 100 times a second for 0.3 s; and the method keeps no energy."""
    often = ('"5*min(t/0.1, 1)"', '"1 if sin(2*pi*50*t) > 0 else 0"')
    method = ("[integrate]", '[integrate]\nmethod = "semi_implicit_euler"\nstep = 1e-5')
    env = {"CC": "/nonexistent"}  # a module of its own need not be compiled
    done = works("show", short(often, method), env=env)
    assert "0.01, 0.02, 0.03" in done.stdout
    assert "(29 in all)" in done.stdout
    assert "does not keep its energy" in done.stderr


def test_version_and_help(works: Run) -> None:
    assert works("--version").stdout.strip() == package.__version__
    for command in ("derive", "run", "check", "show"):
        assert "Usage: rodgen" in works(command, "--help").stdout
    alone = works()
    assert alone.stdout == works("--help").stdout
    assert len(alone.stdout.splitlines()) > 10
    assert alone.stderr == ""


def test_the_package_is_the_command_too(process: Run) -> None:
    assert process("--version").stdout.strip() == package.__version__
