"""rodgen modes, static and critical: what they print, draw and refuse."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.special import jn_zeros

import rodgen
from rodgen.analyse import growth
from rodgen.analyse.columns import beck
from rodgen.analyse.critical import family_of
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.onset import digits
from rodgen.cli import main
from rodgen.view.analysis_pictures import stability_curves

ROOT = Path(__file__).parents[2]
LENGTH, STIFFNESS = 5.0, 100.0


class Done(NamedTuple):
    status: int
    out: str
    err: str


Call = Callable[..., Done]
Write = Callable[..., Path]


@pytest.fixture
def call(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Call:
    """Run a command in this process, in an empty folder."""
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")

    def run(*arguments: object) -> Done:
        monkeypatch.setattr(sys, "argv", ["rodgen", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            main()
        return Done(int(end.value.code or 0), *capsys.readouterr())

    return run


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """A scene in a file; loads: text of the tables of loads."""

    def make(loads: str = "", links: int = 20, boundary: str = "clamped", **rod: Any) -> Path:
        table = {"mass": 20.0, "bending_stiffness": STIFFNESS, **rod}
        keys = "\n".join(f"{k} = {json.dumps(v)}" for k, v in table.items())
        path = tmp_path / "rod.toml"
        path.write_text(
            f'name = "rod"\n[rod]\nlinks = {links}\nlength = {LENGTH}\nboundary = "{boundary}"\n'
            f"{keys}\n{loads}\n",
            encoding="utf-8",
        )
        return path

    return make


PUSHED = "[loads.follower]\nforce = 10.0"
HANGING = "[loads.gravity]\ng = 9.81"


def _strict(done: Done) -> dict[str, Any]:
    """One JSON object on one line, without NaN and Infinity, and nothing written."""

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    assert done.status == 0, done.err
    assert done.out.count("\n") == 1
    assert list(Path.cwd().iterdir()) == []
    found: dict[str, Any] = json.loads(done.out, parse_constant=refuse)
    return found


def _picture(name: str) -> None:
    """It is there, alone, and whole."""
    (picture,) = (Path.cwd() / "results" / "rod").iterdir()
    assert picture.name == name
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size > 10_000


def test_modes_of_a_hanging_chain(call: Call, write: Write) -> None:
    chain = write(HANGING, 50, "pinned", bending_stiffness=0.0, inertia="lumped")
    found = _strict(call("modes", chain, "--count", 3, "--json"))
    modes = rodgen.natural_modes(rodgen.Scene.from_toml(chain), 3)
    assert found["frequencies"] == modes.frequencies.tolist()
    # J0(2 omega sqrt(L/g)) = 0; the first is off by about (1/n)^2 / 3.
    exact = jn_zeros(0, 1)[0] / (4 * np.pi) * np.sqrt(9.81 / LENGTH)
    assert found["frequencies"][0] == pytest.approx(exact, rel=1 / 50**2)


def test_modes_with_damping_as_table_and_picture(call: Call, write: Write) -> None:
    scene = write("[loads.internal_damping]\ncoefficient = 5.0", 8)
    (note,) = _strict(call("modes", scene, "--count", 4, "--json"))["notes"]
    done = call("modes", scene, "--count", 4)
    assert (done.status, done.err) == (0, "")
    assert "damping ratio" in done.out
    modes = rodgen.natural_modes(rodgen.Scene.from_toml(scene), 4)
    assert all(f"{f:.10g}" in done.out for f in modes.frequencies)
    assert "straight, at rest" in done.out
    assert "coefficient = 5 at n = 8 is 20 at n = 16" in note
    assert f"note: {note}" in done.out
    _picture("modes.png")


def test_modes_of_a_free_rod_say_what_is_left_out(call: Call, write: Write) -> None:
    done = call("modes", write(PUSHED, 6, "free"), "--t", "2")
    assert "growth" not in done.out
    assert done.out.splitlines()[0] == "rod: loads as at t = 2 s"
    assert "steadily accelerating." in done.out
    assert "3 rigid-body motions" in done.out


def test_modes_warn_of_one_that_grows(call: Call, write: Write) -> None:
    """Beyond the onset of flutter at 80 N."""
    done = call("modes", write("[loads.follower]\nforce = 90.0"), "--count", 3, "--json")
    assert max(_strict(done)["growth"]) > 0
    assert "warning: this state is unstable: mode" in done.err
    assert len(done.err.splitlines()) == 1


def test_modes_count_overdamped_motions(call: Call, write: Write) -> None:
    """The damping ratio is proportional to the frequency: the fast ones no longer oscillate."""
    done = call("modes", write("[loads.internal_damping]\ncoefficient = 50.0", 8), "--count", 2)
    assert "overdamped motions among those computed" in done.out


DRAG = """[loads.external_damping]
coefficient = 0.5
fin_factor = {nose = 1.0, body = 1.0, tail = 20.0}"""
FLIES = "[initial]\nvelocity = [-7.0, 0.0]"


def test_modes_in_flight(call: Call, write: Write) -> None:
    """The first line says that a rod is taken at rest; at a speed nothing has to be said."""
    scene = write(f"{PUSHED}\n{DRAG}", 3, "free")
    done = call("modes", scene, "--count", 2)
    assert done.out.splitlines()[0].startswith("note: linearised about a rod at rest")
    _picture("modes.png")
    (Path.cwd() / "results" / "rod" / "modes.png").unlink()
    (Path.cwd() / "results" / "rod").rmdir()
    (Path.cwd() / "results").rmdir()
    still = _strict(call("modes", scene, "--json"))
    assert still["speed"] == 0.0
    assert "at rest" in still["notes"][0]
    given = _strict(call("modes", scene, "--speed", 7, "--json"))
    assert given["speed"] == 7.0
    assert not any("at rest" in note for note in given["notes"])
    scene = write(f"{PUSHED}\n{DRAG}\n{FLIES}", 3, "free")
    for after in ((), ("--after", 0)):
        flies = _strict(call("modes", scene, *after, "--json"))
        assert flies["frequencies"] == given["frequencies"]
        assert "flying at 7 m/s" in flies["state"]
    assert "after = 11.0" in call("modes", scene, "--after", 11).err


def test_critical_force_in_flight(
    call: Call, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same speed for eigenvalues and for simulations; where they differ, it is said."""
    found: dict[str, Any] = {}

    def half(scene: rodgen.Scene, **given: Any) -> growth.SimulatedCritical:
        found.update(given)
        return growth.SimulatedCritical(50.0, 49.0, 51.0, 5.0, None, 9, 1.0, "c", given["speed"])

    monkeypatch.setenv("CC", "no-such-compiler")  # nothing runs
    monkeypatch.setattr(growth, "simulated_critical_force", half)
    scene = write(f"{PUSHED}\n{DRAG}", 3, "free")
    done = call("critical", scene, "--speed", 20, "--simulate", 5, "--json")
    given = json.loads(done.out)
    assert (given["speed"], found["speed"]) == (20.0, 20.0)
    assert not any("at rest" in note for note in given["notes"])
    # Divergence of three links, by hand: 54 EI/L^2.
    assert given["factor"] == pytest.approx(54.0, rel=1e-9)
    assert "not to be trusted" in given["doubt"]
    assert given["doubt"] in done.err


def test_static_deflection(call: Call, write: Write) -> None:
    scene = write("[loads.tip]\ny = 0.01", 40)
    found = _strict(call("static", scene, "--json"))
    rest = rodgen.static_equilibrium(rodgen.Scene.from_toml(scene))
    assert found["tip"] == rest.tip.tolist()
    assert found["phi"] == rest.phi.tolist()
    assert found["stable"] is True
    # F L^3 / (3 EI); off by 1 / (2 n^2) of it, and by (deflection / length)^2 = 7e-6.
    assert found["tip"][1] == pytest.approx(0.01 * LENGTH**3 / (3 * STIFFNESS), rel=1e-3)


def test_static_with_all_loads_as_table_and_picture(call: Call, write: Write) -> None:
    loads = f'{PUSHED}\n{HANGING}\n[loads.tip]\nx = "3*t"\ny = 5.0'
    done = call("static", write(loads, 10), "--t", 1.5)
    assert (done.status, done.err) == (0, "")
    assert done.out.splitlines()[0] == "rod: loads as at t = 1.5 s"
    _picture("static.png")


def test_static_warns_of_an_unstable_equilibrium(call: Call, write: Write) -> None:
    """Ten times Euler's load pi^2 EI / (4 L^2) = 9.87 N, exactly along the rod."""
    scene = write("[loads.tip]\nx = -100.0", 5)
    done = call("static", scene, "--json")
    found = _strict(done)
    assert (found["stable"], found["instability"]) == (False, "divergence")
    assert "warning: this equilibrium is unstable (divergence)" in done.err
    assert "--imperfection 0.01 looks for a stable one" in done.err
    assert len(done.err.splitlines()) == 1
    done = call("static", scene, "--imperfection", "0.01", "--json")
    assert _strict(done)["stable"] is True
    assert _strict(done)["tip"][1] > 0.1 * LENGTH
    assert done.err == ""


def test_static_offers_no_imperfection_against_flutter(call: Call, write: Write) -> None:
    done = call("static", write("[loads.follower]\nforce = 90.0", 5))
    assert "unstable (flutter)" in done.err
    assert "--imperfection" not in done.err
    assert "NO (flutter)" in done.out


@pytest.mark.parametrize("command", ["modes", "static", "critical"])
def test_first_line_says_when_and_what_is_zero_then(call: Call, write: Write, command: str) -> None:
    """A tip load that begins after a second; the follower force is no matter for `critical`."""
    loads = '[loads.follower]\nforce = "t"\n[loads.tip]\ny = "max(0, t - 1)"'
    scene = write(f"{loads}\n[integrate]\nspan = [0.0, 8.0]", 3)
    quiet = ["loads.tip.y"] if command == "critical" else ["loads.follower.force", "loads.tip.y"]
    for t, expected in ((0.0, quiet), (4.0, [])):
        found = _strict(call(command, scene, "--t", t, "--json"))
        assert (found["t"], found["silent"]) == (t, expected)
    first = call(command, scene).out.splitlines()[0]
    assert "loads as at t = 0 s, the start of the span" in first
    assert f"where {' and '.join(quiet)} " in first


def test_critical_force_of_becks_column(call: Call, write: Write) -> None:
    scene = write(PUSHED)
    found = _strict(call("critical", scene, "--json"))
    assert found["force"] == rodgen.critical_force(rodgen.Scene.from_toml(scene)).force
    assert (found["kind"], found["modes"]) == ("flutter", [1, 2])
    # The continuum; 20 links with this clamp are 0.7 % below.
    force, frequency = beck().dimensional(mass=20, length=LENGTH, bending_stiffness=STIFFNESS)
    assert found["force"] == pytest.approx(force, rel=0.01)
    assert found["frequency"] == pytest.approx(frequency, rel=0.01)


def test_critical_force_as_table_and_picture(call: Call, write: Write) -> None:
    scene = write(f"{PUSHED}\n[loads.internal_damping]\ncoefficient = 0.5", 6)
    done = call("critical", scene, "--highest", 300)
    assert (done.status, done.err) == (0, "")
    found = rodgen.critical_force(rodgen.Scene.from_toml(scene), highest=300)
    assert f"{digits(found.force, found.error)} N" in done.out
    assert len(found.notes) == 1
    assert f"note: {found.notes[0]}" in done.out
    low, high, forces = found.searched
    assert f"{low:g} to {high:g} N at {forces} forces" in done.out
    _picture("critical.png")


def test_window_of_a_heavy_column(call: Call, write: Write) -> None:
    """Upright, held up by thrust: too little of it, and it buckles."""
    scene = write(f"{HANGING.replace('9.81', '1.8')}\n{PUSHED}", 4, clamp_angle=np.pi / 2)
    found = _strict(call("critical", scene, "--windows", "--json"))
    ((low, high),) = found["stable"]
    assert high == found["force"]
    assert _strict(call("critical", scene, "--end", "lower", "--json"))["force"] == low
    assert "stable from" in call("critical", scene).err
    weight = _strict(call("critical", scene, "--load", "gravity", "--json"))
    assert (weight["unit"], weight["kind"]) == ("m/s^2", "divergence")
    assert weight["force"] > 1.8  # 10 N hold up more than the column has
    done = call("critical", scene, "--windows")
    assert f"{low:.10g} to {high:.10g} N" in done.out
    assert "grows already" in done.out
    assert "M g L^2/EI" in call("critical", scene, "--load", "gravity").out
    _picture("critical.png")


def test_divergence_has_no_frequency(call: Call, write: Write) -> None:
    """Pinned: tan x = x, x^2 = P L^2/EI = 20.19; 20 links are 0.4 % below."""
    found = _strict(call("critical", write(PUSHED, 20, "pinned"), "--json"))
    assert (found["kind"], found["frequency"]) == ("divergence", 0.0)
    assert found["factor"] == pytest.approx(4.493409457909064**2, rel=0.01)


def test_picture_of_a_bent_rod(call: Call, write: Write) -> None:
    """A force at an angle: the state, and with it the mass matrix, changes with the force."""
    done = call("critical", write(f"{PUSHED}\nangle = 0.2", 5))
    assert "static equilibrium" in done.out
    _picture("critical.png")


@pytest.mark.parametrize("damping", [0.01, 0.5])
def test_picture_shows_where_growth_begins(write: Write, damping: float) -> None:
    """Strong flutter, from 430 N on, would make a line of what happens at 348 N."""
    path = write(f"{PUSHED}\n[loads.internal_damping]\ncoefficient = {damping}", 20, "free")
    scene = rodgen.Scene.from_toml(path)
    found, family = rodgen.critical_force(scene), family_of(scene)
    low, high = stability_curves(found, family).axes[1].get_ylim()
    assert 0.15 < high / (high - low) < 0.85
    before, after = np.nanmax(family.elastic(found.force * np.array([0.0, 1.1])).real, axis=1)
    assert low < before < 0
    assert 0 < after < high < 2 * max(after, -before)


def test_critical_force_by_simulation(call: Call, write: Write) -> None:
    """Growth is measured: in a short time, too, the force is hardly too large."""
    found = _strict(call("critical", write(PUSHED, 2), "--simulate", 20, "--json"))
    simulated = found["simulated"]
    assert simulated["span"] == 20.0
    assert simulated["low"] < simulated["force"] < simulated["high"]
    assert simulated["growth"] is None
    # Bisection ends at 1e-4 of the force; growth of 1 % in 20 s asks for a surplus of about that.
    assert simulated["force"] == pytest.approx(found["force"], rel=1e-3)
    assert found["doubt"] is None


def test_force_by_eigenvalues_outlives_a_simulation_without_a_result(
    call: Call, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nothing(*_: object, **__: object) -> None:
        raise AnalysisError("no motion grows")

    monkeypatch.setattr(growth, "simulated_critical_force", nothing)
    scene = write(PUSHED, 2)
    done = call("critical", scene, "--simulate", 5, "--json")
    assert done.status == 3
    assert json.loads(done.out)["force"] > 0
    assert json.loads(done.out)["simulated"] is None
    assert done.err == "rodgen: by simulation: no motion grows\n"
    done = call("critical", scene, "--simulate", 5)
    assert done.status == 3
    assert "critical force" in done.out
    assert "no motion grows" in done.out
    assert done.err == "rodgen: by simulation: no motion grows\n"
    _picture("critical.png")


def test_simulation_without_a_compiler_says_so(
    call: Call, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    done = call("critical", write(PUSHED, 2), "--simulate", 0.5, "--json")
    assert "NumPy, which takes long" in done.err.splitlines()[0]


BAD = [
    (("modes", "SCENE", "--count", "0"), 2, "count = 0"),
    (("modes", "SCENE", "--count", "-3"), 2, "count = -3"),
    (("modes", "SCENE", "--count", "many"), 2, "--count"),
    (("modes", "SCENE", "--t", "nan"), 2, "--t = nan"),
    (("modes", "SCENE", "--t", "11"), 2, "t = 11.0: must be a time in the span"),
    (("modes", "missing.toml"), 2, "missing.toml"),
    (("modes",), 2, "SCENE"),
    (("static", "SCENE", "--t", "inf"), 2, "--t = inf"),
    (("static", "SCENE"), 2, "nothing holds a free rod"),
    (("static", "PUSHED", "--imperfection", "0"), 2, "imperfection = 0.0"),
    (("static", "PUSHED", "--imperfection", "nan"), 2, "imperfection = nan"),
    (("critical", "SCENE"), 2, "loads.follower"),
    (("critical", "PUSHED", "--highest", "50"), 3, "between 0 and 50 N"),
    (("critical", "PUSHED", "--lowest", "200", "--highest", "210"), 3, "unstable already at"),
    (("critical", "PUSHED", "--lowest", "9", "--highest", "3"), 2, "highest = 3.0"),
    (("critical", "PUSHED", "--lowest", "nan"), 2, "--lowest = nan"),
    (("critical", "PUSHED", "--highest", "inf"), 2, "--highest = inf"),
    (("critical", "PUSHED", "--highest", "5e-324"), 2, "highest = 5e-324"),
    (("critical", "PUSHED", "--load", "wind"), 2, "load = 'wind'"),
    (("critical", "PUSHED", "--load", "tip"), 2, "loads.tip"),
    (("critical", "PUSHED", "--load", "all", "--simulate", "5"), 2, "--simulate = 5.0"),
    (("critical", "PUSHED", "--end", "middle"), 2, "end = 'middle'"),
    (("critical", "PUSHED", "50"), 2, "unexpected extra argument"),
    (("critical", "PUSHED", "--simulate", "0"), 2, "--simulate = 0.0"),
    (("critical", "PUSHED", "--simulate", "-5"), 2, "--simulate = -5.0"),
    (("critical", "PUSHED", "--simulate", "nan"), 2, "--simulate = nan"),
    (("critical", "TURNED"), 3, "no steady state"),
    (("modes", "TURNED"), 3, "no steady state"),
    (("static", "LOOSE"), 3, "no equilibrium found"),
]


@pytest.mark.parametrize("as_json", [False, True], ids=["table", "json"])
@pytest.mark.parametrize(("arguments", "status", "words"), BAD, ids=str)
def test_what_has_no_answer_ends_in_one_line(
    call: Call, write: Write, arguments: tuple[str, ...], status: int, words: str, as_json: bool
) -> None:
    scenes: dict[str, tuple[Any, ...]] = {
        "SCENE": ("", 4, "free"),
        "PUSHED": (PUSHED, 4),
        "TURNED": (f"{PUSHED}\nangle = 0.3", 4, "free"),
        "LOOSE": (PUSHED, 4, "pinned"),
    }
    given = [write(*scenes[a]) if a in scenes and len(arguments) > 1 else a for a in arguments]
    done = call(*given, *["--json"] * as_json)
    assert done.status == status, done.err
    assert words in done.err
    assert len(done.err.splitlines()) == 1
    assert done.out == ""
    assert list(Path.cwd().iterdir()) == []


@pytest.mark.parametrize("command", ["modes", "static", "critical"])
def test_folder_that_cannot_be_written(call: Call, write: Write, command: str) -> None:
    """It is found before anything is computed and printed; with --json none is needed."""
    scene = write(PUSHED, 3)
    done = call(command, scene, "--out", scene)
    assert done.status == 2
    assert "--out" in done.err
    assert len(done.err.splitlines()) == 1
    assert done.out == ""
    assert _strict(call(command, scene, "--out", scene, "--json"))


def test_no_empty_folder_stays_behind(call: Call, write: Write) -> None:
    kept = Path("kept")
    kept.mkdir()
    done = call("critical", write(PUSHED, 4), "--highest", 50, "--out", kept / "new")
    assert done.status == 3
    assert list(Path.cwd().rglob("*")) == [kept.absolute()]


def test_scenes_to_start_from(call: Call) -> None:
    """Numbers in their comments: 80.1 N, 0.2681 Hz."""
    column = _strict(call("critical", ROOT / "scenes" / "becks_column.toml", "--json"))
    assert column["force"] == pytest.approx(80.1, abs=0.05)
    chain = _strict(call("modes", ROOT / "scenes" / "hanging_chain.toml", "--json"))
    assert chain["frequencies"][0] == pytest.approx(0.2681, abs=1e-4)
