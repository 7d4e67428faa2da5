"""Program of the worker process (see worker_process.py): a part of each request in turn."""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from rodgen.analyse.critical import critical_load
from rodgen.analyse.frozen_modes import frozen_motions
from rodgen.errors import AnalysisError, InputError
from rodgen.loading import build_fastest
from rodgen.result import collect_doubts
from rodgen.scene import Scene
from rodgen_live.run.sweep_computation import sweep

MOST_MODES, MOST_LINKS = 12, 250  # shown; beyond so many links they take seconds
GROWS = 1e-7  # of the modulus: below, growth is rounding
POLITE = 10  # how far it stands back behind the run and the browser
MOST_BEGUN = 100  # computations: of those that are cancelled nobody hears

Work = Iterator[Any]


def critical_force(scene: Scene) -> Work:
    """Compute the critical follower force at the start: its value [N], the rows of the result as
    text, by their words, and its notes."""
    found = critical_load(scene, t=scene.integrate.span[0])
    rows = {row[0]: row[1] for row in found.tables()[0].rows}
    yield {"value": found.value, "rows": rows, "notes": [note.text for note in found.notes]}


def mode_shapes(scene: Scene, t: float, y: list[float], p: list[float]) -> Work:
    """Compute modes about the positions of a state at time t [s], with the parameters p of the
    module, for the page: names, captions, and displacements of the joints x0, y0, ..., real and
    imaginary."""
    if scene.rod.links > MOST_LINKS:
        links = scene.rod.links
        raise InputError("rod.links", links, f"at most {MOST_LINKS} for modes on the page")
    model = build_fastest(scene)
    span = float(np.ptp(scene.integrate.span))
    found = frozen_motions(model, t, np.array(y), np.array(p), MOST_MODES, span)
    named = [
        f"{k}: {s.imag / (2 * np.pi):.4g} Hz" + ", grows" * bool(s.real > GROWS * abs(s))
        for k, s in enumerate(found.s[:MOST_MODES], 1)  # of a chain upside down each grows
    ]
    yield [
        {
            "name": name,
            "text": f"mode {name}, about the rod as at t = {t:.4g} s",
            "re": shape.real.ravel().round(6).tolist(),
            "im": shape.imag.ravel().round(6).tolist(),
        }
        for name, shape in zip(named, found.displacements, strict=False)
    ]


WORKS: dict[str, Callable[..., Work]] = {
    "critical": critical_force,
    "modes": mode_shapes,
    "sweep": sweep,
}


class Works:
    """Computations that were begun last, by numbers."""

    def __init__(self) -> None:
        self._begun: dict[int, Work] = {}

    def answer(self, number: int, **asked: Any) -> dict[str, Any]:
        """Answer with the next part of a computation, which is begun if it is asked for what."""
        if asked:
            self._begun[number] = _compute(**asked)
            self._begun = dict(list(self._begun.items())[-MOST_BEGUN:])
        try:
            with collect_doubts():  # nobody reads what is printed here
                value = next(self._begun[number], None)
            return {"value": value, "last": value is None}
        except (AnalysisError, InputError) as error:
            return {"refused": str(error), "last": True}
        except Exception as error:  # a defect: whoever waits is told
            traceback.print_exc()
            return {"refused": f"rodgen has failed: {error!r}", "last": True}


def _compute(what: str, scene: dict[str, Any], more: dict[str, Any]) -> Work:
    yield from WORKS[what](Scene.from_dict(scene), **more)


def main() -> None:
    """Answer requests until there are no more."""
    if hasattr(os, "nice"):
        os.nice(POLITE)
    # What analyses print is no answer; and where they fork, the child would wait for who reads.
    answers, sys.stdout = sys.stdout, sys.stderr
    requests, sys.stdin = sys.stdin, None
    works = Works()
    for request in requests:
        print(json.dumps(works.answer(**json.loads(request))), file=answers, flush=True)


if __name__ == "__main__":
    with suppress(BrokenPipeError):  # the server has ended: nobody waits for an answer
        main()
