"""Windows of an open-ended run, in which loads are looked at one after the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rodgen.errors import InputError
from rodgen.integrate.stepper import StepError
from rodgen.integrate.stretches import UNBOUNDED, Pulse, Stretches
from rodgen.system import System


class Windows:
    """Stretches of an open-ended run: windows as long as the scene's span, one after the other.

    Loads are looked at in one window at a time. origin: where the first begins [s]; span: of the
    present window; stretches: in it.
    """

    def __init__(self, system: System, origin: float):
        start, end = system.settings.span
        self._course, self._fixed = system.time_laws, system.settings.has_fixed_step
        self._origin, self.length = origin, end - start
        # To the bit, lest the first window end beside the span.
        self._first = end if origin == start else origin + self.length
        self._number = -1
        self._move_to(0)

    def next_end(self, t: float) -> float:
        """End of the stretch that begins at a time [s]. Raises StepError at a pole."""
        least = t + 4 * float(np.spacing(abs(t)))  # closer, and loads would be asked beyond it
        number = max(0, int((least - self._origin) // self.length))
        # The division may be a rounding beside the borders.
        number -= number > 0 and self._window_start(number) > least
        number += self._window_start(number + 1) <= least
        if number != self._number:
            try:
                self._move_to(number)
            except InputError as error:  # of masses that jump too often there
                raise StepError(str(error)) from None
        for end in self.stretches.ends:
            if end > least:
                return end
        raise StepError(UNBOUNDED)

    def _window_start(self, number: int) -> float:
        """Start of a window [s], by its number."""
        return self._first + (number - 1) * self.length if number else self._origin

    def _move_to(self, number: int) -> None:
        """Move to the window of this number, and find its stretches."""
        self._number = number
        at, over = self.span = self._window_start(number), self._window_start(number + 1)
        if not (self._course.loads or self._course.expressions):
            self.stretches = Stretches([over])
            return
        across: list[Pulse] = []
        if number and not self._fixed:  # a rest may reach across the border
            half = self.length / 2
            across = replace(self._course, start=at - half, end=at + half).pulses()
        course = replace(self._course, start=at, end=over)
        self.stretches = Stretches.of(course, self._fixed, across)
