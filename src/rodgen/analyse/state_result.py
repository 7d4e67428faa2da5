"""Results about a steady state, whose loads are those of one time."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property

from rodgen.analyse.steady_rod import AtOneTime
from rodgen.result import Result, Row, hidden
from rodgen.system.instant import describe_instant, inactive_loads

TIME = (
    Row("t", "time", "s", text=lambda found: found._instant),
    Row("inactive_loads", "loads that are zero then", text=hidden),
)


class StateResult(AtOneTime, Result):
    """A result about a steady state. system: the rod, with the loads of one time."""

    @property
    def _scaled(self) -> Collection[str]:
        """Parameters whose size is not used."""
        return ()

    @cached_property
    def inactive_loads(self) -> tuple[str, ...]:
        """Keys of the loads that are zero at t, but not at another time of the span."""
        return inactive_loads(self.system.source, self.t, self._scaled)

    @property
    def _instant(self) -> str:
        return describe_instant(self.system.source, self.t, self._scaled)
