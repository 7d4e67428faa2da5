"""A scene at the edge of what can be computed, and how it should move."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rodgen

Array = NDArray[np.float64]
Tables = dict[str, Any]

SAMPLES = 8  # intervals between the states that are compared
TURN = 2 * np.pi
EPS = float(np.finfo(float).eps)
KINDS = ("angles", "rates", "places", "speeds")
ANGLES, RATES, PLACES, SPEEDS = KINDS


@dataclass(frozen=True)
class Truth:
    """States (samples, states) by a second route.

    error: its own estimate of its error, and condition: by how much errors of the start grow, both
    relative to the motion; by: the route; positions: of the rates it knows nothing.
    """

    y: Array
    by: str
    error: float = 0.0
    condition: float = 1.0
    positions: bool = False


@dataclass(frozen=True)
class Extreme:
    """A case of the matrix.

    truth: from the scene to its states; who: the contestants, all if not given; quick: it is in the
    short report, there with few of them if those are given.
    """

    group: str
    name: str
    tables: Tables
    truth: Callable[[rodgen.Scene], Truth]
    who: Sequence[str] = ()
    quick: bool = False
    few: Sequence[str] = ()

    @cached_property
    def scene(self) -> rodgen.Scene:
        """Checked, with eight samples."""
        first, last = self.tables["integrate"]["span"]
        every = {"output_every": (last - first) / SAMPLES}
        tables = {**self.tables, "integrate": {**self.tables["integrate"], **every}}
        return rodgen.Scene.from_dict(tables)


@dataclass(frozen=True)
class Measure:
    """How far states are apart, kind by kind of state, relative to the motion's size."""

    scene: rodgen.Scene
    truth: Array
    sizes: dict[str, float] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "sizes", self._sizes())

    def parts(self, y: Array) -> dict[str, Array]:
        """States of each kind, (samples, entries), entries none where a rod is held."""
        q, u = np.split(y, 2, axis=-1)
        base = 2 * self.scene.hold.translates
        return dict(
            zip(KINDS, (q[..., base:], u[..., base:], q[..., :base], u[..., :base]), strict=True)
        )

    def _sizes(self) -> dict[str, float]:
        parts = self.parts(self.truth)
        first, last = self.scene.integrate.span
        length = self.scene.rod.length
        angles = _largest(parts[ANGLES] - parts[ANGLES][:1]) or 1.0
        rates = max(_largest(parts[RATES]), angles / (last - first))
        places = max(_largest(parts[PLACES] - parts[PLACES][:1]), length * min(1.0, angles))
        speeds = max(_largest(parts[SPEEDS]), length * rates)
        return dict(zip(KINDS, (angles, rates, places, speeds), strict=True))

    def errors(self, y: Array) -> dict[str, float]:
        """Largest error of each kind over its size."""
        theirs, ours = self.parts(self.truth), self.parts(y)
        return {kind: _largest(ours[kind] - theirs[kind]) / self.sizes[kind] for kind in KINDS}

    def tolerated(self) -> dict[str, float]:
        """What the tolerances allow in each kind in a step, over its size; of turned and shifted
        rods the turns and the shift do not count."""
        settings, parts = self.scene.integrate, self.parts(self.truth)
        most = {ANGLES: TURN, PLACES: self.sizes[PLACES], RATES: np.inf, SPEEDS: np.inf}
        return self._carried(
            {
                kind: settings.rtol * min(_largest(parts[kind]), most[kind]) + settings.atol
                for kind in KINDS
            }
        )

    def rounding(self) -> dict[str, float]:
        """What rounding of the states makes in each kind in a step, over its size."""
        parts = self.parts(self.truth)
        step = {kind: 4 * EPS * _largest(parts[kind]) for kind in KINDS}
        step[RATES] += step[SPEEDS] / self.scene.rod.length  # as the drag rounds with the speed
        return self._carried(step)

    def _carried(self, step: dict[str, float]) -> dict[str, float]:
        """Errors of rates and speeds make errors of angles and places."""
        first, last = self.scene.integrate.span
        step[ANGLES] += (last - first) * step[RATES]
        step[PLACES] += (last - first) * step[SPEEDS]
        return {kind: step[kind] / self.sizes[kind] for kind in KINDS}


def _largest(x: Array) -> float:
    return float(np.abs(x).max(initial=0.0))
