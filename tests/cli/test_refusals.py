"""What commands refuse: a line that names the field, status 2 or 3, and nothing written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rodgen.cli.exits import report_errors
from tests.cli.conftest import ROOT, Run, Write

MISSILE = ROOT / "scenes" / "missile.toml"
PUSHED = "[loads.follower]\nforce = 10.0"
# What stands for the file of a scene in the tables below, beside DAMPED, a column that has all
# loads.
SCENES: dict[str, tuple[Any, ...]] = {"FREE": ("", 4, "free"), "PUSHED": (PUSHED,)}
LOADED = {
    "DAMPED": (f"{PUSHED}\n[loads.internal_damping]\ncoefficient = 0.3",),
    "TURNED": (f"{PUSHED}\nangle = 0.3", "free"),
}
FORCE = "--vary loads.follower.force"
OPEN_BOUNDS = "--bounds 0,", "--bounds 0,nan"
BRANCH = "DAMPED --bounds 0,10 --vary"
# By command: the field that is named, and the arguments that it is named for.
REFUSED: dict[str, dict[str, tuple[str, ...]]] = {
    "derive": {
        "N": ("", "--terms gravity"),
        "links": ("0", "2.5", "many", "1000001", "1_0", "1 --boundary cantilever"),
        "links = -1": ("-1",),
        "boundary": ("3 --boundary glued",),
        "inertia": ("3 --inertia heavy",),
        "terms": ("3 --terms wind", "3 --terms gravity,gravity", "3 --terms all,none"),
        "target": ("3 --target fortran",),
        "form": ("3 --form sparse", "3 --form dense --target c", "3 --form dense --target both"),
        "--out": ("3 --out /proc/no/such/folder", "3 --out /dev/null/folder"),
        "--colour": ("3 --colour red",),
        "N = '3'": ("3 --scene FREE",),
        "--boundary": ("--boundary free --scene FREE",),
        "--set": ("3 --set rod.mass=1",),
    },
    "run": {
        "scene": ("", "missing.toml", "/dev/zero", f"{ROOT}/scenes/studies/tongues.toml"),
        "target": ("MISSILE --target fortran",),
        "--out": ("MISSILE --out MISSILE", "MISSILE --out /proc/rodgen"),
        "--step": ("missing.toml --step abc",),
        "--step = 0.1": ("MISSILE --step 0.1",),
        "integrate.method": ("MISSILE --method magic",),
        "integrate.output_every": ("MISSILE --output-every 0",),
        "--atol = 1e-07": ("MISSILE --method rk4 --step 0.01 --atol 1e-7",),
        "--format = 'jpg'": ("MISSILE --format jpg",),
        "--width": tuple(f"MISSILE --width {x}" for x in ("3.3", "in", "0.1in", "1e3in", "9m")),
        "--checkpoint": tuple(f"MISSILE --checkpoint {x}" for x in ("nan", "inf", "-1", "0")),
    },
    "show": {"scene": ("missing.toml",), "parameters.idle = 3": ("FREE --set parameters.idle=3",)},
    "check": {
        "module": ("missing.py", f"{ROOT}/tests/palette.py"),
        "--seed": ("missing.py --seed -1",),
    },
    "fly": {"fly": ("",)},
    "animate": {
        "--out": ("run.nc",),
        "file": ("nowhere.nc --out film.gif", "MISSILE --out film.gif"),
    },
    "view": {
        "scene": ("nothing.toml --no-open",),
        "--folder = 'nowhere'": ("MISSILE --folder nowhere --no-open",),
        "--port = 70000": ("MISSILE --port 70000 --no-open",),
        "--host = '256.1.1.1'": ("MISSILE --host 256.1.1.1 --no-open",),
        "SCENE": (f"DAMPED --from {ROOT}/README.md",),
        "--point": ("DAMPED --point 3",),
    },
    "new": {"name": ("../other",), "example": ("more --like rocket", "more --like forgetting")},
    "modes": {
        "scene": ("", "missing.toml"),
        "count = 0": ("FREE --count 0",),
        "--count": ("FREE --count many",),
        "t = nan": ("FREE --t nan",),
        "t = 11.0": ("FREE --t 11",),
        "after = 11.0": ("FREE --after 11",),
    },
    "static": {
        "t = inf": ("FREE --t inf",),
        "imperfection": ("PUSHED --imperfection 0", "PUSHED --imperfection nan"),
        "--imperfection": ("DAMPED --all --imperfection 0.1",),
    },
    "critical": {
        "loads.follower": ("FREE",),
        "load = 'wind'": ("PUSHED --load wind",),
        "--bounds": tuple(f"PUSHED --bounds {x}" for x in ("nan,", ",inf", "5", "a,b", "1,2,3")),
        "bounds": ("PUSHED --bounds 5,5",),
        "end = 'middle'": ("PUSHED --end middle",),
        "50": ("PUSHED 50",),
        "simulate": tuple(f"PUSHED --simulate {x}" for x in ("0", "-5", "nan")),
        "simulate = 5.0": ("PUSHED --load all --simulate 5",),
    },
    "branch": {
        "loads.tip.q": (f"{BRANCH} loads.tip.q",),
        "--bounds": tuple(
            f"DAMPED --vary loads.tip.x{x}" for x in ("", " --bounds 0,", " --bounds 0,nan")
        ),
        "branch_point = 1": (f"{BRANCH} loads.tip.x --branch-point 1",),
        "start = 11.0": (f"{BRANCH} loads.tip.x --start 11",),
        "--point": (f"{BRANCH} loads.tip.x --point 3",),
        "step = 0.0": (f"{BRANCH} loads.tip.x --step 0",),
        "file": (f"{BRANCH} loads.tip.x --resume {ROOT}/README.md",),
    },
    "boundary": {
        "--vary": ("DAMPED --vary loads.tip.x",),
        "vary": ("DAMPED --vary loads.tip.x,loads.tip.x",),
        "--bounds = '2'": ("DAMPED --vary loads.follower.force,rod.mass --bounds 2",),
        "--bounds": ("DAMPED --vary loads.follower.force,rod.mass" + 3 * " --bounds 0,2",),
    },
    "cycle": {
        "segments = 0": ("DAMPED --segments 0",),
        "method = 'hand'": ("DAMPED --method hand",),
        "multipliers = 4": ("DAMPED --multipliers 4 --method shooting",),
        "--point": ("DAMPED --point 3",),
        "from = 'nothing.nc'": ("DAMPED --from nothing.nc",),
    },
    "cycle-branch": {
        "--bounds": (f"DAMPED {FORCE}", f"DAMPED {FORCE} --bounds 18"),
        "--vary": ("DAMPED --bounds 18,20 --branch-point 1",),
        "start = 'rest'": (f"DAMPED {FORCE} --bounds 18,20 --start rest",),
        "--point": (
            f"DAMPED {FORCE} --bounds 18,20 --point 3",
            f"DAMPED {FORCE} --bounds 1,2 --from a.nc",
        ),
        "file": (f"DAMPED {FORCE} --bounds 18,20 --from nothing.nc --point 1",),
        "--from": (f"DAMPED {FORCE} --bounds 18,20 --from a.nc --resume b.nc",),
    },
    "nonlinear-mode": {
        "--energy": ("DAMPED", "DAMPED --energy much"),
        "mode": ("DAMPED --mode 1 --energy 1",),
    },
    "study": {
        "study": ("missing.toml", "MISSILE"),
        "--time-limit = 0.0": (f"{ROOT}/scenes/studies/tongues.toml --time-limit 0",),
    },
}
# What is well asked for and has no answer.
UNANSWERED = (
    "critical DAMPED --bounds ,30 --out new",
    "critical DAMPED --bounds ,30 --json",
    "critical DAMPED --bounds 200,210",
    "critical TURNED",
    "modes TURNED",
    f"cycle-branch DAMPED {FORCE} --bounds 1,2",
)


Given = Callable[[str], list[object]]


@pytest.fixture
def given(write: Write, column: Write) -> Given:
    """The words of a line, with files of scenes for their names."""

    def of(word: str) -> object:
        if word in SCENES:
            return write(*SCENES[word])
        return column(*LOADED[word]) if word in LOADED else {"MISSILE": MISSILE}.get(word, word)

    return lambda line: [of(word) for word in line.split()]


@pytest.mark.parametrize("command", REFUSED)
def test_bad_input_exits_2_in_one_line(
    refused: Run, given: Given, work: Path, command: str
) -> None:
    if command == "view":
        pytest.importorskip("rodgen_live", reason="the live view is not installed")
    for field, lines in REFUSED[command].items():
        for line in lines:
            refused(command, *given(line), field=field)
    assert list(work.iterdir()) == []


@pytest.mark.parametrize("line", UNANSWERED)
def test_what_has_no_answer_exits_3_in_one_line(
    refused: Run, given: Given, work: Path, line: str
) -> None:
    refused(*given(line), status=3)
    assert list(work.iterdir()) == []


def test_check_runs_nothing_but_generated_python(refused: Run, work: Path) -> None:
    """Neither what has another name or ending, nor C, nor a module that was cut off."""
    generated = ROOT / "generated"
    whole = (generated / "rod_free_n5.py").read_text(encoding="utf-8")
    texts = {"marker.toml": "", "marker.py": "", "rod_free_n5.txt": whole}
    texts |= {f"rod_free_n5_c.{e}": (generated / f"rod_free_n5_c.{e}").read_text() for e in "ch"}
    for name, text in texts.items():
        Path(name).write_text(f"{text}open('was run', 'w')\n", encoding="utf-8")
        refused("check", name, field=f"module = '{name}'")
        assert not Path("was run").exists()
    for lines in (5, 40, 150, 200):
        cut = Path("rod_free_n5.py")
        cut.write_text("\n".join(whole.splitlines()[:lines]) + "\n", encoding="utf-8")
        refused("check", cut, field="module")


def test_file_that_cannot_be_read_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = tmp_path / "none" / "file.txt"
    with pytest.raises(SystemExit) as ended, report_errors():
        missing.read_text(encoding="utf-8")
    assert ended.value.code == 2
    assert str(missing) in capsys.readouterr().err
