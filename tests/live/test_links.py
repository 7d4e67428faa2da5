"""An address that holds what is shown: scene, plots, view, time and state."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

from rodgen.live.run.link import Link, State, follow, link_to
from rodgen.live.run.live_run import LiveRun
from rodgen.live.run.scenes import edit
from rodgen.scene import Scene, SceneError
from tests.live.conftest import ROD
from tests.live.view import expect

View = Any  # see conftest.py
SCENE = Scene.from_dict(ROD)
TAIL = {"kind": "time", "y": ["phi_4"], "window": 3.0}


def made() -> LiveRun:
    run = LiveRun(SCENE)
    run.do(lambda: run.add_plot(TAIL)).result()
    run.do(lambda: run._took(run.live.advance(0.3, 10.0))).result()
    return run


@pytest.fixture
def run() -> Iterator[LiveRun]:
    run = made()
    yield run
    run.close()


@pytest.fixture
def other() -> Iterator[LiveRun]:
    other = LiveRun(SCENE)
    yield other
    other.close()


def test_link_brings_back_plots_view_time_and_state(run: LiveRun, other: LiveRun) -> None:
    """And what was done up to there: the balance of the other run goes on as that of the first,
    over a change of its mass, which is of after the sample that is looked at."""
    heavier = edit(SCENE, [(("rod", "mass"), 4.0)])
    run.do(lambda: run.change(heavier, "rod.mass = 4")).result()
    run.do(lambda: run.look_at(0.2)).result()
    link = Link.unpack(run.do(lambda: link_to(run, "axes")).result().pack())
    assert (link.scene, link.view) == (heavier, "axes")
    other.do(lambda: other.take(link.scene)).result()
    other.do(lambda: follow(other, link)).result()
    assert other.undo.file == SCENE
    assert other.store.span == (0.2, 0.2)
    assert other.shown.y == pytest.approx(run.seen.y, abs=0.0)
    ((name, plot),) = other.plots.items()
    assert plot.spec == replace(run.plots["p1"].spec, id=name)
    other.do(lambda: other._took(other.live.advance(0.4, 10.0))).result()
    balance = other.catalogue.columns(["energy_balance"], other.shown)[0, 0]
    assert balance == pytest.approx(0.0, abs=1e-6)  # rtol 1e-8 of some 30 J


def test_state_of_a_very_long_rod_is_left_out() -> None:
    state = State(1.0, (0.5,) * 2001, (), 0.0, 0.0)
    assert Link.unpack(Link(SCENE, state=state).pack()).state is None


@pytest.mark.parametrize(
    "page",
    [
        *("page = 3", "[page]\nplots = 3", "[page]\nview = 3", "[page]\nstate = 3"),
        "[page.state]\nt = 1.0",
        "[page.state]\nt = nan\ny = []\nwork = []\ngiven = 0\nstart = 0",
        '[page.state]\nt = 0\ny = ["x"]\nwork = []\ngiven = 0\nstart = 0',
        "[page.state]\nt = 0\ny = 3\nwork = []\ngiven = 0\nstart = 0",
    ],
)
def test_other_pages_are_refused(page: str) -> None:
    before, after = (page, "") if page.startswith("page") else ("", page)
    text = f"{before}\n{SCENE.to_toml()}\n{after}"
    with pytest.raises(SceneError, match="page"):
        Link.unpack(base64.urlsafe_b64encode(zlib.compress(text.encode())).decode())


def test_state_of_another_rod_is_refused(other: LiveRun) -> None:
    link = Link(SCENE, state=State(1.0, (0.0,), (), 0.0, 0.0))
    with pytest.raises(SceneError, match=r"page\.state"):
        other.do(lambda: follow(other, link)).result()
    assert other.store.span == (0.0, 0.0)


@pytest.mark.nightly
def test_link_is_followed_by_another_page(view: View, another: Any) -> None:
    """Which marks what differs from the file."""
    view.tab("Parameters").fill("mass M", "4")
    view.pause_after(0.4)
    view.add_plot("over time", quantities="phi_2")
    view.page.get_by_role("slider", name="Time that is shown").press("PageDown")
    view.sees("rodgenLive.past !== null", True, "the past is not shown")
    t = view.live("t")
    view.tab("Save").button("Link to what").click()
    field = view.page.get_by_role("textbox", name="link")
    expect(field).to_be_visible()
    follower = another().open(field.input_value())
    assert follower.live("t") == t
    follower.sees("Object.keys(rodgenLive.plots).length", 3, "not the same plots")
    assert follower.page.evaluate("rodgenLive.state") == "paused"
    expect(follower.page.get_by_text("in the file: 3")).to_be_visible()
    assert follower.page.get_by_role("combobox", name="Scene").input_value() == "dart"
