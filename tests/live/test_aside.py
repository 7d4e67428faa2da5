"""What is computed in a process beside the server: answers, what is dropped, and its death."""

from __future__ import annotations

import queue
import signal
from collections.abc import Iterator
from typing import Any

import pytest

import rodgen
from rodgen.live.run import critical
from rodgen.live.run.aside import Answer, Aside, Errand
from rodgen.live.run.critical import COMPUTING, Critical
from rodgen.scene import Scene
from tests.live.conftest import ROD
from tests.live.view import PATIENT

SCENE = Scene.from_dict(ROD)


@pytest.fixture
def aside() -> Iterator[Aside]:
    made = Aside()
    yield made
    made.close()


class Told(queue.Queue[Answer]):
    """Answers in the order in which they came."""

    def all(self) -> list[Answer]:
        """Up to the last."""
        found = [self.get(timeout=PATIENT)]
        while not found[-1].last:
            found.append(self.get(timeout=PATIENT))
        return found


def test_answer_is_what_this_process_computes(aside: Aside) -> None:
    told = Told()
    aside.ask("critical", SCENE, told.put)
    wanted = rodgen.critical_force(SCENE).force
    # By the same code, from the same numbers as text with all their digits.
    assert told.all() == [Answer(wanted), Answer(last=True)]


def test_refusal_is_told_in_words(aside: Aside) -> None:
    told = Told()
    aside.ask("critical", Scene.from_dict({**ROD, "loads": {}}), told.put)
    aside.ask("nothing", SCENE, told.put)
    refused = [answer.refused for answer in told.all() + told.all()]
    assert "follow" in refused[0]
    assert refused[1].startswith("rodgen has failed: KeyError")


def test_what_is_dropped_is_not_told(aside: Aside) -> None:
    dropped, told = Told(), Told()
    errands = [aside.ask("critical", SCENE, dropped.put) for _ in range(50)]
    for errand in errands:
        errand.drop()
    aside.ask("critical", SCENE, told.put)
    told.all()
    assert dropped.empty()


def test_process_that_dies_is_told_of_and_started_again(aside: Aside) -> None:
    told = Told()
    aside.ask("critical", SCENE, told.put)
    assert aside._process is not None
    aside._process.send_signal(signal.SIGKILL)
    assert [answer.refused for answer in told.all()][-1] == "the process that computes it has ended"
    aside.ask("critical", SCENE, told.put)
    assert told.all()[0].value is not None


class Asked(Aside):
    """Keeps what it is asked."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: list[tuple[float, Any]] = []
        self.dropped: list[int] = []

    def ask(self, what: str, scene: Scene, told: Any, **more: Any) -> Any:
        self.asked.append((scene.loads.follower.force, told))
        return Errand(self, len(self.asked))

    def drop(self, number: int) -> None:
        self.dropped.append(number)


def test_force_of_a_scene_that_changes_is_asked_for_once(
    clock: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """When nothing has changed for a while; an answer for the scene before is not taken, nor is
    it waited for."""
    asked, done = Asked(), []
    monkeypatch.setattr(critical, "ASIDE", asked)
    one = Critical(lambda work: work(), lambda: done.append(one.value), clock)
    for force in (1.0, 2.0, 3.0):
        one.look(scene_with(force))
        clock.now += 0.3
        one.tick()
    assert asked.asked == []
    clock.now += 0.3
    one.tick()
    one.tick()
    assert [force for force, _ in asked.asked] == [3.0]
    one.look(scene_with(4.0))
    assert asked.dropped == [1]
    asked.asked[0][1](Answer(30.0))
    assert (one.value, done) == (COMPUTING, [])
    clock.now += 1.0
    one.tick()
    asked.asked[1][1](Answer(40.0))
    asked.asked[1][1](Answer(last=True))
    assert (one.value, done) == (40.0, [40.0])


def scene_with(force: float) -> Scene:
    return Scene.from_dict({**ROD, "loads": {"follower": {"force": force}}})
