"""Results about a steady state, whose loads are those of one time."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property

import numpy as np

from rodgen.analyse.steady_rod import HasInstant
from rodgen.arrays import Array
from rodgen.result import Result, Row, omit_from_tables
from rodgen.scene import Scene

TIMES = 1001  # of the span, beside what lies between break points
TIME = (
    Row("t", "time", "s", text=lambda found: found._instant_text),
    Row("inactive_loads", "loads that are zero then", text=omit_from_tables),
)


class StateResult(HasInstant, Result):
    """Base of results about a steady state. system: the rod, with the loads of one time."""

    @property
    def _scaled_parameters(self) -> Collection[str]:
        """Parameters of the scaled load, whose size in the scene is not used."""
        return ()

    @cached_property
    def inactive_loads(self) -> tuple[str, ...]:
        """Keys of the loads that are zero at t, but not at another time of the span."""
        scene = self.system.source
        times = _sample_times(scene)
        return tuple(
            scene.key_of(name)
            for name, e in scene.time_laws.items()
            if name not in self._scaled_parameters
            and float(e(self.t)) == 0
            and np.any(np.asarray(e(times)) != 0)
        )

    @property
    def _instant_text(self) -> str:
        scene, quiet = self.system.source, self.inactive_loads
        masses = " and masses" * bool(scene.distribution.changing_masses)
        words = f"loads{masses} as at t = {self.t:g} s"
        if self.t == scene.integrate.span[0]:
            words += ", the start of the span"
        if not quiet:
            return words
        verb = "is" if len(quiet) == 1 else "are"
        return f"{words}, where {' and '.join(quiet)} {verb} 0, but not at all times"


def _sample_times(scene: Scene) -> Array:
    """Times of the span [s], dense enough that no load acts between two of them alone."""
    start, end = scene.integrate.span
    ends = np.array([start, *scene.breaks(), end])
    peaks = [peak for _, peak, _ in scene.time_functions.pulses()]
    return np.concatenate((np.linspace(start, end, TIMES), (ends[1:] + ends[:-1]) / 2, peaks))
