"""The rod pulled by a spring: what it gets, what that costs, and who may pull where."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.live import Live
from rodgen.integrate.pull import Pull, pulled, with_place
from rodgen.live.replay import replay
from rodgen.live.run.link import follow, link_to
from rodgen.live.run.live_run import LiveRun
from rodgen.live.run.message import pull_array
from rodgen.loading import build
from rodgen.loading.module import asked
from rodgen.scene import Scene, SceneError
from tests.live.conftest import ROD, SCENES
from tests.live.view import until

STIFFNESS, DAMPING = 60.0, 1.5
PULL = Pull(3, 0.25, (1.3, 0.4), STIFFNESS, DAMPING)


def _scene(**integrate: Any) -> Scene:
    return Scene.from_dict({**ROD, "integrate": ROD["integrate"] | integrate})


def module(scene: Scene) -> ModuleType:
    """In NumPy: nothing is compiled."""
    return build(scene.structure, "numpy")


def _point(model: ModuleType, sample: Any, p: Any, pull: Pull = PULL) -> Any:
    start, end = model.joints(sample.y[-1], p)[pull.link : pull.link + 2]
    return start + pull.share * (end - start)


@pytest.mark.parametrize(
    ("settings", "error"),
    [
        ({"method": "dop853", "rtol": 1e-9}, 1e-6),
        # Order 4 at a tenth of the largest stable step, and order 6.
        ({"method": "rk4", "step": 5e-4}, 1e-5),
        ({"method": "gauss", "rtol": 1e-7}, 1e-4),
    ],
    ids=["adaptive", "fixed step", "implicit"],
)
def test_work_of_the_hand_is_what_the_energy_lacks(settings: Any, error: float) -> None:
    """By the energies of the module, and by k/2 (d'^2 - d^2) for each move of the far end from the
    distance d of its point to d'. error: of the balance [J], of some 10 J."""
    live = Live(_scene(**settings), module(_scene()), 0.01)
    live.advance(0.05, np.inf)
    before = live.here()
    live.allow_pulls(module(live_scene := with_place(live.scene)))
    np.testing.assert_array_equal(live.here().y, before.y)
    places = [(1.3 + 0.1 * k, 0.4 + 0.05 * k) for k in range(5)]
    by_hand, ends = 0.0, [None, *places, None]
    for before_it, to in zip(ends, [*ends[1:], None], strict=True):
        point = _point(live.model, live.here(), live.p)
        stored = [
            STIFFNESS * np.sum((point - end) ** 2) / 2 if end else 0.0 for end in (before_it, to)
        ]
        by_hand += stored[1] - stored[0]
        live.pull(Pull(3, 0.25, to, STIFFNESS, DAMPING) if to else None)
        live.advance(live.t + 0.05, np.inf)
    here = live.here()
    works = dict(zip(live.works, here.work[-1], strict=True))
    assert live_scene.structure.loads == live.placed.structure.loads
    assert abs(works["pull"]) > 0.5
    assert works["pull"] == pytest.approx(by_hand, abs=1e-9)
    assert works["supports"] < 0  # the damper
    with np.errstate(all="ignore"):
        energy = sum(asked(live.model, "energy", here.t[-1], here.y[-1], live.p))
    lacking = energy - sum(works.values()) - live.given - live.energy_start
    assert abs(lacking) < error
    assert abs(lacking + 2 * works["pull"]) > 0.5  # as it would be with the other sign


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Iterator[LiveRun]:
    for place in ("live_run", "pulling"):
        monkeypatch.setattr(f"rodgen.live.run.{place}.build_fastest", module)
    made = LiveRun(_scene(output_every=0.05))
    yield made
    made.close()


def test_run_takes_up_the_module_of_a_pull_where_it_is(run: LiveRun) -> None:
    run.do(lambda: run.add_plot({"kind": "time", "y": ["phi_0", "total_energy"]})).result()
    for _ in range(3):
        run.do(run.one_step).result()
    before = run.do(run.solution).result()
    wanted = run.do(run.allow_pulls).result()
    assert wanted is not None
    assert wanted.structure != run.live.scene.structure
    assert run.do(lambda: run.allow_pulls(wanted.structure)).result() is None
    after = run.do(run.solution).result()
    np.testing.assert_array_equal(after.t, before.t)
    np.testing.assert_array_equal(after.y, before.y)
    energies = [sol.values("total_energy") for sol in (after, before)]
    np.testing.assert_allclose(*energies, rtol=1e-13)
    assert {name: tuple(w) for name, w in before.work.items()}.items() <= {
        name: tuple(w) for name, w in after.work.items()
    }.items()
    assert [plot.catalogue for plot in run.plots.values()] == [run.catalogue]
    assert run.live.scene.supports == []  # the scene is the user's


def _pulled(run: LiveRun) -> None:
    """Step, pull to two places, and let go."""
    run.do(lambda: run.allow_pulls(with_place(run.live.scene).structure)).result()
    run.do(run.one_step).result()
    run.do(lambda: run.pull(PULL)).result()
    run.do(run.one_step).result()
    run.do(lambda: run.move_pull((1.5, 0.6))).result()
    until(lambda: run.live.pulling and run.live.pulling.to, (1.5, 0.6), "not moved")
    run.do(run.one_step).result()


def test_pull_is_on_the_record(run: LiveRun, tmp_path: Path) -> None:
    _pulled(run)
    run.do(run.let_go).result()
    run.do(run.one_step).result()
    assert [mark.what.partition(" by ")[0] for mark in run.marks.every] == [
        "pull at link 3",
        "pull ends",
    ]
    kept = run.do(lambda: list(run.store.chunks())[-1]).result()
    shown = run.catalogue.columns(["work_pull", "work_supports"], kept)
    assert shown[-1, 0] == kept.work[-1, kept.works.index("pull")] != 0
    sol = run.do(run.solution).result()
    sol.save(tmp_path / "run.nc")
    read = rodgen.load(tmp_path / "run.nc")
    np.testing.assert_array_equal(read.work["pull"], sol.work["pull"])
    assert read.work["pull"][-1] != 0
    assert "pull at link 3" in read.message
    # It begins and ends; that it is moved between is no mark.
    shown = replay(sol, [])
    assert b"pull" in shown.frames[2]
    assert shown.first.count(b"a change or a kick") == 2
    run.do(run.restart).result()
    assert (run.live.pulling, run.marks.every) == (None, ())


def test_a_link_to_a_pulled_state_holds_the_balance(run: LiveRun) -> None:
    """The rod of the link is not pulled, and its module has no place for that."""
    _pulled(run)
    link = run.do(lambda: link_to(run, "")).result()
    other = LiveRun(link.scene)
    try:
        other.do(lambda: follow(other, link)).result()
        here, there = (
            one.catalogue.columns(["energy_balance"], one.shown)[-1, 0] for one in (run, other)
        )
        assert there == pytest.approx(here, abs=1e-9)
    finally:
        other.close()


def test_force_is_that_of_the_spring() -> None:
    """By differences of the module's energy, and by Hooke's law."""
    scene = with_place(_scene())
    model, live = module(scene), Live(_scene(), module(_scene()), 0.01)
    live.allow_pulls(model)
    origin = (0.5, -0.25)

    def array() -> Any:
        sample = live.here()
        chunk = type("Chunk", (), {"t": sample.t, "y": sample.y, "p": live.p})
        return pull_array(model, live.placed, chunk, origin)[1]

    assert len(array()) == 0
    live.pull(PULL)
    force = STIFFNESS * (np.array(PULL.to) - _point(model, live.here(), live.p))
    wanted = [3, 0.25, *np.subtract(PULL.to, origin), *force]
    np.testing.assert_allclose(array(), wanted, rtol=1e-6)  # of single precision


def test_first_spring_suits_every_rod() -> None:
    """Also one along which the stiffness differs: as for an even one, of its mean."""
    usual = pytest.importorskip("rodgen.live.page.pulls", reason="nicegui is not installed").usual
    for path in SCENES.glob("*.toml"):
        stiffness, damping = usual(Scene.from_toml(path))
        assert stiffness > 0 <= damping
    one, several = (
        Scene.from_dict(
            {**ROD, "rod": ROD["rod"] | {"boundary": "clamped", "bending_stiffness": k}}
        )
        for k in (500.0, [800.0, 400.0, 500.0, 500.0, 600.0, 200.0])
    )
    assert usual(one) == usual(several)


SUPPORTED = {"boundary": "clamped", "links": 4}


@pytest.mark.parametrize(
    ("changed", "field"),
    [
        ({"link": 4}, "pull.link"),
        ({"link": 2, "share": 0.75}, "pull.link"),  # a support is at 0.5 of it
        ({"share": 1.5}, "pull.share"),
        ({"to": (np.nan, 0.0)}, "pull.to"),
        ({"stiffness": -1.0}, "pull.stiffness"),
        ({"damping": np.inf}, "pull.damping"),
    ],
)
def test_what_cannot_be_pulled_is_refused(changed: dict[str, Any], field: str) -> None:
    table = {**ROD, "rod": ROD["rod"] | SUPPORTED}
    scene = Scene.from_dict({**table, "supports": [{"at": 0.625, "stiffness": [1.0, 0.0]}]})
    allowed = {"link": 1, "share": 0.5, "to": (1.0, 0.0), "stiffness": 2.0, "damping": 0.0}
    assert len(pulled(scene, Pull(**allowed)).supports) == 2
    with pytest.raises(SceneError) as refused:
        pulled(scene, Pull(**allowed | changed))
    assert refused.value.field == field
    table["rod"] = table["rod"] | {"boundary": "cantilever"}
    with pytest.raises(SceneError, match=r"pull\.link"):
        pulled(with_place(Scene.from_dict(table)), Pull(**allowed | {"link": 0}))
