"""How fast a live run should go and goes, by a clock that is moved by hand."""

from __future__ import annotations

import math
from typing import Any

import pytest

from rodgen.live.run.worker import Pace


@pytest.mark.parametrize("speed", [0.01, 1.0, 5.0])
def test_time_due_follows_the_clock(clock: Any, speed: float) -> None:
    pace = Pace(speed, clock)
    pace.start(3.0)
    clock.now += 2.0
    assert pace.due() == pytest.approx(3.0 + 2.0 * speed)


def test_run_that_cannot_keep_up_is_not_chased(clock: Any) -> None:
    """It comes to half of what is due each time: the arrears do not grow."""
    pace, t = Pace(1.0, clock), 0.0
    pace.start(t)
    for _ in range(600):
        clock.now += 1 / 60
        t += (pace.due() - t) * 0.5 if pace.due() - t > 0.01 else 0.0
        pace.reached(t)
    assert pace.due() - t < 0.11  # seconds
    for _ in range(120):  # half as fast as the clock
        clock.now += 1 / 60
        t += 0.5 / 60
        pace.reached(t)
    assert pace.due() - t < 0.11
    assert pace.ratio == pytest.approx(0.5, rel=0.02)


def test_as_fast_as_it_goes(clock: Any) -> None:
    pace = Pace(math.inf, clock)
    pace.start(1.0)
    assert pace.due() == math.inf
    assert pace.ratio is None


@pytest.mark.parametrize(
    ("reached", "spent", "missed"),
    [
        (0.5, 0.5, True),  # half of what is due, all of it in steps
        (0.5, 0.01, False),  # the machine is busy with other things
        (1.0, 0.9, False),
    ],
)
def test_real_time_is_missed_where_steps_are_what_takes_so_long(
    clock: Any, reached: float, spent: float, missed: bool
) -> None:
    """Not from the first moment: a run is given two seconds."""
    pace, t, seen = Pace(1.0, clock), 0.0, []
    pace.start(t)
    for _ in range(180):
        clock.now += 1 / 60
        t += reached / 60
        pace.spend(spent / 60)
        pace.reached(t)
        seen.append(pace.missed)
    assert not any(seen[:119])
    assert seen[-1] == missed
    pace.speed = math.inf
    assert not pace.missed
