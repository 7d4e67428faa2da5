"""rodgen modes, static and critical: what they print, draw and refuse."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import jn_zeros

import rodgen
from rodgen.analyse import growth
from rodgen.analyse.critical import family_of
from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.onset import digits
from rodgen.analyse.references.columns import beck
from rodgen.show.analysis_pictures import stability_curves
from tests.cli.conftest import LENGTH, STIFFNESS, Run

ROOT = Path(__file__).parents[2]


Call = Callable[..., Any]
Write = Callable[..., Path]


@pytest.fixture
def call(rodgen: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Call:
    """Run a command in an empty folder."""
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    return rodgen


PUSHED = "[loads.follower]\nforce = 10.0"
HANGING = "[loads.gravity]\ng = 9.81"


def _strict(done: Any) -> dict[str, Any]:
    """One JSON object on one line, without NaN and Infinity, and nothing written."""

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    assert done.returncode == 0, done.stderr
    assert done.stdout.count("\n") == 1
    assert list(Path.cwd().iterdir()) == []
    found: dict[str, Any] = json.loads(done.stdout, parse_constant=refuse)
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
    assert (done.returncode, done.stderr) == (0, "")
    assert "damping ratio" in done.stdout
    modes = rodgen.natural_modes(rodgen.Scene.from_toml(scene), 4)
    assert all(f"{f:.10g}" in done.stdout for f in modes.frequencies)
    assert "straight, at rest" in done.stdout
    assert "coefficient = 5 at n = 8 is 20 at n = 16" in note
    assert f"note: {note}" in done.stdout
    _picture("modes.png")


def test_modes_warn_of_one_that_grows(call: Call, write: Write) -> None:
    """Beyond the onset of flutter at 80 N."""
    done = call("modes", write("[loads.follower]\nforce = 90.0"), "--count", 3, "--json")
    assert max(_strict(done)["growth"]) > 0
    assert "warning: this state is unstable: mode" in done.stderr
    assert len(done.stderr.splitlines()) == 1


DRAG = """[loads.external_damping]
coefficient = 0.5
fin_factor = {nose = 1.0, body = 1.0, tail = 20.0}"""
FLIES = "[initial]\nvelocity = [-7.0, 0.0]"


def test_modes_in_flight(call: Call, write: Write) -> None:
    """A note says that a rod is taken at rest; at a speed nothing has to be said."""
    scene = write(f"{PUSHED}\n{DRAG}", 3, "free")
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
    assert "after = 11.0" in call("modes", scene, "--after", 11).stderr


def test_critical_force_in_flight(
    call: Call, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Eigenvalues and simulations are of one speed; where their forces differ, it is said."""
    found: dict[str, Any] = {}

    def half(scene: rodgen.Scene, **given: Any) -> growth.SimulatedCritical:
        found.update(given)
        return growth.SimulatedCritical(50.0, 49.0, 51.0, 5.0, None, 9, 1.0, "c", given["speed"])

    monkeypatch.setenv("CC", "no-such-compiler")  # nothing runs
    monkeypatch.setattr(growth, "simulated_critical_force", half)
    scene = write(f"{PUSHED}\n{DRAG}", 3, "free")
    done = call("critical", scene, "--speed", 20, "--simulate", 5, "--json")
    given = json.loads(done.stdout)
    assert (given["speed"], found["speed"]) == (20.0, 20.0)
    assert not any("at rest" in note for note in given["notes"])
    # Divergence of three links, by hand: 54 EI/L^2.
    assert given["factor"] == pytest.approx(54.0, rel=1e-9)
    assert "not to be trusted" in given["doubt"]
    assert given["doubt"] in done.stderr


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
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[0] == "rod: loads as at t = 1.5 s"
    _picture("static.png")


def test_static_warns_of_an_unstable_equilibrium(call: Call, write: Write) -> None:
    """Ten times Euler's load pi^2 EI / (4 L^2) = 9.87 N, exactly along the rod."""
    scene = write("[loads.tip]\nx = -100.0", 5)
    done = call("static", scene, "--json")
    found = _strict(done)
    assert (found["stable"], found["instability"]) == (False, "divergence")
    assert "warning: this equilibrium is unstable (divergence)" in done.stderr
    assert "--imperfection 0.01 looks for a stable one" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    done = call("static", scene, "--imperfection", "0.01", "--json")
    assert _strict(done)["stable"] is True
    assert _strict(done)["tip"][1] > 0.1 * LENGTH
    assert done.stderr == ""


@pytest.mark.parametrize("command", ["modes", "static", "critical"])
def test_when_it_is_and_what_is_zero_then(call: Call, write: Write, command: str) -> None:
    """A tip load that begins after a second; the follower force is no matter for `critical`."""
    loads = '[loads.follower]\nforce = "t"\n[loads.tip]\ny = "max(0, t - 1)"'
    scene = write(f"{loads}\n[integrate]\nspan = [0.0, 8.0]", 3)
    quiet = ["loads.tip.y"] if command == "critical" else ["loads.follower.force", "loads.tip.y"]
    for t, expected in ((0.0, quiet), (4.0, [])):
        found = _strict(call(command, scene, "--t", t, "--json"))
        assert (found["t"], found["silent"]) == (t, expected)


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
    assert (done.returncode, done.stderr) == (0, "")
    found = rodgen.critical_force(rodgen.Scene.from_toml(scene), highest=300)
    assert f"{digits(found.force, found.error)} N" in done.stdout
    assert len(found.notes) == 1
    assert f"note: {found.notes[0]}" in done.stdout
    low, high, forces = found.searched
    assert f"{low:g} to {high:g} N at {forces} forces" in done.stdout
    _picture("critical.png")


def test_window_of_a_heavy_column(call: Call, write: Write) -> None:
    """Upright, held up by thrust: too little of it, and it buckles."""
    scene = write(f"{HANGING.replace('9.81', '1.8')}\n{PUSHED}", 4, clamp_angle=np.pi / 2)
    found = _strict(call("critical", scene, "--windows", "--json"))
    ((low, high),) = found["stable"]
    assert high == found["force"]
    assert _strict(call("critical", scene, "--end", "lower", "--json"))["force"] == low
    assert "stable from" in call("critical", scene).stderr
    weight = _strict(call("critical", scene, "--load", "gravity", "--json"))
    assert (weight["unit"], weight["kind"]) == ("m/s^2", "divergence")
    assert weight["force"] > 1.8  # 10 N hold up more than the column has


def test_picture_shows_where_growth_begins(write: Write) -> None:
    """Strong flutter, from 430 N on, would make a line of what happens at 348 N."""
    path = write(f"{PUSHED}\n[loads.internal_damping]\ncoefficient = 0.5", 20, "free")
    scene = rodgen.Scene.from_toml(path)
    found, family = rodgen.critical_force(scene), family_of(scene)
    low, high = stability_curves(found, family).axes[1].get_ylim()
    assert 0.15 < high / (high - low) < 0.85
    before, after = np.nanmax(family.elastic(found.force * np.array([0.0, 1.1])).real, axis=1)
    assert low < before < 0
    assert 0 < after < high < 2 * max(after, -before)


def test_critical_force_by_simulation(call: Call, write: Write) -> None:
    """Growth is measured: in a short time, too, the force is hardly too large."""
    found = _strict(call("critical", write(PUSHED, 3), "--simulate", 20, "--json"))
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
    assert done.returncode == 3
    assert json.loads(done.stdout)["force"] > 0
    assert json.loads(done.stdout)["simulated"] is None
    assert done.stderr == "rodgen: by simulation: no motion grows\n"


@pytest.mark.parametrize("command", ["modes", "static", "critical"])
def test_folder_that_cannot_be_written(call: Call, write: Write, command: str) -> None:
    """It is found before anything is computed and printed; with --json none is needed."""
    scene = write(PUSHED, 3)
    done = call(command, scene, "--out", scene)
    assert done.returncode == 2
    assert "--out" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""
    assert _strict(call(command, scene, "--out", scene, "--json"))


def test_no_empty_folder_stays_behind(call: Call, write: Write) -> None:
    kept = Path("kept")
    kept.mkdir()
    done = call("critical", write(PUSHED, 4), "--highest", 50, "--out", kept / "new")
    assert done.returncode == 3
    assert list(Path.cwd().rglob("*")) == [kept.absolute()]
