"""Program of the worker process (see worker_process.py): a part of each request in turn."""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.critical import critical_load
from rodgen.analyse.modes import joint_displacements
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.loading import build_fastest
from rodgen.result import collect_doubts
from rodgen.scene import Scene
from rodgen_live.run.sweep_computation import sweep

MOST_MODES, MOST_LINKS = 12, 250  # shown; beyond so many links they take seconds
STILL = 1e-7  # of the largest modulus: an imaginary part below it is rounding
GROWS = 1e-6  # 1/s over Hz: below, growth is rounding
POLITE = 10  # how far it stands back behind the run and the browser
MOST_BEGUN = 100  # computations: of those that are cancelled nobody hears

Work = Iterator[Any]


def critical_force(scene: Scene) -> Work:
    """Compute the critical follower force at the start: its value [N], the rows of the result as
    text, by their words, and its notes."""
    found = critical_load(scene, t=scene.integrate.span[0])
    rows = {row[0]: row[1] for row in found.tables()[0].rows}
    yield {"value": found.value, "rows": rows, "notes": [note.text for note in found.notes]}


class FrozenModes(NamedTuple):
    """Modes about a state. frequencies: (k,) [Hz], ascending; growth: (k,) [1/s]; displacements:
    (k, n+1, 2) of the joints, complex, the largest of each 1."""

    frequencies: Array
    growth: Array
    displacements: NDArray[np.complex128]


def frozen_modes(model: ModuleType, t: float, y: Array, p: Array, count: int) -> FrozenModes:
    """Compute the oscillating motions of lowest frequency, up to ``count``, by the eigenvalues of
    the module's Jacobian J in y' = J y, at time t, the positions of y and rates of zero. Forces
    that drive the rod away from there are left out."""
    half = (len(y) - len(getattr(model, "STATES", ()))) // 2
    at = y.copy()
    at[half : 2 * half] = 0.0
    s, vectors = np.linalg.eig(np.asarray(model.jac(t, at, p)))
    moving = np.flatnonzero(s.imag > STILL * np.abs(s).max(initial=0.0))
    kept = moving[np.argsort(s[moving].imag, kind="stable")][:count]
    q = vectors[:half, kept].T
    q = q / np.abs(q).max(axis=1, keepdims=True)
    moved, largest = joint_displacements(model, at, p, q)
    return FrozenModes(s[kept].imag / (2 * np.pi), s[kept].real, moved / largest[:, None, None])


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
