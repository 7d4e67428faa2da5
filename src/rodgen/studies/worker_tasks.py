"""Tasks on the workers of a study (blocks, pieces, the timing of points), and their context."""

from __future__ import annotations

import os
import platform
import signal
import sys
import warnings
from functools import cached_property
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import distributed
from distributed import WorkerPlugin

from rodgen.errors import InputError
from rodgen.loading import cache
from rodgen.studies import task
from rodgen.studies.local import compute_in_process
from rodgen.studies.specification import Texts
from rodgen.studies.store import StudyStore, identity

if TYPE_CHECKING:
    from rodgen.studies.study import Study

# Keeps Python from importing from the folder in which it is started; the value says who set it.
SAFE_PATH, SAFE = "PYTHONSAFEPATH", "rodgen"

_unregister = resource_tracker.unregister


class StudyContext(WorkerPlugin):  # type: ignore[misc]  # Dask has no types
    """Plugin that gives every worker, also those that come later, the study, the path of its store
    and the texts of modules that were generated already, so that a worker compiles once and derives
    nothing."""

    def __init__(self, store: StudyStore, texts: Texts, own: bool):
        self.study, self.path, self.token = store.study, store.path, store.token
        self.texts, self.own, self.identity = texts, own, versions()
        self.name = f"rodgen-{uuid4().hex}"  # another client may work at the same store

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k != "store"}

    def setup(self, worker: Any) -> None:
        """Put the texts into the cache of the worker's machine."""
        if self.own:
            # Of Ctrl-C in a terminal the client hears, and ends its workers.
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            unset_safe_path()
        for entry, text in self.texts.items():
            if cache.read_text(*entry) is None:
                cache.store_text(text, *entry)

    @cached_property
    def store(self) -> StudyStore:
        """The store, opened once in a process. Raises InputError where it is not the client's."""
        check_worker("this", versions(), self.identity)
        store, why = None, " there is another store"
        try:
            store = StudyStore.of(self.path, self.study)
        except InputError as error:
            why = f": {error.allowed}"
        # Not in the handler: with what it came from, it reaches the client as a bare Exception.
        if store is None or store.token != self.token:
            allowed = f"a folder that all workers see (on {platform.node()}{why})"
            raise InputError("out", str(self.path), allowed)
        return store


def unset_safe_path() -> None:
    """Unset PYTHONSAFEPATH for programs started from now on, unless the user has set it."""
    if os.environ.get(SAFE_PATH) == SAFE:
        del os.environ[SAFE_PATH]


def versions() -> dict[str, str]:
    """Return the versions that have to be equal on all workers."""
    return {"Python": f"{sys.version_info.major}.{sys.version_info.minor}", **identity()}


def check_worker(name: str, found: Any, wanted: dict[str, str]) -> None:
    """Raise InputError for a worker of another version, which would give other results."""
    if found == wanted:
        return
    if isinstance(found, dict):
        other = next(key for key in wanted if found.get(key) != wanted[key])
        what = f"{other} {found.get(other)}, not {wanted[other]}"
    else:
        what = f"{type(found).__name__}: {found}"
    raise InputError("--scheduler", name, f"of workers with this version of rodgen ({what})")


def compute_work(name: str, work: task.Work, apart: bool) -> Any:
    """Compute a block or points on a worker; apart: in a process that may die without it."""
    store, compute = _context(name).store, compute_in_process if apart else task.compute_points
    return task.compute_work(store, work, compute)


def _context(name: str) -> StudyContext:
    context = distributed.get_worker().plugins[name]
    assert isinstance(context, StudyContext)
    return context


def time_point(study: Study) -> tuple[float, Texts]:
    """Measure the time of a point [s]. Returns it with the generated texts that were used, by their
    entries in the cache."""
    with cache.record_texts() as texts:
        seconds = task.time_point(study)
    return seconds, texts


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
