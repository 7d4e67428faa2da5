"""What runs on the workers of a study: blocks, pieces and the timing of points, and what all of
these need there."""

from __future__ import annotations

import os
import platform
import signal
import sys
from functools import cached_property
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import distributed
from distributed import WorkerPlugin

from rodgen.errors import InputError
from rodgen.loading import cache
from rodgen.studies import task
from rodgen.studies.store import Store, identity

if TYPE_CHECKING:
    from rodgen.studies.study import Study

# Keeps Python from importing from the folder in which it is started; the value says who set it.
SAFE_PATH, SAFE = "PYTHONSAFEPATH", "rodgen"
Texts = dict[tuple[str, ...], str]
Indices = list[int]


class Context(WorkerPlugin):  # type: ignore[misc]  # Dask has no types
    """What all blocks of a study need, on every worker, also those that come later: the study, the
    place of its store, and the texts of modules that were generated already, so that a worker
    compiles once and derives nothing."""

    def __init__(self, store: Store, texts: Texts, own: bool):
        self.study, self.path, self.token = store.study, store.path, store.token
        self.texts, self.own, self.identity = texts, own, of_client()
        self.name = f"rodgen-{uuid4().hex}"  # another client may work at the same store

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k != "store"}

    def setup(self, worker: Any) -> None:
        """Put the texts into the cache of the worker's machine."""
        if self.own:
            # Of Ctrl-C in a terminal the client hears, and ends its workers.
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            end_safe_path()
        for entry, text in self.texts.items():
            if cache.read_text(*entry) is None:
                cache.store_text(text, *entry)

    @cached_property
    def store(self) -> Store:
        """The store, once in a process. Raises InputError for another than that of the client."""
        check_worker("this", who(), self.identity)
        where = f"on {platform.node()}"
        try:
            store = Store.of(self.path, self.study)
        except InputError as error:
            allowed = f"a folder that all workers see ({where}: {error.allowed})"
            raise InputError("out", str(self.path), allowed) from None
        if store.token != self.token:
            allowed = f"a folder that all workers see ({where} there is another store)"
            raise InputError("out", str(self.path), allowed)
        return store


def end_safe_path() -> None:
    """Let programs that are started from now on import as is usual, unless the user has it else."""
    if os.environ.get(SAFE_PATH) == SAFE:
        del os.environ[SAFE_PATH]


def who() -> dict[str, str]:
    """What has to be equal on all workers."""
    return {**identity(), "Python": f"{sys.version_info.major}.{sys.version_info.minor}"}


def of_client() -> dict[str, str]:
    """What this client has of that."""
    return who()


def check_worker(name: str, found: Any, wanted: dict[str, str]) -> None:
    """Raise InputError for a worker that would give other results."""
    if found == wanted:
        return
    if isinstance(found, dict):
        other = next(key for key in wanted if found.get(key) != wanted[key])
        what = f"{other} {found.get(other)}, not {wanted[other]}"
    else:
        what = f"{type(found).__name__}: {found}"
    raise InputError("--scheduler", name, f"of workers with this version of rodgen ({what})")


def compute(name: str, block: int) -> task.Done:
    """Compute a block on a worker."""
    return task.compute(_context(name).store, block)


def compute_alone(name: str, block: int) -> task.Done:
    """Compute a block whose worker was killed, in a process that may die without the worker."""
    from rodgen.studies.alone import apart

    store = _context(name).store
    indices = store.layout.indices(block)
    if store.is_done(block):
        return task.Done(block, len(indices), 0)
    return task.keep(store, block, apart(store.study, indices))


def piece(name: str, indices: Indices) -> tuple[Indices, task.Arrays]:
    """Compute points on a worker that are no block."""
    return indices, task.computed(_context(name).store.study, indices)


def piece_alone(name: str, indices: Indices) -> tuple[Indices, task.Arrays]:
    """Compute points whose worker was killed, in a process that may die without the worker."""
    from rodgen.studies.alone import apart

    return indices, apart(_context(name).store.study, indices)


def _context(name: str) -> Context:
    context = distributed.get_worker().plugins[name]
    assert isinstance(context, Context)
    return context


def timed(study: Study) -> tuple[float, Texts]:
    """Time that a point takes [s], and the generated texts that it took, by their entries in the
    cache."""
    with cache.noted() as texts:
        seconds = task.timed(study)
    return seconds, texts
