"""Answers of a page on its channel: what it has drawn, where it looks, which run it keeps."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

from rodgen.scene.plain_tables import is_number
from rodgen_live.run.live_run import LiveRun

LONGEST = 200  # letters; what is longer is cut, and so is no JSON


def _acknowledge(run: LiveRun, frame: int) -> None:
    run.page.acknowledge(frame)


def _look(run: LiveRun, t: float | None) -> None:
    if t is None:
        run.submit(run.look_at_present)
    else:
        run.submit(lambda: run.look_at(t))


def _step(run: LiveRun, by: int) -> None:
    run.submit(lambda: run.step_view(by))


def _keep(run: LiveRun, keeps: bool) -> None:
    run.submit(lambda: run.keep_runs(keeps))


def _branch(run: LiveRun, _: None) -> None:
    run.submit(run.branch)


def _is_flag(value: object) -> bool:
    return isinstance(value, bool)


def _is_null(value: object) -> bool:
    return value is None


def _is_time(value: object) -> bool:
    return value is None or (is_number(value) and math.isfinite(value))


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


# By key of the answer: whether its value is one, and what comes of it.
ANSWERS: dict[str, tuple[Callable[[object], bool], Callable[[LiveRun, Any], None]]] = {
    "ack": (_is_count, _acknowledge),
    "look": (_is_time, _look),
    "step": (_is_count, _step),
    "keep": (_is_flag, _keep),
    "branch": (_is_null, _branch),
}


def act_on_answer(run: LiveRun, text: str) -> bool:
    """Act on an answer of a page: {"ack": number of a message} that it has drawn, {"look": t [s]}
    or null for the present, {"step": samples}, {"keep": whether runs are kept as ghosts},
    {"branch": null} for another run from here. Returns False for anything else."""
    try:
        ((key, value),) = json.loads(text[:LONGEST]).items()
        fits, act = ANSWERS[key]
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return False
    if fits(value):
        act(run, value)
        return True
    return False
