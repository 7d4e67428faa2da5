"""Results about a steady state, whose loads are those of one time."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property

from rodgen.analyse.steady_rod import HasInstant
from rodgen.result import Result, Row, omit_from_tables
from rodgen.system.freezing import describe_instant, inactive_loads

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
        return inactive_loads(self.system.source, self.t, self._scaled_parameters)

    @property
    def _instant_text(self) -> str:
        return describe_instant(self.system.source, self.t, self._scaled_parameters)
