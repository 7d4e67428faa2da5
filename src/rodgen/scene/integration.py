"""How a scene is integrated: the table [integrate], its limits, and the times of samples."""

from __future__ import annotations

import math
from typing import Annotated, Self, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from rodgen.model.methods import EITHER, FIXED_STEP, METHODS
from rodgen.scene import structure as st
from rodgen.scene.errors import SceneError
from rodgen.scene.tables import Finite, Pair, Positive, Table

AUTO = "auto"
MOST_SAMPLES = 10**6
MOST_STEPS = 10**9
MOST_ADAPTIVE = 10**7
LEAST_RTOL = 2.3e-14  # a hundred times the rounding of a double, below which SciPy clips


class Settings(TypedDict, total=False):
    """Values for [integrate] as keyword arguments, those of a scene where they are None."""

    method: str | None
    span: ArrayLike | None
    step: float | None
    rtol: float | None
    atol: float | None
    output_every: float | None
    t_eval: ArrayLike | None
    max_steps: int | None


class Integrate(Table):
    """How the scene is integrated; t_eval: times of the samples [s], ascending, instead of one at
    the start and every output_every; max_steps: after so many, a run is stopped (if not given, ten
    million of an adaptive method)."""

    method: str = AUTO
    span: Pair = [0.0, 10.0]
    step: Positive | None = None
    rtol: Positive = 1e-8
    atol: Positive = 1e-10
    output_every: Positive = 0.01
    t_eval: list[Finite] | None = None
    max_steps: Annotated[int, Field(gt=0)] | None = None

    @property
    def budget(self) -> int:
        """Steps after which a run is stopped."""
        return self.max_steps or (MOST_STEPS if self.fixed else MOST_ADAPTIVE)

    @property
    def fixed(self) -> bool:
        """Whether steps are all equal: the method has a fixed step, or may have one and is given
        it."""
        return self.method in FIXED_STEP or (self.method in EITHER and self.step is not None)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        st.choose("integrate.method", self.method, (AUTO, *METHODS))
        start, end = self.span
        if not start < end:
            raise SceneError("integrate.span", self.span, "[start, end] with start < end")
        if self.method in FIXED_STEP and self.step is None:
            allowed = f"given in seconds: method {self.method} has a fixed step"
            raise SceneError("integrate.step", None, allowed)
        if self.method in EITHER and self.fixed:
            self._equal_steps()
        if self.step is not None and (end - start) / self.step > MOST_STEPS:
            raise SceneError("integrate.step", self.step, f"at most {MOST_STEPS} steps in the span")
        if self.t_eval is not None:
            _check_times(self.t_eval, start, end)
        elif (end - start) / self.output_every > MOST_SAMPLES:
            allowed = f"at most {MOST_SAMPLES} samples in the span"
            raise SceneError("integrate.output_every", self.output_every, allowed)
        if not LEAST_RTOL <= self.rtol < 1:
            raise SceneError("integrate.rtol", self.rtol, f"from {LEAST_RTOL} to below 1")
        return self

    def _equal_steps(self) -> None:
        """Raise SceneError for a tolerance beside a step: one of them would count for nothing."""
        for name in ("rtol", "atol"):
            if getattr(self, name) != type(self).model_fields[name].default:
                why = f"absent beside integrate.step, with which {self.method} takes equal steps"
                raise SceneError(f"integrate.{name}", getattr(self, name), why)

    @property
    def samples(self) -> NDArray[np.float64]:
        """Output times: t_eval, or the start, every output_every, and the end."""
        if self.t_eval is not None:
            return np.array(self.t_eval, dtype=float)
        start, end = self.span
        count = math.floor((end - start) / self.output_every * (1 + 1e-12))
        times: NDArray[np.float64] = start + self.output_every * np.arange(count + 1.0)
        if len(times) == 1 or end - times[-1] > 1e-9 * self.output_every:
            times = np.append(times, end)
        times[-1] = end
        return times


def _check_times(times: list[float], start: float, end: float) -> None:
    """Raise SceneError unless there are times that ascend within a span [s]."""
    if not 0 < len(times) <= MOST_SAMPLES:
        raise SceneError("integrate.t_eval", times, f"1 to {MOST_SAMPLES} times")
    at = np.array(times)
    wrong = ~((at >= start) & (at <= end))
    wrong[1:] |= at[1:] <= at[:-1]
    if wrong.any():
        i = int(np.argmax(wrong))
        allowed = f"within the span, {start!r} to {end!r} s, and above the one before"
        raise SceneError(f"integrate.t_eval[{i}]", times[i], allowed)
