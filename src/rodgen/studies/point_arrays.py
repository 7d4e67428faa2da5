"""Arrays of a block while its points are computed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.run_status import FAILED, FINISHED, TOO_LONG
from rodgen.studies.study_variable import MESSAGE, StudyVariable


class PointArrays:
    """Arrays of the variables of so many points, which hold fill values until a point is set."""

    def __init__(self, variables: Sequence[StudyVariable], count: int):
        self.arrays = {
            one.name: np.full((count, *one.shape), one.fill, dtype=one.dtype) for one in variables
        }
        self.arrays["seconds"][:] = 0.0

    def set_point(
        self,
        at: int,
        values: Mapping[str, Any],
        energy_error: float,
        message: str,
        doubts: int,
    ) -> None:
        """Store the results of a point."""
        for name, value in values.items():
            self.arrays[name][at] = value
        self.arrays["energy_error"][at], self.arrays["doubts"][at] = energy_error, doubts
        self.arrays["status"][at], self.arrays["message"][at] = FINISHED, message[:MESSAGE]

    def set_points(
        self,
        at: NDArray[np.intp],
        values: Mapping[str, NDArray[Any]],
        energy_error: NDArray[np.float64],
        status: NDArray[np.str_],
        messages: Mapping[int, str],
        doubts: NDArray[np.intp],
    ) -> None:
        """Store the results of points computed together; messages: by their position among them."""
        whole = status == FINISHED
        for name, value in values.items():
            self.arrays[name][at[whole]] = value[whole]
        self.arrays["energy_error"][at[whole]] = energy_error[whole]
        self.arrays["doubts"][at[whole]] = doubts[whole]
        self.arrays["status"][at] = status
        for place, message in messages.items():
            self.arrays["message"][at[place]] = message[:MESSAGE]

    def time_out(self, at: int, seconds: float | None) -> None:
        """Record that a point took longer than so many seconds."""
        self.arrays["status"][at] = TOO_LONG
        self.arrays["message"][at] = f"took longer than {seconds:g} s"

    def fail(self, at: int, message: str, status: str = FAILED) -> None:
        """Record that a point failed, and why."""
        self.arrays["status"][at], self.arrays["message"][at] = status, message[:MESSAGE]
