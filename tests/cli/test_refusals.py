"""What commands refuse: a line that names what was given, status 2 or 3, and nothing written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rodgen.cli.errors import reported
from tests.cli.conftest import Run

ROOT = Path(__file__).parents[2]
MISSILE = str(ROOT / "scenes" / "missile.toml")
# Command and arguments by what is said, with the status 2.
BAD: dict[str, list[str]] = {
    "links": [
        *("derive", "derive 0", "derive 2.5", "derive many", "derive 1000001", "derive 1_0"),
        *("derive 1 --boundary cantilever", "derive 0 --boundary pinned"),
    ],
    "links = -1": ["derive -1"],
    "boundary": ["derive 3 --boundary glued"],
    "inertia": ["derive 3 --inertia heavy"],
    "terms": [f"derive 3 --terms {terms}" for terms in ("wind", "gravity,gravity", "all,none")],
    "target": ["derive 3 --target fortran", f"run {MISSILE} --target fortran"],
    "form": ["derive 3 --form sparse"],
    "form = 'dense'": [f"derive 3 --form dense --target {target}" for target in ("c", "both")],
    "--out": [
        *("derive 3 --out /proc/no/such/folder", "derive 3 --out /dev/null/folder"),
        *("thesis --out /dev/null/folder", f"run {MISSILE} --out {MISSILE}"),
        *(f"run {MISSILE} --out /proc/rodgen", "animate run.nc"),
    ],
    "--colour": ["derive 3 --colour red"],
    "--step": ["run missing.toml --step abc"],
    "integrate.step = -1": [f"run {MISSILE} --step -1 --method rk4"],
    "--step = 0.1": [f"run {MISSILE} --step 0.1"],
    "integrate.method": [f"run {MISSILE} --method magic"],
    "integrate.span = [1.0, 0.0]": [f"run {MISSILE} --span 1 0"],
    "integrate.output_every": [f"run {MISSILE} --output-every 0"],
    "rtol": [f"run {MISSILE} --rtol nan"],
    "--atol = 1e-07": [f"run {MISSILE} --method rk4 --step 0.01 --atol 1e-7"],
    "--checkpoint": [f"run {MISSILE} --checkpoint {given}" for given in ("nan", "inf", "-1", "0")],
    "scene": ["run missing.toml", "show missing.toml", "run"],
    "this is a device": ["run /dev/zero"],
    "a file that is there": ["check missing.py"],
    "module": [f"check {ROOT / 'tests' / 'palette.py'}"],
    "--seed": ["check missing.py --seed -1"],
    "fly": ["fly"],
    "a netcdf file that can be read": [
        *("animate nowhere.nc --out film.gif", f"animate {MISSILE} --out film.gif"),
    ],
    "scene = 'nothing.toml'": ["view nothing.toml --no-open"],
    "--folder = 'nowhere'": [f"view {MISSILE} --folder nowhere --no-open"],
    "--port = 70000": [f"view {MISSILE} --port 70000 --no-open"],
    "--host = '256.1.1.1'": [f"view {MISSILE} --host 256.1.1.1 --no-open"],
}


@pytest.mark.parametrize(
    ("says", "line"),
    [
        pytest.param(says, line, id=line.replace(f"{ROOT}/", ""))
        for says, lines in BAD.items()
        for line in lines
    ],
)
def test_bad_input_exits_2_in_one_line(refused: Run, tmp_path: Path, says: str, line: str) -> None:
    if line.startswith("view"):
        pytest.importorskip("nicegui", reason="the extra view is not installed")
    refused(*line.split(), says=says, cwd=tmp_path)
    assert list(tmp_path.iterdir()) == []


PUSHED = "[loads.follower]\nforce = 10.0"
SCENES: dict[str, tuple[Any, ...]] = {
    "FREE": ("", 4, "free"),
    "PUSHED": (PUSHED, 4),
    "TURNED": (f"{PUSHED}\nangle = 0.3", 4, "free"),
    "LOOSE": (PUSHED, 4, "pinned"),
}
UNANSWERED = [
    ("modes FREE --count 0", 2, "count = 0"),
    ("modes FREE --count -3", 2, "count = -3"),
    ("modes FREE --count many", 2, "--count"),
    ("modes FREE --t nan", 2, "--t = nan"),
    ("modes FREE --t 11", 2, "t = 11.0: must be a time in the span"),
    ("modes missing.toml", 2, "missing.toml"),
    ("modes", 2, "SCENE"),
    ("static FREE --t inf", 2, "--t = inf"),
    ("static FREE", 2, "nothing holds a free rod"),
    ("static PUSHED --imperfection 0", 2, "imperfection = 0.0"),
    ("static PUSHED --imperfection nan", 2, "imperfection = nan"),
    ("critical FREE", 2, "loads.follower"),
    ("critical PUSHED --highest 50", 3, "between 0 and 50 N"),
    ("critical PUSHED --lowest 200 --highest 210", 3, "unstable already at"),
    ("critical PUSHED --lowest 9 --highest 3", 2, "highest = 3.0"),
    ("critical PUSHED --lowest nan", 2, "--lowest = nan"),
    ("critical PUSHED --highest inf", 2, "--highest = inf"),
    ("critical PUSHED --highest 5e-324", 2, "highest = 5e-324"),
    ("critical PUSHED --load wind", 2, "load = 'wind'"),
    ("critical PUSHED --load tip", 2, "loads.tip"),
    ("critical PUSHED --load all --simulate 5", 2, "--simulate = 5.0"),
    ("critical PUSHED --end middle", 2, "end = 'middle'"),
    ("critical PUSHED 50", 2, "unexpected extra argument"),
    *((f"critical PUSHED --simulate {s}", 2, f"--simulate = {float(s)}") for s in (0, -5, "nan")),
    ("critical TURNED", 3, "no steady state"),
    ("modes TURNED", 3, "no steady state"),
    ("static LOOSE", 3, "no equilibrium found"),
]


@pytest.mark.parametrize("as_json", [False, pytest.param(True, marks=pytest.mark.nightly)])
@pytest.mark.parametrize(("line", "status", "says"), UNANSWERED, ids=lambda x: str(x))
def test_what_has_no_answer_ends_in_one_line(
    refused: Run,
    write: Callable[..., Path],
    tmp_path: Path,
    line: str,
    status: int,
    says: str,
    as_json: bool,
) -> None:
    given = [write(*SCENES[word]) if word in SCENES else word for word in line.split()]
    (tmp_path / "work").mkdir()
    options = ["--json"] * as_json
    refused(*given, *options, says=says, status=status, cwd=tmp_path / "work")
    assert list((tmp_path / "work").iterdir()) == []


@pytest.mark.parametrize(
    "name", ["marker.toml", "marker.py", "rod_free_n5_c.c", "rod_free_n5_c.h", "rod_free_n5.txt"]
)
def test_check_runs_nothing_but_generated_python(refused: Run, tmp_path: Path, name: str) -> None:
    marker = tmp_path / "was run"
    made = ROOT / "generated" / name
    source = made.with_name("rod_free_n5.py") if name.endswith(".txt") else made
    text = source.read_text(encoding="utf-8") if source.is_file() else ""
    (tmp_path / name).write_text(f"{text}open({str(marker)!r}, 'w')\n", encoding="utf-8")
    refused("check", name, cwd=tmp_path, says="a .py that rodgen derive wrote")
    assert not marker.exists()


@pytest.mark.parametrize("lines", [5, 40, 150, 200])
def test_check_refuses_a_module_that_was_cut_off(refused: Run, tmp_path: Path, lines: int) -> None:
    whole = (ROOT / "generated" / "rod_free_n5.py").read_text(encoding="utf-8")
    cut = tmp_path / "cut.py"
    cut.write_text("\n".join(whole.splitlines()[:lines]) + "\n", encoding="utf-8")
    refused("check", cut, says="module")


def test_file_that_cannot_be_read_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = tmp_path / "none" / "file.txt"
    with pytest.raises(SystemExit) as ended, reported():
        missing.read_text(encoding="utf-8")
    assert ended.value.code == 2
    assert f"{str(missing)!r}: No such file or directory" in capsys.readouterr().err
