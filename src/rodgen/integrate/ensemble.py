"""Result of many runs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.integrate.reductions import CrossingResults
from rodgen.integrate.stepper import FINISHED
from rodgen.result import Result, Row, omit_from_tables


@dataclass(repr=False)
class Ensemble(Result):
    """Results of many runs, in arrays over the rods.

    values: reductions by their texts, each (rods,) in SI units, not-a-number for runs that failed;
    t: times that the runs reached [s], (rods,); y: states at these times, (rods, states), in SI
    units and the order of the module's STATE; work: of each load without potential until then [J],
    by term, each (rods,); status: "finished", "failed", "chatters" or "bounces", (rods,); message:
    why a run failed or which event ended it, by rod; nsteps, rejected, nfev: steps, rejected steps
    and evaluations of the rates, (rods,), -1 if the method does not count them; energy_error:
    largest error of the energy balance at the samples [J], (rods,), not-a-number for runs that
    failed; crossed: crossings of watched quantities; traces: values of traced quantities in SI
    units, (rods, traced, samples + 1), see `trace`; samples: their times [s].

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
    crossed: tuple[CrossingResults, ...] = ()
    traces: Array | None = None
    samples: Array | None = None

    ROWS = (
        Row("runs", "runs", of=len),
        Row("n_failures", "failed runs"),
        Row("kept", "quantity", along="kept", of=lambda found: [*found.finished_values]),
        Row("least", "least", format=".6g", along="kept"),
        Row("largest", "largest", format=".6g", along="kept"),
        Row("t", "times that the runs reached", "s", text=omit_from_tables),
        Row("values", "values", text=omit_from_tables),
        Row("status", "status", text=omit_from_tables),
        Row("message", "messages", text=omit_from_tables),
        Row("energy_error", "errors of the energy balance", "J", text=omit_from_tables),
        Row("work", "work of {} until the end", "J", text=omit_from_tables),
        Row("nsteps", "steps", text=omit_from_tables),
        Row("rejected", "rejected steps", text=omit_from_tables),
        Row("nfev", "evaluations of the rates", text=omit_from_tables),
        Row("y", "states at the end", text=omit_from_tables),
    )

    @property
    def n_failures(self) -> int:
        """Number of runs that did not finish."""
        return int((self.status != FINISHED).sum())

    @property
    def finished_values(self) -> dict[str, Array]:
        """Times and reductions of the runs that finished, by text, in SI units."""
        fine = self.status == FINISHED
        return {name: values[fine] for name, values in {"t": self.t, **self.values}.items()}

    @property
    def least(self) -> list[float]:
        """Least of the times and each reduction, in SI units, not-a-number if no run finished."""
        return self._each(np.min)

    @property
    def largest(self) -> list[float]:
        """Largest of the times and each reduction, in SI units, not-a-number if no run finished."""
        return self._each(np.max)

    def _each(self, function: Callable[[Array], Any]) -> list[float]:
        found = self.finished_values.values()
        return [float(function(one)) if len(one) else math.nan for one in found]

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, text: str) -> Array:
        """A reduction by its text."""
        return self.values[text]

    def trace(self, rod: int, number: int) -> tuple[Array, Array]:
        """Times [s] and values, in SI units, of a traced quantity in one run.

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
        return f"<Ensemble of {len(self)} runs, {self.n_failures} failed{kept}>"
