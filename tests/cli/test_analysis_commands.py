"""rodgen modes, static and critical: what they print, draw and warn of."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse import growth
from rodgen.analyse.critical import family_of
from rodgen.analyse.errors import AnalysisError
from rodgen.show.analysis_pictures import stability_curves
from tests.cli.conftest import LENGTH, Run, Write, numbers

PUSHED = "[loads.follower]\nforce = 10.0"
DRAG = """[loads.external_damping]
coefficient = 0.5
fin_factor = {nose = 1.0, body = 1.0, tail = 20.0}"""

Call = Callable[..., Any]


@pytest.fixture
def call(rodgen: Run, work: Path) -> Call:
    """Run a command in an empty folder."""
    return rodgen


def _strict(done: Any) -> dict[str, Any]:
    """One JSON object on one line, without NaN and Infinity, and nothing written."""

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    assert done.returncode == 0, done.stderr
    assert done.stdout.count("\n") == 1
    assert list(Path.cwd().iterdir()) == []
    found: dict[str, Any] = json.loads(done.stdout, parse_constant=refuse)
    return found


def _table(done: Any, picture: str, notes: Any = ()) -> list[float]:
    """Numbers of a table, beside which are the library's notes, and one picture that is whole."""
    assert (done.returncode, done.stderr) == (0, "")
    shown = " ".join(done.stdout.split())
    assert all(" ".join(note.split()) in shown for note in notes)
    (file,) = (Path.cwd() / "results" / "rod").iterdir()
    assert file.name == picture
    assert file.read_bytes().startswith(b"\x89PNG")
    return numbers(done.stdout)


def _in(wanted: Any, shown: list[float]) -> bool:
    """Whether numbers are among those that are shown, with ten digits."""
    return all(min(abs(one - n) for n in shown) <= 1e-9 * abs(one) for one in wanted)


def test_modes_are_those_of_the_library(call: Call, column: Write) -> None:
    """As JSON and as a table, with its note of what another number of links makes of damping."""
    path = column("[loads.internal_damping]\ncoefficient = 5.0")
    modes = rodgen.natural_modes(rodgen.Scene.from_toml(path), 4)
    found = _strict(call("modes", path, "--count", 4, "--json"))
    assert found["frequencies"] == modes.frequencies.tolist()
    (note,) = found["notes"]
    assert {5.0, 3.0, 20.0, 6.0} <= {*numbers(note)}  # four times as much for twice the links
    shown = _table(call("modes", path, "--count", 4), "modes.png", [note])
    assert _in(modes.frequencies, shown)


def test_modes_in_flight(call: Call, column: Write) -> None:
    """At a speed that is given, or at that of the scene; a note tells of a rod taken at rest."""
    flies = "[initial]\nvelocity = [-7.0, 0.0]"
    path = column(f"{PUSHED}\n{DRAG}", "free")
    still = _strict(call("modes", path, "--json"))
    given = _strict(call("modes", path, "--speed", 7, "--json"))
    assert (still["speed"], given["speed"]) == (0.0, 7.0)
    assert len(still["notes"]) == len(given["notes"]) + 1
    path = column(f"{PUSHED}\n{DRAG}\n{flies}", "free")
    for after in ((), ("--after", 0)):
        found = _strict(call("modes", path, *after, "--json"))
        assert (found["speed"], found["frequencies"]) == (7.0, given["frequencies"])


def test_what_is_unstable_is_warned_of_in_a_line(call: Call, column: Write) -> None:
    """A column beyond the onset of flutter, 80 N for many links; and one under ten times Euler's
    load, pi^2 EI / (4 L^2) = 9.87 N, exactly along it, which an imperfection shows the way."""
    done = call("modes", column("[loads.follower]\nforce = 150.0"), "--count", 3, "--json")
    assert max(_strict(done)["growth"]) > 0
    assert done.stderr.startswith("rodgen: warning: ")
    assert done.stderr.count("\n") == 1
    scene = column("[loads.tip]\nx = -100.0")
    done = call("static", scene, "--json")
    found = _strict(done)
    assert (found["stable"], found["instability"]) == (False, "divergence")
    assert done.stderr.startswith("rodgen: warning: ")
    assert "--imperfection" in done.stderr
    assert done.stderr.count("\n") == 1
    done = call("static", scene, "--imperfection", "0.01", "--json")
    found = _strict(done)
    assert found["stable"] is True
    assert found["tip"][1] > 0.1 * LENGTH
    assert done.stderr == ""


def test_static_deflection_is_that_of_the_library(call: Call, column: Write) -> None:
    """With loads as they are at a time; and as a table."""
    loads = f'{PUSHED}\n[loads.gravity]\n[loads.tip]\nx = "3*t"\ny = 5.0'
    path = column(loads)
    rest = rodgen.static_equilibrium(rodgen.Scene.from_toml(path), t=1.5)
    found = _strict(call("static", path, "--t", 1.5, "--json"))
    assert (found["tip"], found["phi"]) == (rest.tip.tolist(), rest.phi.tolist())
    shown = _table(call("static", path, "--t", 1.5), "static.png")
    assert _in([1.5, *rest.tip], shown)


def test_when_it_is_and_what_is_zero_then(call: Call, column: Write) -> None:
    """A tip load that begins after a second; the follower force is no matter for `critical`."""
    loads = '[loads.follower]\nforce = "t"\n[loads.tip]\nx = "max(0, t - 1)"'
    scene = column(f"{loads}\n[integrate]\nspan = [0.0, 8.0]")
    for command in ("modes", "static", "critical"):
        quiet = {"loads.follower.force", "loads.tip.x"}
        apart = {"loads.follower.force"} if command == "critical" else set()
        for t, expected in ((0.0, quiet), (4.0, set())):
            found = _strict(call(command, scene, "--t", t, "--json"))
            assert found["t"] == t
            assert quiet & {*found["silent"]} == expected - apart


def test_critical_force_is_that_of_the_library(call: Call, column: Write) -> None:
    path = column(f"{PUSHED}\n[loads.internal_damping]\ncoefficient = 0.5")
    critical = rodgen.critical_force(rodgen.Scene.from_toml(path), highest=300)
    found = _strict(call("critical", path, "--highest", 300, "--json"))
    for name in ("force", "frequency", "kind"):
        assert found[name] == getattr(critical, name)
    shown = _table(call("critical", path, "--highest", 300), "critical.png", critical.notes)
    assert min(abs(n / critical.force - 1) for n in shown if n) < 1e-6  # its digits are fewer
    assert _in(critical.searched, shown)


def test_window_of_a_heavy_column(call: Call, write: Write) -> None:
    """Upright, held up by thrust: too little of it, and it buckles."""
    scene = write(f"[loads.gravity]\ng = 1.8\n{PUSHED}", clamp_angle=np.pi / 2)
    found = _strict(call("critical", scene, "--windows", "--json"))
    ((low, high),) = found["stable"]
    assert high == found["force"]
    assert _strict(call("critical", scene, "--end", "lower", "--json"))["force"] == low
    weight = _strict(call("critical", scene, "--load", "gravity", "--json"))
    assert (weight["unit"], weight["kind"]) == ("m/s^2", "divergence")
    assert weight["force"] > 1.8  # 10 N hold up more than the column has
    said = numbers(call("critical", scene).stderr)
    assert min(abs(n / low - 1) for n in said if n) < 1e-3  # it names the window, with few digits


@pytest.mark.slow
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


@pytest.mark.slow
def test_critical_force_by_simulation(call: Call, column: Write) -> None:
    """Growth is measured: in a short time, too, the force is hardly too large."""
    found = _strict(call("critical", column(PUSHED), "--simulate", 20, "--json"))
    simulated = found["simulated"]
    assert simulated["span"] == 20.0
    assert simulated["low"] < simulated["force"] < simulated["high"]
    assert simulated["growth"] is None
    # Bisection ends at 1e-4 of the force; growth of 1 % in 20 s asks for a surplus of about that.
    assert simulated["force"] == pytest.approx(found["force"], rel=1e-3)
    assert found["doubt"] is None


def test_simulations_are_of_the_speed_and_their_force_may_be_another(
    call: Call, column: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What differs is doubted; and the force by eigenvalues outlives a simulation without one."""
    given: dict[str, Any] = {}

    def half(scene: rodgen.Scene, **options: Any) -> growth.SimulatedCritical:
        given.update(options)
        return growth.SimulatedCritical(50.0, 49.0, 51.0, 5.0, None, 9, 1.0, "c", options["speed"])

    def nothing(*_: object, **__: object) -> None:
        raise AnalysisError("nothing grows")

    monkeypatch.setattr(growth, "simulated_critical_force", half)
    scene = column(f"{PUSHED}\n{DRAG}", "free")
    command = ("critical", scene, "--speed", 20, "--simulate", 5, "--json")
    done = call(*command)
    found = json.loads(done.stdout)
    assert (found["speed"], given["speed"]) == (20.0, 20.0)
    critical = rodgen.critical_force(rodgen.Scene.from_toml(scene), speed=20.0)
    assert found["force"] == critical.force
    assert found["doubt"]
    assert found["doubt"] in done.stderr
    monkeypatch.setattr(growth, "simulated_critical_force", nothing)
    done = call(*command)
    assert done.returncode == 3
    assert json.loads(done.stdout)["force"] == critical.force
    assert json.loads(done.stdout)["simulated"] is None
    assert "nothing grows" in done.stderr


def test_with_json_no_folder_is_needed(call: Call, column: Write) -> None:
    """Without it one that cannot be written is refused before anything is computed."""
    scene = column(PUSHED)
    for command in ("modes", "static", "critical"):
        done = call(command, scene, "--out", scene)
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        assert _strict(call(command, scene, "--out", scene, "--json"))
