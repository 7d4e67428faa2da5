"""Python's tracker of semaphores, a process that a system short of memory may kill."""

from __future__ import annotations

import warnings
from multiprocessing import resource_tracker

_unregister = resource_tracker.unregister


def outlive_tracker() -> None:
    """Let a study outlive the tracker of its semaphores without messages: each semaphore is
    registered with the tracker that Python starts instead before it is unregistered there, else
    that one would print that it does not know it."""
    vars(resource_tracker)["unregister"] = _forget


def _forget(name: str, kind: str) -> None:
    """Unregister a resource, whichever tracker runs."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "resource_tracker: process died", UserWarning)
        resource_tracker.register(name, kind)
    _unregister(name, kind)
