"""Messages to a page, read as it reads them, while pages come and go; trails that are whole."""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.live import Live
from rodgen.live.run import page_state
from rodgen.live.run.marks import Marks
from rodgen.live.run.message import LONGEST_TRAIL, TRAIL_AT_FIRST, Trail, encode, rod_arrays
from rodgen.live.run.page_state import AHEAD, PageState
from rodgen.live.samples import Chunk, Store
from rodgen.loading import build_fastest
from rodgen.scene import Scene
from tests.live.conftest import ROD


class Stepped:
    """What a page state asks of a run, without a thread: it goes on when it is told to."""

    def __init__(self, scene: Scene):
        self.model, self.status = build_fastest(scene), "running"
        self.live = Live(scene, self.model, scene.integrate.output_every)
        self.plots: dict[str, Any] = {}
        self.marks, self.past, self.ghost, self.keeps = Marks(), None, None, False
        self.begun, self.goes_round = 0, False
        self.page = PageState()
        self.begin()

    def begin(self) -> None:
        live = self.live
        live.restart()
        self.store = Store(live.states, live.works, live.energy_start)
        self.store.change(live.p, 0.0)
        self.page.restarted(self.plots)
        self.to(0.0)

    def to(self, t: float) -> None:
        """Samples up to a time."""
        chunk = self.store.add(self.live.advance(t, 60.0))
        self.seen = chunk.last()
        self.page.fed(self.plots, chunk)

    def present(self) -> None:
        """What texts are made of."""


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Stepped:
    monkeypatch.setattr(page_state, "texts", lambda *_: {})
    return Stepped(Scene.from_dict(ROD))


@pytest.fixture
def arrays(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, np.ndarray]]:
    """The arrays of every message that is made."""
    made: list[dict[str, np.ndarray]] = []

    def kept(header: dict[str, Any], given: Any) -> bytes:
        made.append(dict(given))
        return encode(header, list(made[-1].items()))

    monkeypatch.setattr(page_state, "encode", kept)
    return made


def while_made(monkeypatch: pytest.MonkeyPatch, does: Callable[[], None]) -> None:
    """Something happens in the middle of the next message."""

    def meanwhile(*_: Any) -> dict[str, str]:
        does()
        return {}

    monkeypatch.setattr(page_state, "texts", meanwhile)


# Pages that come and go ------------------------------------------------------------------------


def test_page_leaves_while_its_message_is_made(
    run: Stepped, monkeypatch: pytest.MonkeyPatch
) -> None:
    got: list[bytes] = []
    run.page.attach(got.append)
    while_made(monkeypatch, lambda: run.page.detach(got.append))
    run.page.show(run)
    assert not run.page.watched
    count = len(got)
    run.to(0.1)
    run.page.show(run)
    assert len(got) == count  # nothing more to a page that is gone


def test_page_comes_while_the_message_of_another_is_made(
    run: Stepped, arrays: list[dict[str, np.ndarray]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It gets everything, and its coming is not forgotten when the other one leaves late."""
    first: list[bytes] = []
    second: list[bytes] = []
    run.page.attach(first.append)
    while_made(monkeypatch, lambda: run.page.attach(second.append))
    run.page.show(run)
    while_made(monkeypatch, lambda: run.page.detach(first.append))
    run.page.show(run)
    assert run.page.watched
    assert len(second) == 1
    assert "trail!" in arrays[-1]
    run.page.detach(second.append)
    assert not run.page.watched


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


def test_every_sample_since_the_last_message_is_in_the_trail(
    run: Stepped, arrays: list[dict[str, np.ndarray]]
) -> None:
    """Against a run without a page, at its own samples."""
    sol = rodgen.simulate(Scene.from_dict(ROD))
    expected = np.c_[sol.tip, sol.centre_of_gravity, sol.t]
    run.to(0.2)
    run.page.attach(lambda _: None)
    run.page.show(run)
    first = arrays[-1]["trail!"].reshape(-1, 5)
    assert first == pytest.approx(expected[:21], abs=1e-9)
    for t in (0.25, 0.3, 0.6):
        run.to(t)
    run.page.show(run)
    assert arrays[-1]["trail"].reshape(-1, 5) == pytest.approx(expected[21:61], abs=1e-9)
    run.begin()
    run.page.acknowledge(2)
    run.page.show(run)
    assert arrays[-1]["trail!"].reshape(-1, 5) == pytest.approx(expected[:1], abs=1e-9)


@pytest.mark.parametrize("changing", [False, True])
def test_trail_of_a_page_that_does_not_answer_stays_short(run: Stepped, changing: bool) -> None:
    """Whether parameters are the same all the time, or others for every sample."""
    chunk, trail = run.seen, Trail()
    trail.take(run.model, run.store)
    for x in range(5000):
        y = chunk.y.copy()
        y[:, 0] = x  # joint 0, and everything with it
        p = chunk.p.copy() if changing else chunk.p
        trail.follow(Chunk(chunk.t, y, chunk.work, chunk.works, p))
    places = trail.take(run.model, run.store)
    steps = np.diff(places[:, 0])
    assert LONGEST_TRAIL / 3 < len(places) <= LONGEST_TRAIL
    assert steps.min() > 0
    assert np.ptp(places[:, 0]) > 0.9 * 5000
    assert not len(trail.take(run.model, run.store))


def test_page_that_comes_late_gets_the_last_places(run: Stepped) -> None:
    run.live.sample_every(1e-4)
    run.to(0.5)
    places = Trail().take(run.model, run.store)
    assert len(places) == TRAIL_AT_FIRST
    assert places[-1, :2] == pytest.approx(run.model.joints(run.seen.y[-1], run.seen.p)[-1])


# The rod ---------------------------------------------------------------------------------------


def test_every_load_that_a_page_draws_is_told(make_scene: Callable[..., Scene]) -> None:
    """Against the module: a force for each joint, gravity beside the centre of gravity."""
    elements = pytest.importorskip("rodgen.live.page.elements", reason="nicegui is not installed")
    scene = make_scene(3, terms=tuple(elements.LOADS))
    model = rodgen.build(scene, "numpy")
    y, p = scene.initial_state()[None], model.parameters(**scene.parameters)
    origin, found = rod_arrays(model, Chunk(np.array([0.3]), y, np.zeros((1, 0)), (), p))
    arrays = dict(found)
    for name, term in elements.LOADS.items():
        if elements.ARROWS[term.kind] == "mass":
            assert arrays["point"][3] == pytest.approx(9.81)
        else:
            force = model.forces(0.3, y[0], p)[name]
            assert np.abs(force).max() > 0
            assert arrays[f"forces:{name}"] == pytest.approx(force.ravel(), rel=1e-6)  # single
    assert arrays["joints"].reshape(-1, 2) + origin == pytest.approx(
        model.joints(y[0], p), abs=1e-6
    )


# Their form ------------------------------------------------------------------------------------


def _decoded(message: bytes) -> tuple[dict[str, object], dict[str, np.ndarray]]:
    """By the rule alone: uint32, header, arrays from multiples of 8 bytes on."""
    (length,) = struct.unpack_from("<I", message)
    header = json.loads(message[4 : 4 + length])
    at, found = 4 + length, {}
    for name, kind, count in header.pop("arrays"):
        assert at % 8 == 0  # typed arrays of the browser need it
        size = {"f4": 4, "f8": 8}[kind]
        found[name] = np.frombuffer(message, f"<{kind}", count, at)
        at += -(-size * count // 8) * 8
    assert at == len(message)
    return header, found


@pytest.mark.parametrize("count", [0, 1, 2, 3, 101])
def test_what_goes_in_comes_out(count: int) -> None:
    single = np.linspace(-1, 1, count).astype(np.float32)
    double = np.linspace(0, 1e12, count)
    message = encode({"frame": 7, "texts": {"t": "1 µs"}}, [("a", single), ("plot:p1", double)])
    header, arrays = _decoded(message)
    assert header == {"frame": 7, "texts": {"t": "1 µs"}}
    assert np.array_equal(arrays["a"], single)
    assert np.array_equal(arrays["plot:p1"], double)


def test_not_a_number_goes_into_arrays_alone() -> None:
    _, arrays = _decoded(encode({"frame": 1}, [("a", np.array([np.nan, np.inf]))]))
    assert np.isnan(arrays["a"][0])
    assert np.isinf(arrays["a"][1])
    with pytest.raises(ValueError, match="not JSON compliant"):
        encode({"t": float("nan")}, [])


def test_no_address_of_another_server_is_in_the_components() -> None:
    import rodgen.live as home

    files = [p for p in Path(home.__path__[0]).rglob("*") if p.suffix in (".js", ".css", ".py")]
    assert any(p.suffix == ".js" for p in files)
    for path in files:
        # A comment that a copied library begins with says where it comes from.
        text = re.sub(r"^/\*!.*?\*/", "", path.read_text(encoding="utf-8"))
        for scheme in ("http://", "https://", "//cdn", "wss://"):
            rest = text.replace('f"http://{', "").replace("http://www.w3.org/2000/svg", "")
            assert scheme not in rest, path
