"""What plots of the live view show, against exact motions: sines, circles, straight rods."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from live.tests.runs import prepared
from rodgen.arrays import Array
from rodgen.model.terms import THESIS_TERMS
from rodgen.scene import Scene
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.run.plot import Plot, PlotSpec
from rodgen_live.run.sample_curves import MOST_ROWS
from rodgen_live.sample_store import Chunk
from tests.told import refused

Make = Callable[..., Scene]
GOOD = {"id": "p1", "kind": "time", "y": ["phi_0"]}
RISES = {"kind": "poincare", "x": "tip_x", "y": "phi_0", "when": "tip_y"}


def turning(chunk: Callable[..., Chunk], t: Array, rate: float) -> Chunk:
    """The bar at the angles rate t."""
    return chunk(t, np.stack((rate * t, np.full(len(t), rate)), axis=1))


def cut(whole: Chunk, *at: int) -> Iterator[Chunk]:
    """A chunk cut into several."""
    for first, last in zip((0, *at), (*at, len(whole)), strict=True):
        yield whole.select(slice(first, last))


def plot(catalogue: Catalogue, **choice: Any) -> Plot:
    return Plot(PlotSpec.from_dict({"id": "p1", **choice}, catalogue), catalogue)


def fed(made: Plot, chunks: Iterator[Chunk]) -> Array:
    rows = [found for chunk in chunks if (found := made.feed(chunk)) is not None]
    return np.concatenate(rows) if rows else np.zeros((0, made.width))


# What is chosen --------------------------------------------------------------------------------

SENSELESS: dict[str, tuple[Any, ...]] = {
    "kind": ("pie",),
    "id": ("a b", 3),
    "y": ([], ["phi_7"], 3, ["phi_0", None]),
    "title": ("x" * 81, "two\nlines"),
    "window": (0, float("nan"), "20", True),
    "value": (float("inf"),),
    "every": (-1.0,),
    "direction": ("up",),
    "colour": ("red",),
}
UNFIT = (
    ({"kind": "profile", "y": ["tip_x"]}, "plot.y[0]"),
    ({"kind": "profile", "y": ["phi", "omega"]}, "plot.y"),
    ({"kind": "profile", "y": ["bend"]}, "plot.y[0]"),  # one link has no neighbour
    ({"kind": "phase", "y": ["omega_0"], "x": "phi_9"}, "plot.x"),
    ({"kind": "phase", "y": ["omega"]}, "plot.y[0]"),  # a kind is no quantity
    ({"kind": "poincare", "y": ["omega_0"], "x": "phi_0"}, "plot.when"),
    ({"kind": "spectrum", "y": ["phi_0", "tip_x"]}, "plot.y"),
)


def test_a_kind_of_plot_takes_what_it_can_show(bar: Any) -> None:
    for field, values in SENSELESS.items():
        for value in values:
            told = refused(PlotSpec.from_dict, {**GOOD, field: value}, bar[0])
            assert field in f"{told.field} {told.value}"
    for choice, field in UNFIT:
        assert refused(PlotSpec.from_dict, {"id": "p", **choice}, bar[0]).field == field


def test_of_too_many_series_every_kth_is_shown(
    make_scene: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rodgen_live.run.plot.MOST_SERIES", 20)
    catalogue, chunk = prepared(make_scene(21, "pinned"))
    made = plot(catalogue, kind="time", y=["omega"])
    assert made.names == tuple(f"omega_{i}" for i in range(0, 21, 2))
    row = made.feed(chunk(np.zeros(1), np.arange(42.0)[None]))
    assert row is not None
    np.testing.assert_array_equal(row[0, 1:], np.arange(21, 42, 2))


def test_the_page_is_told_what_to_draw(bar: Any) -> None:
    catalogue, _ = bar
    made = plot(catalogue, kind="phase", x="phi_0", y=["omega_0"]).to_json()
    axis = {"log": False, "least": pytest.approx(1e-12, rel=0.5)}  # atol, of about one
    assert made["x"] == {**axis, "label": "φ₀", "unit": "rad", "period": 0.0, "turn": 2 * np.pi}
    assert made["y"] == {**axis, "label": "ω₀", "unit": "rad/s"}
    omega = {"name": "omega_0", "label": "ω₀", "unit": "rad/s", "period": 0.0, "turn": 0.0}
    assert made["series"] == [omega]
    assert (made["id"], made["kind"], made["window"]) == ("p1", "phase", 20.0)
    mixed = plot(catalogue, kind="time", y=["phi_0", "tip_x"], title="two").to_json()
    assert mixed["y"]["unit"] == ""  # rad and m: the series tell
    assert mixed["title"] == "two"
    energies = plot(catalogue, kind="time", y=["energy"]).to_json()
    assert energies["y"].items() >= {"label": "energy", "unit": "J", "log": False}.items()
    # Whole turns are those of absolute angles, neither of differences nor of what a spectrum is of.
    for choice, turns in (
        ({"kind": "time", "y": ["phi_0", "t"]}, [2 * np.pi, 0.0]),
        ({"kind": "time", "y": "phi_0 - phi_0"}, [0.0]),
        ({"kind": "spectrum", "y": "phi_0"}, [0.0]),
    ):
        assert [one["turn"] for one in plot(catalogue, **choice).to_json()["series"]] == turns
    spec = PlotSpec.from_dict({**GOOD, "window": 3, "wrapped": False}, catalogue)
    assert PlotSpec.from_dict(json.loads(spec.model_dump_json()), catalogue) == spec
    names = [one["name"] for one in energies["series"]]
    assert names == ["kinetic_energy", "total_energy"]  # there is neither spring nor gravity


# Rows ------------------------------------------------------------------------------------------


def test_time_and_phase_have_a_row_for_every_sample(bar: Any) -> None:
    catalogue, chunk = bar
    t = np.linspace(0, 1, 7)
    whole = turning(chunk, t, 2.0)
    over_time = fed(plot(catalogue, kind="time", y=["phi", "tip_x"]), cut(whole, 2, 2, 3))
    expected = np.stack((t, 2 * t, 2 * np.cos(2 * t)), axis=1)
    np.testing.assert_allclose(over_time, expected, atol=1e-15)
    phase = fed(plot(catalogue, kind="phase", x="tip_x", y="tip_y"), cut(whole, 4))
    circle = np.stack((t, 2 * np.cos(2 * t), 2 * np.sin(2 * t)), axis=1)
    np.testing.assert_allclose(phase, circle, atol=1e-15)


def test_a_profile_goes_along_the_rod(make_scene: Make) -> None:
    catalogue, chunk = prepared(make_scene(4, "pinned"))
    state = chunk(np.array([1.0, 2.0]), np.stack((np.full(8, 0.3), np.arange(8.0))))
    joints = plot(catalogue, kind="profile", y=["joint_x"])
    angles = plot(catalogue, kind="profile", y=["phi"])
    assert joints.feed(state) is None
    share = np.linspace(0, 1, 5)
    for made, shown, expected in (
        (joints, state.select(slice(1)), [share, 2.0 * share * np.cos(0.3)]),
        (angles, state, [[0.125, 0.375, 0.625, 0.875], [0, 1, 2, 3]]),  # of the last sample
    ):
        found = made.current_rows(shown)
        assert found is not None
        np.testing.assert_allclose(found.T, expected, atol=1e-15)


def test_a_backlog_keeps_the_window_and_the_extremes(bar: Any) -> None:
    catalogue, chunk = bar
    t = np.arange(0.0, 100.0, 0.001)
    y = np.stack((np.sin(t), np.zeros(len(t))), axis=1)
    y[70_003, 0], y[90_007, 0] = 5.0, -7.0
    old = chunk(t[:60_000], y[:60_000])
    new = chunk(t[60_000:], y[60_000:], given=1.0)
    rows = plot(catalogue, kind="time", y=["phi_0"], window=50.0).backlog([old, new])
    assert MOST_ROWS // 2 < len(rows) <= MOST_ROWS
    assert rows[0, 0] == pytest.approx(t[-1] - 50.0, abs=0.0011)
    assert rows[-1, 0] == t[-1]
    assert (rows[:, 1].max(), rows[:, 1].min()) == (5.0, -7.0)
    assert (np.diff(rows[:, 0]) > 0).all()
    assert plot(catalogue, kind="time", y=["phi_0"]).backlog([]).shape == (0, 2)


# Sections --------------------------------------------------------------------------------------


def test_sections_of_samples_where_the_answer_is_known(bar: Any) -> None:
    """In each direction; of a stroboscope, between samples; of the axis of a bar that turns twice,
    which has the angle 0 at 0 (the start), pi, 2 pi, 3 pi and jumps between them; of a run that
    starts again."""
    catalogue, chunk = bar

    def times(t: Array, **choice: Any) -> Array:
        made = plot(catalogue, **{"kind": "poincare", "x": "t", "y": "phi_0", **choice})
        return fed(made, cut(turning(chunk, t, 1.0), 100))[:, 0]

    even = np.linspace(0, 6, 301)
    for direction, sixths in (("rising", [1]), ("falling", [5]), ("either", [1, 5])):
        found = times(even, when="tip_y", value=1.0, direction=direction)
        np.testing.assert_allclose(found, np.pi / 6 * np.array(sixths), atol=1e-6)  # h^4 = 1.6e-7
    found = times(np.linspace(0, 5, 501), when="t", value=0.25, every=0.7)
    np.testing.assert_allclose(found, 0.25 + 0.7 * np.arange(7), atol=1e-12)
    found = times(np.arange(0.0, 12.0, 0.05), when="principal_angle", direction="either")
    np.testing.assert_allclose(found, np.pi * np.array([1, 2, 3]), atol=1e-12)
    twice = np.concatenate([np.linspace(0.0, 1.0, 51)] * 2)
    np.testing.assert_allclose(times(twice, when="tip_y", value=1.0), [np.pi / 6] * 2, atol=1e-6)


def test_chunks_of_any_length_give_the_same_section(bar: Any) -> None:
    """Of nonuniform samples, and to a plot that is added later."""
    catalogue, chunk = bar
    whole = turning(chunk, np.cumsum(np.random.default_rng(3).uniform(0.02, 0.06, 800)), 1.3)
    at_once = fed(plot(catalogue, **RISES), cut(whole))
    one_by_one = fed(plot(catalogue, **RISES), cut(whole, *range(1, 800)))
    first, second = cut(whole, 257)
    later = plot(catalogue, **RISES)
    added = np.concatenate((later.backlog([first]), fed(later, iter((second,)))))
    assert len(at_once) == 6  # the upward crossings of 41 rad
    np.testing.assert_array_equal(at_once, one_by_one)
    np.testing.assert_array_equal(at_once, added)
    np.testing.assert_allclose(at_once[:, 1], 2.0, atol=1e-5)  # h^4 of 0.06 * 1.3 rad


@pytest.mark.parametrize("direction", ["rising", "falling", "either"])
def test_a_value_on_a_sample_is_reached_once(bar: Any, direction: str) -> None:
    """Samples lie on every value but for rounding, on either side: none is lost or counts twice,
    of an angle that rises as of one that falls."""
    catalogue, chunk = bar
    whole = turning(chunk, np.arange(1000) * 0.01, -1.0 if direction == "falling" else 1.0)
    for every in (0.01, 0.02, 0.07):
        choice = {"x": "t", "y": "phi_0", "when": "phi_0", "every": every, "direction": direction}
        points = fed(plot(catalogue, kind="poincare", **choice), cut(whole, 3, 500, 501))
        instants = every * np.arange(1, 1001)
        instants = instants[instants < 9.985]  # known two samples late
        np.testing.assert_allclose(points[:, 0], instants, atol=1e-12)


def test_a_kick_is_not_smoothed_over(bar: Any) -> None:
    """A bar that turns at 1 rad/s and is turned back at 0.55 s: samples on either side of the kick
    are joined by a straight line, and by no curve, which would leave the lines phi(t) as well."""
    catalogue, chunk = bar
    t = np.arange(0.0, 1.01, 0.1)
    before = turning(chunk, t[:6], 1.0)
    back = np.stack((0.55 - 3 * (t[6:] - 0.55), np.full(5, -3.0)), axis=1)
    after = chunk(t[6:], back, given=4.0)
    choice = {"x": "t", "y": "phi_0", "when": "phi_0", "direction": "either"}
    for value, expected in ((0.47, [0.47, 0.53]), (0.23, [0.23, 0.55 + 0.32 / 3])):
        points = fed(plot(catalogue, kind="poincare", value=value, **choice), iter((before, after)))
        np.testing.assert_allclose(points[:, 0], expected, atol=1e-14)


# Energies --------------------------------------------------------------------------------------


def test_energy_in_gravity_is_counted_from_the_start(make_scene: Make) -> None:
    """A rod 4 km below the origin: what falls is seen. Kinetic energy is as it is, and what comes
    later counts from the same start."""
    scene = make_scene(5, terms=THESIS_TERMS)
    catalogue, make = prepared(scene)
    y = np.tile(scene.initial_state(), (5, 1))
    y[:, 1] = -4000.0 - np.arange(5.0)
    raised = float(catalogue.columns(["gravity_energy"], make(np.zeros(1), y[:1]))[0, 0])
    chunk = make(np.arange(5.0), y, raised=raised)
    made = plot(catalogue, kind="time", y=["energy"])
    first, later = cut(chunk, 3)
    rows = np.concatenate([made.backlog([first]), made.feed(later)])
    fallen = -scene.parameters["mass"] * 9.81 * np.arange(5.0)
    names = [one["name"].split("_")[0] for one in made.to_json()["series"]]
    kinetic, spring, gravity, total = (
        rows[:, 1 + names.index(name)] for name in ("kinetic", "spring", "gravity", "total")
    )
    np.testing.assert_allclose(gravity, fallen, rtol=1e-9, atol=1e-9)  # eps of 1e5 J
    np.testing.assert_allclose(total, fallen + kinetic + spring, rtol=1e-9, atol=1e-9)
    phase = plot(catalogue, kind="phase", x="t", y="gravity_energy").feed(chunk)
    assert phase is not None
    assert phase[0, 2] < -1e4  # as it is, over another


def test_energies_that_a_scene_lacks_are_no_lines_at_zero(make_scene: Make) -> None:
    """A chain without stiffness and weight has neither springs nor gravity, until it gets some."""
    scene = make_scene(5, terms=THESIS_TERMS)
    catalogue, _ = prepared(scene)
    every = ["kinetic", "spring", "gravity", "total"]
    for values, differ, energies in (
        ({}, False, every),
        ({"bending_stiffness": 0.0}, True, ["kinetic", "gravity", "total"]),
        ({"bending_stiffness": 0.0, "gravity": 0.0}, True, ["kinetic", "total"]),
        ({}, True, every),
    ):
        p = catalogue.model.parameters(**{**scene.parameters, **values})
        assert catalogue.update_zero_energies(0.0, p) == differ
        assert [name.split("_")[0] for name in catalogue.expand("energy")] == energies
