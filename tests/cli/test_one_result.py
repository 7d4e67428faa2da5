"""What a command prints as JSON is what Python returns, with the notes that Python warns of."""

from __future__ import annotations

import inspect
import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import rodgen
from rodgen.check.module_check import check_module
from rodgen.check.proofs import prove
from rodgen.cli.app import own_commands
from rodgen.loading import load_module
from rodgen.result import DOUBT
from rodgen.scene import Scene
from rodgen.studies.counts import count_points
from tests.analyse.rods import COLUMN, FORCE, ONES, THRUST, ZIEGLER, rod
from tests.cli.conftest import ROOT, Run

pytestmark = [pytest.mark.compiler, pytest.mark.usefixtures("work")]
# What only the command line knows: where it has written. And what a clock has told.
WRITTEN = {"folder", "files", "store", "pictures"}
CLOCK = {"seconds", "rows", "error", "setting", "method", "limits", "trusted", "reference"}
MODULE = ROOT / "generated" / "rod_free_n5.py"
TURNED = COLUMN.replace({"loads.follower.angle": 30.0, "integrate.span": [0.0, 0.1]})
BENT = rod(3, "clamped", {"tip": {"x": -12.0, "y": 0.0}}, **ONES)
CYCLING = ZIEGLER.replace({"initial.phi": "0.2*s"})
SWINGING = rod(1, "pinned", {"gravity": {}}, initial={"phi": -1.5})
PLANE = (FORCE, "loads.internal_damping.coefficient")
AT = (12.0, 40.0)
STUDY = {"vary": {FORCE: {"bounds": [*AT], "count": 2}}, "compute": {"analysis": "modes"}}


class Case(NamedTuple):
    """A command with its scene and options; call: the same in Python; doubts: whether it has any;
    timed: names of what differs from one time to the next."""

    command: str
    scene: Scene | None
    options: tuple[object, ...]
    call: Callable[[], Any]
    doubts: bool = False
    timed: frozenset[str] = frozenset()


def _study() -> Any:
    """The tally of a store, after the Dataset has told of its doubts."""
    path = Path("python.zarr")
    rodgen.study(COLUMN, STUDY["vary"], analysis="modes", out=path, workers=1, progress=False)
    return count_points(path)


CASES = [
    Case("run", TURNED, (), lambda: rodgen.simulate(TURNED, progress=False), True),
    Case("show", TURNED, (), lambda: rodgen.describe(TURNED), True),
    Case("modes", ZIEGLER, ("--count", 2), lambda: rodgen.natural_modes(ZIEGLER, 2), True),
    Case(
        *("linearise", COLUMN),
        (
            "--input",
            "loads.follower.angle",
            "--output",
            "phi(1)",
            "--output",
            "tip_x",
            "--modes",
            2,
            "--minimal",
        ),
        lambda: (
            rodgen.linearise(COLUMN, ["loads.follower.angle"], ["phi(1)", "tip_x"])
            .minimal()
            .reduce(2)
        ),
    ),
    Case("static", BENT, (), lambda: rodgen.static_equilibrium(BENT), True),
    Case("static", BENT, ("--all",), lambda: rodgen.static_equilibria(BENT)),
    Case("critical", COLUMN, ("--bounds", ",40"), lambda: _critical(bounds=(None, 40.0))),
    Case(
        *("branch", rod(4, "clamped", THRUST, **ONES)),
        ("--vary", FORCE, "--bounds", "1,30", "--check-mesh"),
        lambda: _branch(rod(4, "clamped", THRUST, **ONES)),
        True,
    ),
    Case(
        *("boundary", COLUMN, ("--vary", ",".join(PLANE), "--bounds", "0,60")),
        lambda: rodgen.stability_boundary(COLUMN, PLANE, bounds=((0.0, 60.0), None)),
    ),
    Case("exponents", TURNED, (), lambda: rodgen.lyapunov_exponents(TURNED)),
    Case(
        *("cycle", CYCLING, ("--check-mesh",)),
        lambda: rodgen.find_cycle(CYCLING, check_mesh=True),
        True,
    ),
    Case(
        *("cycle-branch", ZIEGLER, ("--vary", FORCE, "--bounds", "15,16.2", "--start", "run")),
        lambda: rodgen.continue_cycles(ZIEGLER, FORCE, (15.0, 16.2), start="run", step=0.1),
    ),
    Case(
        *("nonlinear-mode", SWINGING, ("--energy", 1)),
        lambda: rodgen.nonlinear_mode(SWINGING, 1, 1.0),
    ),
    Case(
        *("precision", SWINGING, ("--seconds", 0.2)),
        lambda: rodgen.work_precision(SWINGING, seconds=0.2),
        timed=frozenset(CLOCK),
    ),
    Case("study", None, ("study.toml",), _study),
    Case("check", None, (MODULE,), lambda: check_module(load_module(MODULE))),
    Case(
        *("derive", None, ("--scene", "scene.toml", "--out", "out")),
        lambda: prove(SWINGING.structure),
        timed=frozenset({"proven_earlier"}),
    ),
]


def _critical(**given: Any) -> Any:
    return rodgen.critical_load(COLUMN, **given)


def _branch(scene: Scene) -> Any:
    return rodgen.continue_equilibria(scene, FORCE, (1.0, 30.0), check_mesh=True)


def _as_dict(found: Any) -> dict[str, Any]:
    """What Python knows, as the command prints it."""
    if isinstance(found, list):
        return {"equilibria": [one.to_dict() for one in found]}
    made: dict[str, Any] = getattr(found, "rodgen", found).to_dict()
    return made


def _doubts(told: dict[str, Any]) -> list[str]:
    several = [told] if "notes" in told else told["equilibria"]
    texts = [note["text"] for one in several for note in one["notes"] if note["kind"] == DOUBT]
    return [*dict.fromkeys(texts)]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.command} {case.doubts}")
def test_json_is_what_python_returns_and_doubts_are_what_it_warns_of(
    works: Run, case: Case
) -> None:
    Path("study.toml").write_text(_toml(STUDY | {"scene": COLUMN.to_dict()}), encoding="utf-8")
    Path("scene.toml").write_text((case.scene or SWINGING).to_toml(), encoding="utf-8")
    given = ("scene.toml", *case.options) if case.scene else case.options
    quiet = () if case.command in ("show", "check", "derive") else ("--no-pictures",)
    done = works(case.command, *given, *quiet, "--json")
    printed = json.loads(done.stdout)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", rodgen.DoubtWarning)
        found = case.call()
    due = json.loads(json.dumps(_as_dict(found), allow_nan=False))
    assert printed.keys() - due.keys() <= WRITTEN
    for name in due.keys() - case.timed:
        assert name in printed
        if name not in ("seconds", "name"):
            assert printed[name] == due[name], name
    said = [str(one.message) for one in caught if one.category is rodgen.DoubtWarning]
    assert said == _doubts(printed) == _doubts(due)
    assert bool(said) is case.doubts
    lines = [line for line in done.stderr.splitlines() if "warning: " in line]
    assert [line.partition("warning: ")[2] for line in lines] == said


def _toml(table: dict[str, Any]) -> str:
    import tomli_w

    return tomli_w.dumps(table)


def test_every_command_with_a_result_is_here() -> None:
    """`scenes` lists files."""
    commands = own_commands().items()
    printing = {name for name, one in commands if "as_json" in inspect.signature(one).parameters}
    assert printing - {"scenes"} == {case.command for case in CASES}
