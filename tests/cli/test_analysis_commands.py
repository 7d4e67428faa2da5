"""rodgen modes, static and critical: what they print, draw and warn of."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen as package
from rodgen.analyse import critical, simulated_critical
from rodgen.analyse.scene_family import load_family
from rodgen.errors import AnalysisError, InputError
from rodgen.show import appearance
from rodgen.show.critical_pictures import stability_curves
from tests.cli.conftest import LENGTH, Run, Write, one_object
from tests.told import numbers

PUSHED = "[loads.follower]\nforce = 10.0"
DRAG = """[loads.external_damping]
coefficient = 0.5
fin_factor = {nose = 1.0, body = 1.0, tail = 20.0}"""

DAMPED = "[loads.internal_damping]\ncoefficient = "
TIP = '[loads.gravity]\n[loads.tip]\nx = "3*t"\ny = 5.0'
# Of each command: loads, options, what the library makes of them, what is printed and shown of it.
OF_LIBRARY: dict[str, tuple[Any, ...]] = {
    "modes": (
        *(f"{DAMPED}5.0", ("--count", 4), lambda scene: package.natural_modes(scene, 4)),
        *(("frequencies", "growth"), ("frequencies",)),
    ),
    "static": (
        *(f"{PUSHED}\n{TIP}", ("--t", 1.5)),
        *(lambda scene: package.static_equilibrium(scene, t=1.5), ("tip_x", "phi"), ("t", "tip")),
    ),
    "critical": (
        *(f"{PUSHED}\n{DAMPED}0.5", ("--bounds", ",300")),
        *(lambda scene: package.critical_load(scene, bounds=(None, 300)),),
        *(("value", "frequency", "kind"), ("value", "searched")),
    ),
}

pytestmark = pytest.mark.usefixtures("work")


@pytest.mark.parametrize("command", OF_LIBRARY)
def test_results_are_those_of_the_library(rodgen: Run, column: Write, command: str) -> None:
    """As JSON, for which no folder is needed; and as a table, with notes and one whole picture. A
    folder that cannot be written is refused before anything is computed."""
    loads, options, made, printed, shown = OF_LIBRARY[command]
    path = column(loads)
    due = made(package.Scene.from_toml(path))
    found = one_object(rodgen(command, path, *options, "--json", "--out", path))
    for name in printed:
        assert found[name] == due.to_dict()[name], name
    done = rodgen(command, path, *options)
    assert (done.returncode, done.stderr) == (0, "")
    words = " ".join(done.stdout.split())
    assert all(" ".join(note["text"].split()) in words for note in found["notes"])
    digits = numbers(done.stdout)
    for one in np.hstack([getattr(due, name) for name in shown]):
        least = 1e-6 if command == "critical" else 1e-9  # of the digits that it is shown with
        assert min(abs(one - n) for n in digits) <= least * abs(one)
    (file,) = Path("results/rod").iterdir()
    assert file.name == f"{command}.png"
    assert file.read_bytes().startswith(b"\x89PNG")
    refused = rodgen(command, path, "--out", path)
    assert (refused.returncode, refused.stdout, refused.stderr.count("\n")) == (2, "", 1)


def test_only_a_picture_of_nothing_is_left_out(
    rodgen: Run, write: Write, column: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A free rod of one link has no modes; what goes wrong in a drawing is told."""

    def fails(*_: object) -> None:
        raise InputError("load", "wind", "drawn")

    assert rodgen("modes", write("", 1, "free")).returncode == 0
    assert not Path("results").exists()
    monkeypatch.setattr(appearance, "figure_of", fails)
    done = rodgen("modes", column(PUSHED))
    assert (done.returncode, done.stderr) == (2, "rodgen: load = 'wind': must be drawn\n")


def test_modes_in_flight(rodgen: Run, column: Write) -> None:
    """At a speed that is given, or at that of the scene; a note tells of a rod taken at rest."""
    flies = "[initial]\nvelocity = [-7.0, 0.0]"
    path = column(f"{PUSHED}\n{DRAG}", "free")
    still = one_object(rodgen("modes", path, "--json"))
    given = one_object(rodgen("modes", path, "--speed", 7, "--json"))
    assert (still["speed"], given["speed"]) == (0.0, 7.0)
    assert len(_remarks(still)) == len(_remarks(given)) + 1
    path = column(f"{PUSHED}\n{DRAG}\n{flies}", "free")
    for after in ((), ("--after", 0)):
        found = one_object(rodgen("modes", path, *after, "--json"))
        assert (found["speed"], found["frequencies"]) == (7.0, given["frequencies"])


def _remarks(found: dict[str, Any]) -> list[dict[str, Any]]:
    return [note for note in found["notes"] if note["kind"] == "remark"]


def test_what_is_unstable_is_warned_of_in_a_line(rodgen: Run, column: Write) -> None:
    """A column beyond the onset of flutter, 80 N for many links; and one under ten times Euler's
    load, pi^2 EI / (4 L^2) = 9.87 N, exactly along it, which an imperfection shows the way."""
    done = rodgen("modes", column("[loads.follower]\nforce = 150.0"), "--count", 3, "--json")
    assert max(one_object(done)["growth"]) > 0
    assert done.stderr.startswith("rodgen: warning: ")
    assert done.stderr.count("\n") == 1
    scene = column("[loads.tip]\nx = -100.0")
    done = rodgen("static", scene, "--json")
    found = one_object(done)
    assert (found["stable"], found["instability"]) == (False, "divergence")
    assert done.stderr.startswith("rodgen: warning: ")
    assert "imperfection" in done.stderr
    assert done.stderr.count("\n") == 1
    done = rodgen("static", scene, "--imperfection", "0.01", "--json")
    found = one_object(done)
    assert found["stable"] is True
    assert found["tip_y"] > 0.1 * LENGTH
    assert done.stderr == ""


def test_when_it_is_and_what_is_zero_then(rodgen: Run, column: Write) -> None:
    """A tip load that begins after a second; the follower force is no matter for `critical`."""
    loads = '[loads.follower]\nforce = "t"\n[loads.tip]\nx = "max(0, t - 1)"'
    scene = column(f"{loads}\n[integrate]\nspan = [0.0, 8.0]")
    for command in ("modes", "static", "critical"):
        quiet = {"loads.follower.force", "loads.tip.x"}
        apart = {"loads.follower.force"} if command == "critical" else set()
        for t, expected in ((0.0, quiet), (4.0, set())):
            found = one_object(rodgen(command, scene, "--t", t, "--json"))
            assert found["t"] == t
            assert quiet & {*found["inactive_loads"]} == expected - apart


def test_load_ratio_is_that_of_the_load_at_the_time(rodgen: Run, column: Write) -> None:
    """Of a thrust, of a dead load in its direction, and of both; in words, and of the library."""
    loads = '[loads.follower]\nforce = "10*t"\n[loads.tip]\nx = -2.0'
    scene = column(f"{loads}\n[integrate]\nspan = [0.0, 8.0]")
    for load, t, applied in (("follower", 4, 40), ("follower", 0, 0), ("tip", 4, 2), ("all", 4, 1)):
        given = ("critical", scene, "--t", t, "--load", load, "--no-pictures")
        found = json.loads(rodgen(*given, "--json").stdout)
        assert found["applied"] == pytest.approx(applied, rel=1e-15)
        assert found["load_ratio"] == found["applied"] / found["value"]
        shown = numbers(rodgen(*given).stdout)
        assert min(abs(one - found["load_ratio"]) for one in shown) <= 1e-5 * found["load_ratio"]
    steered = package.Scene.from_toml(scene).replace({"loads.follower.force": "10*cos(phi(0.5))"})
    assert np.isnan(package.critical_load(steered, t=4).load_ratio)


def test_window_of_a_heavy_column(rodgen: Run, write: Write) -> None:
    """Upright, held up by thrust: too little of it, and it buckles."""
    scene = write(f"[loads.gravity]\ng = 1.8\n{PUSHED}", clamp_angle=np.pi / 2)
    found = one_object(rodgen("critical", scene, "--windows", "--json"))
    ((low, high),) = found["windows"]
    assert high == found["value"]
    assert one_object(rodgen("critical", scene, "--end", "lower", "--json"))["value"] == low
    weight = one_object(rodgen("critical", scene, "--load", "gravity", "--json"))
    assert (weight["unit"], weight["kind"]) == ("m/s^2", "divergence")
    assert weight["value"] > 1.8  # 10 N hold up more than the column has
    said = numbers(rodgen("critical", scene).stderr)
    assert min(abs(n / low - 1) for n in said if n) < 1e-3  # it names the window, with few digits


def test_simulations_are_of_the_speed_and_their_force_may_be_another(
    rodgen: Run, column: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What differs is doubted; and the force by eigenvalues outlives a simulation without one."""
    given: list[float] = []

    def half(run: simulated_critical.GrowthTest) -> simulated_critical.SimulatedCritical:
        given.append(run.family.rod.speed)
        return simulated_critical.SimulatedCritical(
            50.0, 49.0, 51.0, run.span, None, 9, 1.0, "c", given[-1]
        )

    def nothing(*_: object, **__: object) -> None:
        raise AnalysisError("nothing grows")

    monkeypatch.setattr(critical, "bisect_growth", half)
    scene = column(f"{PUSHED}\n{DRAG}", "free")
    command = ("critical", scene, "--speed", 20, "--simulate", 5, "--json")
    done = rodgen(*command)
    found = json.loads(done.stdout)
    assert (found["speed"], given) == (20.0, [20.0])
    alone = package.critical_load(package.Scene.from_toml(scene), speed=20.0)
    assert found["value"] == alone.value
    simulated = found["simulated"]
    assert [simulated[name] for name in ("value", "low", "high", "span")] == [50.0, 49.0, 51.0, 5.0]
    (doubted,) = (note for note in found["notes"] if note["kind"] == "doubt")
    assert doubted["figures"]["by_simulations"] == 50.0
    assert doubted["text"] in done.stderr
    monkeypatch.setattr(critical, "bisect_growth", nothing)
    done = rodgen(*command)
    assert done.returncode == 3
    assert json.loads(done.stdout)["value"] == alone.value
    assert json.loads(done.stdout)["simulated"] is None
    assert "nothing grows" in done.stderr


@pytest.mark.slow
def test_picture_shows_where_growth_begins(write: Write) -> None:
    """Strong flutter, from 430 N on, would make a line of what happens at 348 N."""
    scene = package.Scene.from_toml(write(f"{PUSHED}\n{DAMPED}0.5", 20, "free"))
    found, family = package.critical_load(scene), load_family(scene)
    low, high = stability_curves(found).axes[1].get_ylim()
    assert 0.15 < high / (high - low) < 0.85
    before, after = np.nanmax(
        family.elastic_eigenvalues(found.value * np.array([0.0, 1.1])).real, axis=1
    )
    assert low < before < 0
    assert 0 < after < high < 2 * max(after, -before)
