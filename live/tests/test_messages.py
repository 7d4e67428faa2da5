"""Messages to a page, read as it reads them, while pages come and go; trails that are whole."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rodgen
from live.tests.runs import decoded
from rodgen.loading import build_fastest
from rodgen.model.terms import THESIS_TERMS
from rodgen.scene import Scene
from rodgen_live.open_run import Live
from rodgen_live.page import elements
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.run import page_state
from rodgen_live.run.change_history import ChangeMarks
from rodgen_live.run.ghost import Ghost
from rodgen_live.run.message import rod_arrays, trail_points
from rodgen_live.run.page_state import AHEAD, LONGEST_TRAIL, PageState
from rodgen_live.sample_store import Chunk, SampleStore
from tests.palette import ALL, ROD


class Stepped:
    """What a page state asks of a run, without a thread: it goes on when it is told to."""

    def __init__(self, scene: Scene):
        self.model, self.status = build_fastest(scene), "running"
        self.live = Live(scene, self.model, scene.integrate.output_every)
        self.plots: dict[str, Any] = {}
        self.marks, self.past, self.ghost, self.keeps = ChangeMarks(), None, None, False
        self.begun, self.repeats = 0, False
        self.page = PageState()
        self.begin()

    def begin(self) -> None:
        self.live.restart()
        self.store = SampleStore()
        self.page.resend(self)
        self.to(0.0)

    def to(self, t: float) -> None:
        """Samples up to a time."""
        chunk = self.live.advance(t, 60.0)
        self.store.add(chunk)
        self.page_sample = chunk.last()
        self.page.add_samples(self, chunk)

    def run_status(self) -> None:
        """What texts are made of."""

    def told(self) -> None:
        """Nobody is told of other rows."""


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Stepped:
    monkeypatch.setattr(page_state, "row_groups", lambda *_: {})
    return Stepped(Scene.from_dict(ROD))


def while_made(monkeypatch: pytest.MonkeyPatch, does: Callable[[], None]) -> None:
    """Something happens in the middle of the next message."""

    def meanwhile(*_: Any) -> dict[str, str]:
        does()
        return {}

    monkeypatch.setattr(page_state, "row_groups", meanwhile)


# Pages that come and go ------------------------------------------------------------------------


def test_page_comes_while_the_message_of_another_is_made(
    run: Stepped, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It gets everything, its coming is not forgotten when the other one leaves late, and nothing
    more goes to one that left meanwhile."""
    first: list[bytes] = []
    second: list[bytes] = []
    run.page.attach(first.append)
    while_made(monkeypatch, lambda: run.page.attach(second.append))
    run.page.show(run)
    while_made(monkeypatch, lambda: run.page.detach(first.append))
    run.page.show(run)
    assert run.page.has_page
    assert [*decoded(second[-1])[1]].count("trail!") == 1
    run.page.invalidate()  # so that the next one has texts, too
    while_made(monkeypatch, lambda: run.page.detach(second.append))
    run.page.show(run)
    assert not run.page.has_page
    counts = len(first), len(second)
    run.to(0.2)
    run.page.show(run)
    assert (len(first), len(second)) == counts


def test_late_answer_of_a_page_before_holds_nothing_up(run: Stepped) -> None:
    """It tells of an older message than those that were sent before the present page came."""
    got: list[bytes] = []
    run.page.attach(lambda _: None)
    for k in range(5):
        run.to(0.1 * k + 0.1)
        run.page.show(run)
        run.page.acknowledge(k + 1)
    run.page.attach(got.append)
    run.page.acknowledge(3)
    for k in range(5):
        run.to(0.1 * k + 0.6)
        run.page.show(run)
    assert len(got) == AHEAD  # as many as any page that has drawn none of them


# Trails ----------------------------------------------------------------------------------------


def test_every_sample_since_the_last_message_is_in_the_trail(run: Stepped) -> None:
    """Against a run without a page, at its own samples, in single precision."""
    got: list[bytes] = []
    sol = rodgen.simulate(Scene.from_dict(ROD), span=[0.0, 1.0])
    expected = np.c_[sol.tip, sol.centre_of_gravity, sol.t]

    def trail(name: str) -> Any:
        run.page.show(run)
        run.page.acknowledge(len(got))
        return decoded(got[-1])[1][name].reshape(-1, 5)

    run.to(0.2)
    run.page.attach(got.append)
    assert trail("trail!") == pytest.approx(expected[:21], abs=1e-6)
    for t in (0.25, 0.3, 0.6):
        run.to(t)
    assert trail("trail") == pytest.approx(expected[21:61], abs=1e-6)
    run.begin()
    assert trail("trail!") == pytest.approx(expected[:1], abs=1e-6)


@pytest.mark.parametrize("changing", [False, True])
def test_trail_of_a_page_that_does_not_answer_stays_short(run: Stepped, changing: bool) -> None:
    """Whether parameters are the same all the time, or others for every sample."""
    chunk, count, got = run.page_sample, 2 * LONGEST_TRAIL, list[bytes]()
    run.page.attach(got.append)
    run.page.show(run)
    run.page.acknowledge(1)
    for x in range(count):
        y = chunk.y.copy()
        y[:, 0] = x  # joint 0, and everything with it
        p = chunk.p.copy() if changing else chunk.p
        run.page.add_samples(run, Chunk(chunk.t, y, chunk.work, chunk.works, p))
    run.page.show(run)
    places = decoded(got[-1])[1]["trail"].reshape(-1, 5)
    steps = np.diff(places[:, 0])
    assert LONGEST_TRAIL / 3 < len(places) <= LONGEST_TRAIL
    assert steps.min() > 0
    assert np.ptp(places[:, 0]) > 0.9 * count
    run.page.invalidate()
    run.page.acknowledge(2)
    run.page.show(run)
    assert not len(decoded(got[-1])[1]["trail"])


# The rod, and the form of messages -------------------------------------------------------------


def test_a_page_is_told_where_everything_falls_at_present(make_scene: Callable[..., Scene]) -> None:
    """By an expression of the time, and by one of the motion."""
    fall = {"loads.gravity": {"acceleration": ["0.5*sin(3*t)", "-9.81 + phi(1)"]}}
    scene = make_scene(3, "free", ()).replace(fall)
    model, system, y = rodgen.build(scene, "numpy"), rodgen.System(scene), scene.initial_state()
    y[4], p = 0.25, model.parameters(**scene.parameters)
    chunk = Chunk(np.array([0.3]), y[None], np.zeros((1, 1)), ("gravity",), p)
    found = dict(rod_arrays(model, system, chunk)[1])["forces:gravity"]
    assert found == pytest.approx([0.5 * np.sin(0.9), -9.56], rel=1e-6)  # single


@pytest.mark.parametrize("boundary", ["clamped", "cantilever"])
def test_a_page_is_told_how_the_clamp_stands(
    make_scene: Callable[..., Scene], boundary: str
) -> None:
    """Its place is the origin, its angle comes with the centre of gravity; trail and kept run go
    with it."""
    base = {"x": "0.3*sin(2*t)", "y": "0.5*t", "angle": "t**2"}
    scene = make_scene(2, boundary, ()).replace({"base": base, "rod.clamp_angle": 0.4})
    model, system = rodgen.build(scene, "numpy"), rodgen.System(scene)
    t, y = np.array([0.3, 0.5]), np.tile(scene.initial_state(), (2, 1))
    chunk = Chunk(t, y, np.zeros((2, 1)), ("base",), system.p)
    origin, found = rod_arrays(model, system, chunk)
    arrays, places = dict(found), np.c_[0.3 * np.sin(2 * t), 0.5 * t]
    assert origin == pytest.approx(places[1])
    assert arrays["point"][3] == pytest.approx(0.4 + 0.25, rel=1e-6)  # single
    moving = y[0, : 2 - (boundary == "cantilever")]
    phi = np.array([[*[0.4 + one**2] * (2 - len(moving)), *moving] for one in t])
    tails = places + np.stack((np.cos(phi), np.sin(phi)), axis=-1).sum(axis=1)  # links of 1 m
    assert arrays["joints"][-2:] == pytest.approx(tails[1] - places[1], rel=1e-6)
    np.testing.assert_allclose(trail_points(model, chunk)[:, :2], tails)
    store = SampleStore()
    store.add(chunk)
    ghost = Ghost(store, Catalogue(system, model))
    np.testing.assert_allclose(ghost.joints(0.4)[[0, -1]], [places.mean(0), tails.mean(0)])


@pytest.mark.parametrize(
    ("terms", "links"), [(THESIS_TERMS, 5), pytest.param(ALL, 2, marks=pytest.mark.slow)]
)
def test_every_load_that_a_page_draws_is_told(
    make_scene: Callable[..., Scene], terms: tuple[str, ...], links: int
) -> None:
    """Against the module: a force for each joint, of gravity the acceleration."""
    scene = make_scene(links, terms=terms)
    model, system = rodgen.build(scene, "numpy"), rodgen.System(scene)
    y, p = scene.initial_state()[None], model.parameters(**scene.parameters)
    origin, found = rod_arrays(model, system, Chunk(np.array([0.3]), y, np.zeros((1, 0)), (), p))
    arrays = dict(found)
    drawn = {name: term for name, term in elements.LOADS.items() if name in terms}
    assert len(drawn) >= 2
    for name, term in drawn.items():
        if elements.ARROWS[term.kind] == "mass":
            assert arrays[f"forces:{name}"] == pytest.approx([0.0, -9.81])
        elif elements.ARROWS[term.kind] == "link":  # at the tail
            told = [*model.joints(y[0], p)[-1] - origin, 5.0]
            assert arrays[f"couple:{name}"] == pytest.approx(told, rel=1e-6)
        else:
            force = model.forces(0.3, y[0], p)[name]
            assert np.abs(force).max() > 0
            assert arrays[f"forces:{name}"] == pytest.approx(force.ravel(), rel=1e-6)  # single
    joints = arrays["joints"].reshape(-1, 2) + origin
    assert joints == pytest.approx(model.joints(y[0], p), abs=1e-6)
