"""What came out of many runs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.crossings import Crossed
from rodgen.integrate.endings import FINISHED
from rodgen.result import Result, Row, hidden


@dataclass(repr=False)
class Ensemble(Result):
    """Results of many runs, in arrays over the rods.

    values: reductions by their texts, each (rods,) in SI units, not-a-number for runs that failed;
    t: times that the runs reached [s], (rods,); y: states at these times, (rods, states), in SI
    units and the order of the module's STATE; work: of each load without potential until then [J],
    by term, each (rods,); status: "finished", "failed" or "chatters", (rods,); message: why a run
    failed or which event ended it, by rod; nsteps, rejected, nfev: steps, rejected steps and
    evaluations of the rates, (rods,), -1 if the method does not count them; energy_error: largest
    error of the energy balance at the samples [J], (rods,), not-a-number for runs that failed;
    crossed: crossings of watched quantities; traces: values of traced quantities in SI units,
    (rods, traced, samples + 1), see `trace`; samples: their times [s].

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
    nsteps: NDArray[np.int64]
    rejected: NDArray[np.int64]
    nfev: NDArray[np.int64]
    energy_error: Array
    crossed: tuple[Crossed, ...] = ()
    traces: Array | None = None
    samples: Array | None = None

    ROWS = (
        Row("runs", "runs", of=len),
        Row("failed", "failed"),
        Row("kept", "quantity", along="kept", of=lambda found: [*found.reduced]),
        Row("least", "least", format=".6g", along="kept"),
        Row("largest", "largest", format=".6g", along="kept"),
        Row("t", "times that the runs reached", "s", text=hidden),
        Row("values", "values", text=hidden),
        Row("status", "status", text=hidden),
        Row("message", "messages", text=hidden),
        Row("energy_error", "errors of the energy balance", "J", text=hidden),
        Row("work", "work of {} until the end", "J", text=hidden),
        Row("nsteps", "steps", text=hidden),
        Row("rejected", "rejected steps", text=hidden),
        Row("nfev", "evaluations of the rates", text=hidden),
        Row("y", "states at the end", text=hidden),
    )

    @property
    def failed(self) -> int:
        """How many runs did not finish."""
        return int((self.status != FINISHED).sum())

    @property
    def reduced(self) -> dict[str, Array]:
        """Times and reductions of the runs that finished, by text, in SI units."""
        fine = self.status == FINISHED
        return {name: values[fine] for name, values in {"t": self.t, **self.values}.items()}

    @property
    def least(self) -> list[float]:
        """The least of each, in SI units, not-a-number where no run finished."""
        return [float(np.min(one)) if len(one) else math.nan for one in self.reduced.values()]

    @property
    def largest(self) -> list[float]:
        """The largest of each, in SI units."""
        return [float(np.max(one)) if len(one) else math.nan for one in self.reduced.values()]

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, text: str) -> Array:
        """A reduction by its text."""
        return self.values[text]

    def trace(self, rod: int, number: int) -> tuple[Array, Array]:
        """Times [s] and values, in SI units, of a quantity that was traced.

        rod: its number; number: that of the quantity among those traced.
        """
        assert self.samples is not None
        assert self.traces is not None
        end = self.t[rod]
        t = self.samples[self.samples <= end]
        if self.message.get(rod) and (not len(t) or t[-1] < end):  # where an event has ended it
            t = np.append(t, end)
        return t, self.traces[rod, number, : len(t)]

    def __repr__(self) -> str:
        kept = f"; {', '.join(self.values)}" if self.values else ""
        return f"<Ensemble of {len(self)} runs, {self.failed} failed{kept}>"
