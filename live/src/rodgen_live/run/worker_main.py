"""Program of the worker process (see worker_process.py): a part of each request in turn."""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, TextIO

import numpy as np

from rodgen.analyse.critical import critical_load
from rodgen.errors import AnalysisError, InputError
from rodgen.loading import build_fastest
from rodgen.result import collect_doubts
from rodgen.scene import Scene
from rodgen_live.run.frozen_modes import frozen_modes
from rodgen_live.run.sweep_computation import sweep

MOST_MODES, MOST_LINKS = 12, 250  # shown; beyond so many links they take seconds
GROWS = 1e-6  # 1/s over Hz: below, growth is rounding
POLITE = 10  # how far it stands back behind the run and the browser

Work = Iterator[Any]
Requests = queue.SimpleQueue[dict[str, Any] | None]


def critical_force(scene: Scene) -> Work:
    """Compute the critical follower force [N] at the start."""
    yield critical_load(scene, t=scene.integrate.span[0]).value


def mode_shapes(scene: Scene, t: float, y: list[float], p: list[float]) -> Work:
    """Compute modes about the positions of a state at time t [s], with the parameters p of the
    module, for the page: names, captions, and displacements of the joints x0, y0, ..., real and
    imaginary."""
    if scene.rod.links > MOST_LINKS:
        links = scene.rod.links
        raise InputError("rod.links", links, f"at most {MOST_LINKS} for modes on the page")
    model = build_fastest(scene)
    found = frozen_modes(model, t, np.array(y), np.array(p), MOST_MODES)
    named = [
        f"{k}: {hertz:.4g} Hz" + (", grows" if rate > GROWS * hertz else "")
        for k, (hertz, rate) in enumerate(zip(found.frequencies, found.growth, strict=True), 1)
    ]
    yield [
        {
            "name": name,
            "text": f"mode {name}, about the rod as at t = {t:.4g} s",
            "re": shape.real.ravel().round(6).tolist(),
            "im": shape.imag.ravel().round(6).tolist(),
        }
        for name, shape in zip(named, found.displacements, strict=True)
    ]


WORKS: dict[str, Callable[..., Work]] = {
    "critical": critical_force,
    "modes": mode_shapes,
    "sweep": sweep,
}


class RequestQueue:
    """Requests under way, by their numbers."""

    def __init__(self, answer: Callable[..., object]):
        self._answer = answer
        self._works: dict[int, Work] = {}

    def __len__(self) -> int:
        return len(self._works)

    def accept(self, request: dict[str, Any]) -> None:
        """Start a request, or cancel the one of that number."""
        number = request["number"]
        self._works.pop(number, None)
        if "what" in request:
            self._works[number] = _compute(**request)

    def advance(self) -> None:
        """Compute and answer a part of the request that has waited longest."""
        number, work = next(iter(self._works.items()))
        del self._works[number]
        try:
            with collect_doubts():  # nobody reads what is printed here
                value = next(work, None)
        except (AnalysisError, InputError) as error:
            self._answer(number, refused=str(error), last=True)
        except Exception as error:  # a defect: whoever waits is told
            traceback.print_exc()
            self._answer(number, refused=f"rodgen has failed: {error!r}", last=True)
        else:
            self._answer(number, value=value, last=value is None)
            if value is not None:
                self._works[number] = work


def _compute(number: int, what: str, scene: dict[str, Any], more: dict[str, Any]) -> Work:
    yield from WORKS[what](Scene.from_dict(scene), **more)


def _read_requests(lines: TextIO, requests: Requests) -> None:
    for line in lines:
        requests.put(json.loads(line))
    requests.put(None)


def main() -> None:
    """Answer requests until there are no more."""
    if hasattr(os, "nice"):
        os.nice(POLITE)
    # What analyses print is no answer; and where they fork, the child would wait for who reads.
    answers, sys.stdout = sys.stdout, sys.stderr
    lines, sys.stdin = sys.stdin, None

    def write(number: int, **answer: Any) -> None:
        print(json.dumps({"number": number, **answer}), file=answers, flush=True)

    requests: Requests = queue.SimpleQueue()
    threading.Thread(target=_read_requests, args=(lines, requests), daemon=True).start()
    works = RequestQueue(write)
    while True:
        while not (len(works) and requests.empty()):
            request = requests.get()
            if request is None:
                return
            works.accept(request)
        works.advance()


if __name__ == "__main__":
    with suppress(BrokenPipeError):  # the server has ended: nobody waits for an answer
        main()
