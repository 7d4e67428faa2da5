"""The rod pulled by a spring: what it gets, what that costs, and who may pull where."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from live.tests.conftest import varied
from live.tests.runs import does
from live.tests.view import until
from rodgen.loading import build
from rodgen.loading.generated_module import call_module
from rodgen.scene import Scene, Structure
from rodgen.system import System
from rodgen_live.open_run import Live
from rodgen_live.page.pulls import usual_spring
from rodgen_live.pull import Pull, with_idle_support, with_pull
from rodgen_live.run.link import apply_link, make_link
from rodgen_live.run.live_run import LiveRun
from tests.palette import ROD
from tests.told import refused

STIFFNESS, DAMPING = 60.0, 1.5
PULL = Pull(3, 0.25, (1.3, 0.4), STIFFNESS, DAMPING)


def scene(**integrate: Any) -> Scene:
    return Scene.from_dict({**ROD, "integrate": ROD["integrate"] | integrate})


def module(structure: Structure) -> ModuleType:
    """In NumPy: nothing is compiled."""
    return build(structure, "numpy")


@pytest.mark.parametrize(
    ("settings", "error"),
    [
        pytest.param({"method": "dop853", "rtol": 1e-9}, 1e-6, id="adaptive"),
        # Order 4 at a tenth of the largest stable step, and order 6.
        pytest.param({"method": "rk4", "step": 5e-4}, 1e-5, id="equal", marks=pytest.mark.slow),
        pytest.param({"method": "gauss", "rtol": 1e-7}, 1e-4, id="gauss", marks=pytest.mark.slow),
    ],
)
def test_work_of_the_hand_is_what_the_energy_lacks(settings: Any, error: float) -> None:
    """By the energies of the module, and by k/2 (d'^2 - d^2) for each move of the far end from the
    distance d of its point to d'. error: of the balance [J], of some 10 J."""
    live = Live(scene(**settings), module(scene().structure), 0.01)
    live.advance(0.05, np.inf)
    before = live.here()
    live.allow_pulls(module(with_idle_support(live.system).structure))
    np.testing.assert_array_equal(live.here().y, before.y)
    by_hand, ends = 0.0, [None, *((1.3 + 0.1 * k, 0.4 + 0.05 * k) for k in range(5)), None]
    for start, to in zip(ends, [*ends[1:], None], strict=True):
        first, last = live.model.joints(live.here().y[-1], live.p)[PULL.link : PULL.link + 2]
        at = first + PULL.share * (last - first)  # the point that is pulled
        stored = [STIFFNESS * np.sum((at - end) ** 2) / 2 if end else 0.0 for end in (start, to)]
        by_hand += stored[1] - stored[0]
        live.pull(replace(PULL, to=to) if to else None)
        live.advance(live.t + 0.05, np.inf)
    here = live.here()
    works = dict(zip(live.works, here.work[-1], strict=True))
    assert abs(live.given) > 0.5
    assert live.given == pytest.approx(by_hand, abs=1e-9)
    assert works["supports"] < 0  # the damper
    with np.errstate(all="ignore"):
        energy = sum(call_module(live.model, "energy", here.t[-1], here.y[-1], live.p))
    lacking = energy - sum(works.values()) - live.given - live.energy_start
    assert abs(lacking) < error
    assert abs(lacking + 2 * live.given) > 0.5  # as it would be with the other sign


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Any:
    for place in ("live_run", "pulling"):
        monkeypatch.setattr(f"rodgen_live.run.{place}.build_fastest", module)
    made = LiveRun(scene(output_every=0.05))
    yield made
    made.close()


def pulls(run: LiveRun) -> None:
    """Step, and pull to two places."""
    does(run, partial(run.allow_pulls, with_idle_support(run.live.system).structure), run.one_step)
    does(run, lambda: run.pull(PULL), run.one_step, lambda: run.move_pull((1.5, 0.6)))
    until(lambda: run.live.pulling and run.live.pulling.to, (1.5, 0.6), "not moved")
    does(run, run.one_step)


def test_pull_is_on_the_record_and_in_a_link_to_it(run: LiveRun) -> None:
    """The rod of the link is not pulled, and its module has no place for that: the balance is the
    same."""
    pulls(run)
    link = does(run, lambda: make_link(run, ""))
    other = LiveRun(link.scene)
    does(other, lambda: apply_link(other, link))
    here, there = (one.catalogue.columns(["energy_balance"], one.shown)[-1] for one in (run, other))
    other.close()
    assert there == pytest.approx(here, abs=1e-9)
    does(run, run.release_pull, run.one_step)
    assert len(run.marks.every) == 2  # it begins and ends; that it is moved between is no mark
    kept = does(run, lambda: list(run.store.chunks())[-1])
    (shown,) = run.catalogue.columns(["work_supports"], kept)[-1]
    assert shown == kept.work[-1, kept.works.index("supports")] != 0
    sol = does(run, run.solution)
    assert sol.energy_input[-1] == kept.given != 0
    for mark in run.marks.every:
        assert mark.what in sol.message
    does(run, run.restart)
    assert (run.live.pulling, run.marks.every) == (None, ())


def test_first_spring_suits_a_rod_along_which_the_stiffness_differs() -> None:
    """As for an even one, of its mean."""
    one, several = (
        usual_spring(Scene.from_dict(varied(boundary="clamped", bending_stiffness=k)))
        for k in (500.0, [800.0, 400.0, 500.0, 500.0, 600.0, 200.0])
    )
    assert one == several


def test_what_cannot_be_pulled_is_refused() -> None:
    table = varied(boundary="clamped", links=4)
    held = System(Scene.from_dict({**table, "supports": [{"at": 0.625, "stiffness": [1.0, 0.0]}]}))
    allowed = {"link": 1, "share": 0.5, "to": (1.0, 0.0), "stiffness": 2.0, "damping": 0.0}
    assert len(with_pull(held, Pull(**allowed)).scene.supports) == 2
    ended = with_idle_support(Scene.from_dict(varied(boundary="cantilever", links=4)))
    for one, changed, field in (
        (held, {"link": 4}, "link"),
        (held, {"link": 2, "share": 0.75}, "link"),  # a support is at 0.5 of it
        (held, {"share": 1.5}, "share"),
        (held, {"to": (np.nan, 0.0)}, "to"),
        (held, {"stiffness": -1.0}, "stiffness"),
        (held, {"damping": np.inf}, "damping"),
        (ended, {"link": 0}, "link"),
    ):
        assert refused(with_pull, one, Pull(**allowed | changed)).field == f"pull.{field}"
