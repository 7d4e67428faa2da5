"""Critical force of the present system of a run, computed in the worker process."""

from __future__ import annotations

import time
from collections.abc import Callable

from rodgen.model.terms import TERMS
from rodgen.system import System
from rodgen_live.panel_rows import CriticalForce
from rodgen_live.run.scene_edits import fields_of
from rodgen_live.run.worker_process import ASIDE, Answer, PendingRequest

MOST_LINKS = 200  # beyond, it takes seconds
PATIENCE = 0.4  # seconds without another change, before it is computed
COMPUTING = "computing"


class CriticalSearch:
    """Critical force of a run's system. found: for the system looked at last; mark: the key of the
    number that is the size of that force, and the value of it that makes the force critical, while
    another one is computed that of the system before. do: has work done in the thread that all else
    is called in; done: called there when the force has come."""

    def __init__(
        self,
        do: Callable[[Callable[[], None]], object],
        done: Callable[[], object],
        clock: Callable[[], float] = time.perf_counter,
    ):
        self._do, self._done, self._clock = do, done, clock
        self._system: System | None = None  # whose force is to be computed, or is
        self._errand: PendingRequest | None = None
        self._since = 0.0
        self.found = CriticalForce()
        self.mark: tuple[str, float] | None = None

    def restart(self, system: System) -> None:
        """Schedule the computation for another system, if that has a critical force."""
        self.cancel()
        following = [TERMS[name] for name in system.load_terms if TERMS[name].follows]
        if not any(term.has_size for term in following[:1]):
            self.found, self.mark = CriticalForce(), None
        elif system.structure.n_links > MOST_LINKS:
            refusal = f"not computed: more than {MOST_LINKS} links"
            self.found, self.mark = CriticalForce(refusal), None
        else:
            self.found = CriticalForce(COMPUTING)
            self._system, self._since = system, self._clock()

    def tick(self) -> None:
        """Request the computation once the system has stayed what it is for a while."""
        system = self._system
        if system is None or self._errand is not None:
            return
        if self._clock() - self._since >= PATIENCE:
            self._errand = ASIDE.submit(
                "critical",
                system.scene,
                lambda answer: self._do(lambda: self._receive(system, answer)),
            )

    def cancel(self) -> None:
        """Cancel the computation, whether requested or only scheduled."""
        self._system = None
        if self._errand is not None:
            self._errand.cancel()
            self._errand = None

    def _receive(self, system: System, answer: Answer) -> None:
        if system is self._system and (answer.refused or answer.value is not None):
            self.found = CriticalForce(**(answer.value or {"value": answer.refused}))
            self.mark = None if answer.refused else critical_number(system, answer.value["value"])
            self._done()


def critical_number(system: System, critical: float) -> tuple[str, float] | None:
    """Key and critical value of the number that is the size of the first follower force; of a force
    that changes with time, by its size at the end of the span."""
    scene = system.scene
    (row,) = TERMS[scene.loads.follower_loads[0]].size_parameters
    if row.name not in scene.expressions:
        return scene.key_of(row.name), critical
    size = next((one for one in fields_of(scene) if one.of.name == row.name and one.value), None)
    force = system.at(t=system.settings.span[1]).scene.parameters[row.name]
    return (size.key, critical * (size.value or 0.0) / force) if size and force else None
