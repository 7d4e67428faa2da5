"""What came out of many runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.crossings import Crossed
from rodgen.integrate.endings import FAILED
from rodgen.integrate.stepper import Array
from rodgen.shown import Told


@dataclass(repr=False)
class Ensemble(Told):
    """What is kept of many runs, one after the other in arrays of their number.

    values: reductions by their texts, each (rods,), not-a-number for runs that failed; t: times
    [s] that the runs reached, (rods,); y: states there, (rods, states), in the order of the
    module's STATE; work: work done by each load without potential until then [J], by term, each
    (rods,); status: "finished" or "failed", (rods,); message: what there is to say of those that
    failed or that an event has ended, by rod; steps, rejected, rhs: of each, (rods,), -1 where the
    method does not tell; energy_error: largest error of the energy balance at the samples [J],
    (rods,), not-a-number for runs that failed; crossed: of what was watched; traces: of what was
    traced at the times of the samples [s], (rods, traced, samples + 1), see `trace`.

    Examples
    --------
    >>> import numpy as np, rodgen
    >>> scene = rodgen.Scene.example("missile")
    >>> p = scene.parameters | {"mass": np.linspace(19, 21, 3)}
    >>> model = rodgen.build(scene)
    >>> y0 = scene.initial_state()
    >>> found = rodgen.simulate_many(model, p, y0, keep=["max(tip_y)"], span=[0, 1])
    >>> found.status.tolist()
    ['finished', 'finished', 'finished']
    """

    values: dict[str, Array]
    t: Array
    y: Array
    work: dict[str, Array]
    status: NDArray[np.str_]
    message: dict[int, str]
    steps: NDArray[np.int64]
    rejected: NDArray[np.int64]
    rhs: NDArray[np.int64]
    energy_error: Array
    crossed: tuple[Crossed, ...] = ()
    traces: Array | None = None
    samples: Array | None = None

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, text: str) -> Array:
        """A reduction by its text."""
        return self.values[text]

    def trace(self, rod: int, number: int) -> tuple[Array, Array]:
        """Times [s] and values of what was traced of a rod, by its number among that."""
        assert self.samples is not None
        assert self.traces is not None
        end = self.t[rod]
        t = self.samples[self.samples <= end]
        if self.message.get(rod) and (not len(t) or t[-1] < end):  # where an event has ended it
            t = np.append(t, end)
        return t, self.traces[rod, number, : len(t)]

    def __repr__(self) -> str:
        kept = f"; {', '.join(self.values)}" if self.values else ""
        failed = int((self.status == FAILED).sum())
        return f"<Ensemble of {len(self)} runs, {failed} failed{kept}>"
