"""Workers of a study on a Dask cluster, which is started and closed here, or exists already.

Whoever may talk to Dask may have it run Python, and every user of a machine may talk to its ports:
processes that are started here talk to holders of a certificate alone, which is made for the run.

Dask's reports on tasks are not trusted: a block is done where the store has its mark. Dask has to
do little: to hold two tasks for every worker, and to say when one is over.
"""

from __future__ import annotations

import logging
import math
import os
import queue
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing import resource_tracker
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any, Self
from urllib.parse import urlsplit

import dask
import distributed
from distributed.comm import CommClosedError

from rodgen.errors import InputError, StudyError
from rodgen.native.library import DeferredInterrupt
from rodgen.studies import task
from rodgen.studies.specification import Texts
from rodgen.studies.store import StudyStore
from rodgen.studies.worker_tasks import (
    SAFE,
    SAFE_PATH,
    StudyContext,
    check_worker,
    compute_work,
    outlive_tracker,
    time_point,
    unset_safe_path,
    versions,
)

if TYPE_CHECKING:
    from rodgen.studies.study import Study

AHEAD = 2  # tasks of a worker: one that runs, one that waits
TICK = 1.0  # seconds between two looks at the cluster while nothing happens
EVERY = 5.0  # seconds between two questions for its workers
MENDED = 30.0  # seconds that a worker of our own may take to be there again
ANSWER = 20.0  # seconds in which a scheduler answers
PATIENCE = {True: 180.0, False: 600.0}  # seconds without any worker: of our own, of others
ENOUGH_DEATHS = 1  # of workers of a task, after which it runs apart from them
FETCHED = 60.0  # seconds in which a worker hands over what it found
ENDED = 2.0  # seconds in which a worker of our own ends, in the last fifth by force
BLOCK = 1.0  # seconds that count for a point which kills its worker
LONGEST = 300.0  # seconds that the timing of a point may take
STARTS = 6  # of workers of our own, and of telling them of a study
MOST_LOST = 10  # tasks of one block that may be lost
# What a cluster of our own is started with. A busy machine answers late; workers hold nothing that
# could be spilled, and one that is paused would never go on; tasks are not worth being stolen.
SETTINGS: dict[str, Any] = {
    "distributed.scheduler.allowed-failures": 0,
    "distributed.scheduler.work-stealing": False,
    "distributed.scheduler.worker-ttl": "1 hour",
    # No dashboard: it would ask nobody who they are.
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.deploy.lost-worker-timeout": "1 hour",
    "distributed.comm.timeouts.connect": "60s",
    "distributed.comm.timeouts.tcp": "120s",
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.profile.enabled": False,
    # What every process looks at by the clock: 42 ms of two workers and client a second become 12.
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "2s",
    "distributed.worker.memory.monitor-interval": "1s",
}
LOUD = ("distributed", "tornado", "asyncio")


@dataclass
class _Task:
    """One task: what it computes, its number, and how often its worker was killed."""

    what: Any
    number: int
    deaths: int = 0


@dataclass
class Cluster:
    """Context manager of workers that compute blocks. address: of an existing scheduler; without
    it, so many workers are started here."""

    workers: int
    address: str | None = None
    said: Callable[[str], None] = lambda _: None
    _stack: ExitStack = field(default_factory=ExitStack)
    _threads: int = 0
    _asked: float = 0.0
    _seen: float = 0.0  # when there was a worker last
    _whole: float = 0.0  # when all were there last
    _cluster: Any = None

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            stack.enter_context(_silence_dask())
            stack.enter_context(_hide_main_script())
            stack.enter_context(dask.config.set(SETTINGS))
            self.client = self._connect(stack)
            self._seen = self._whole = monotonic()
            self._count_workers(wait=True)
            while not self._threads:
                sleep(TICK)
                self._count_workers(wait=True)
            self._check_workers()
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *of: Any) -> bool | None:
        return self._stack.__exit__(*of)

    def _connect(self, stack: ExitStack) -> distributed.Client:
        """Connect a client to the scheduler at the address, or to a cluster started here; both are
        closed with the stack."""
        if self.address is not None:
            client = _connect_client(self.address)
            stack.callback(client.close, timeout=5)
            self.said(f"dashboard: {client.dashboard_link}")
            return client
        stack.enter_context(_private_folder())
        with DeferredInterrupt(), _block_signals():  # one that starts cannot be closed
            self._cluster = cluster = _start_cluster(self.workers)
            stack.callback(cluster.close, timeout=20)
        return stack.enter_context(distributed.Client(cluster, timeout="60s"))

    @property
    def count(self) -> int:
        """Number of blocks that are computed at once: by all workers to be started here, or by
        those that an existing scheduler has."""
        return self.workers if self._cluster is not None else self._threads

    def _check_workers(self) -> None:
        """Raise InputError for workers that would give other results."""
        if self._cluster is not None:
            return
        for worker, found in self.client.run(versions, on_error="return").items():
            if not isinstance(found, OSError):  # one that died meanwhile is no worker any more
                check_worker(worker, found, versions())

    def time_point(self, study: Study) -> tuple[float, Texts]:
        """Measure the time of a point [s] on a worker; returns it with generated texts. Points that
        kill their worker count as a block, those that take long as LONGEST, both without texts."""
        future = self.client.submit(time_point, study, pure=False)
        events: queue.SimpleQueue[Any] = queue.SimpleQueue()
        future.add_done_callback(events.put)
        try:
            if self._wait_next(events, LONGEST) is None:
                return LONGEST, {}
            found: tuple[float, Texts] = self._result_of(future) or (BLOCK, {})
            return found
        finally:
            future.release()

    def compute(
        self, store: StudyStore, wanted: Iterator[task.Work], texts: Texts
    ) -> Iterator[Any]:
        """Compute every block or list of points in a task, apart from its worker once one was
        killed; yields what `task.compute_work` returns, in whatever order tasks are done. Raises
        StudyError where the study cannot go on, InputError for workers that cannot be used."""
        context = StudyContext(store, texts, self._cluster is not None)
        self._register(context)
        events: queue.SimpleQueue[distributed.Future] = queue.SimpleQueue()
        works: dict[str, _Task] = {}
        again: list[_Task] = []
        new = (_Task(what, number) for number, what in enumerate(wanted))
        try:
            while True:
                while len(works) < AHEAD * self._threads:
                    work = again.pop() if again else next(new, None)
                    if work is None:
                        break
                    given = context.name, work.what, work.deaths >= ENOUGH_DEATHS
                    key = f"compute-{context.name}-{work.number}-{work.deaths}"
                    future = self.client.submit(compute_work, *given, key=key, pure=False)
                    works[future.key] = work
                    future.add_done_callback(events.put)
                if not works:
                    return
                future = self._wait_next(events)
                assert future is not None
                work = works.pop(future.key)
                found = self._result_of(future)
                if found is not None:
                    yield found
                else:
                    work.deaths += 1
                    if work.deaths > MOST_LOST:
                        why = f"its workers were lost {work.deaths} times"
                        raise StudyError(f"a block cannot be computed: {why}")
                    again.append(work)
                future.release()
        finally:
            if self.client.status == "running":
                with suppress(OSError, TimeoutError):  # a worker died meanwhile
                    self.client.unregister_worker_plugin(context.name)

    def _register(self, context: StudyContext) -> None:
        """Register the context with all workers, also those that come later; again where one dies
        meanwhile. Raises StudyError where they do not answer."""
        for turn in range(STARTS):
            try:
                self.client.register_plugin(context)
                return
            except (CommClosedError, TimeoutError):
                self._count_workers(wait=True)
                sleep(TICK * turn)
        raise StudyError("the workers do not answer")

    def _wait_next(
        self, events: queue.SimpleQueue[distributed.Future], seconds: float = math.inf
    ) -> distributed.Future | None:
        """Wait for the next task that is over; None where there is none for so many seconds. Raises
        StudyError where there will be none."""
        until = monotonic() + seconds
        while monotonic() < until:
            try:
                future = events.get(timeout=TICK)
            except queue.Empty:
                self._count_workers()
                continue
            if monotonic() - self._asked > EVERY:
                self._count_workers()
            return future
        return None

    def _result_of(self, future: distributed.Future) -> Any:
        """Return the result of a task, None where its worker was lost, even if the task was done.
        Raises what the task raised, and StudyError where the scheduler is gone."""
        try:
            return future.result(timeout=FETCHED)
        except (distributed.KilledWorker, CancelledError):
            pass
        except OSError as error:  # of the task, or of the way to it
            if future.status == "error":
                raise
            if not isinstance(error, CommClosedError | TimeoutError):
                raise
        if future.status == "cancelled":
            sleep(TICK)  # the client is about to find out why
        self._count_workers()
        return None

    def _count_workers(self, wait: bool = False) -> None:
        """Count the workers. Raises StudyError where the scheduler is gone, and where there have
        been none for long."""
        now = monotonic()
        if self.client.status != "running":
            raise StudyError("the scheduler does not answer any more")
        if now - self._asked < EVERY and not wait:
            return
        self._asked = now
        try:
            found = self.client.nthreads()
        except (OSError, TimeoutError, ValueError):
            raise StudyError("the scheduler does not answer any more") from None
        self._threads = sum(found.values()) or self._threads
        own = self._cluster is not None
        if found:
            self._seen = now
        elif now - self._seen > PATIENCE[own]:
            raise StudyError(f"there has been no worker for {PATIENCE[own]:.0f} s")
        if own:
            self._replace_workers(len(found), now)

    def _replace_workers(self, found: int, now: float) -> None:
        """Start workers in place of those started here that did not come back."""
        if found >= self.workers:
            self._whole = now
        elif now - self._whole > MENDED:
            self._whole = now
            there = {one["name"] for one in self._cluster.scheduler_info["workers"].values()}
            for name in [name for name in self._cluster.worker_spec if name not in there]:
                del self._cluster.worker_spec[name]
            self._cluster.scale(self.workers)


class _Nanny(distributed.Nanny):  # type: ignore[misc]  # of a package without types
    """Dask's nanny with a shorter wait for the end of its worker: blocks are kept whole, or not."""

    async def close(self, timeout: float = ENDED, reason: str = "nanny-close") -> Any:
        """End the worker, whatever it computes."""
        return await super().close(timeout, reason)


def _start_cluster(workers: int) -> distributed.LocalCluster:
    """Start a cluster of so many processes, again where one dies meanwhile. Raises StudyError where
    they do not start."""
    security = distributed.Security.temporary()
    for _ in range(STARTS):
        with suppress(RuntimeError, OSError, TimeoutError):
            return distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                worker_class=_Nanny,
                security=security,
                dashboard_address="127.0.0.1:0",
                scheduler_kwargs={"dashboard": False},
                silence_logs=logging.CRITICAL + 1,
            )
    raise StudyError(f"{workers} worker processes could not be started, {STARTS} times")


@contextmanager
def _block_signals() -> Iterator[None]:
    """Block signals of the terminal in processes that are started here: their client receives them,
    and ends the processes."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # Dask's thread begins here: all that it starts, now and later, inherit what is blocked.
    sent = {signal.SIGINT, signal.SIGHUP, signal.SIGQUIT}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, sent)
    outlive_tracker()
    resource_tracker.ensure_running()  # else with the first of them: it blocks SIGINT no longer
    signal.pthread_sigmask(signal.SIG_BLOCK, sent)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _private_folder() -> Iterator[None]:
    """Put the folders of workers, from which they import, into one that nobody else can write, and
    keep them from importing from the one in which they are started."""
    os.environ.setdefault(SAFE_PATH, SAFE)
    with (
        tempfile.TemporaryDirectory(prefix="rodgen-", ignore_cleanup_errors=True) as folder,
        dask.config.set({"temporary-directory": folder}),
    ):
        try:
            yield
        finally:
            unset_safe_path()


def _connect_client(address: str) -> distributed.Client:
    """Connect to an existing scheduler. Raises InputError where none answers."""
    field = "--scheduler"
    try:
        # A scheduler is told apart from any other server by its address alone.
        if not urlsplit(address if "://" in address else f"tcp://{address}").port:
            raise ValueError
    except ValueError:
        raise InputError(field, address, "an address such as tcp://host:8786") from None
    try:
        return distributed.Client(address, timeout=f"{ANSWER:.0f}s")
    except (OSError, TimeoutError, ValueError) as error:
        why = f"of a Dask scheduler that answers ({type(error).__name__})"
        raise InputError(field, address, f"the address {why}") from None
    except (TypeError, RuntimeError):  # certificates are missing, or this address asks for none
        why = "tls:// with Dask's settings of certificates, or tcp:// without them"
        raise InputError(field, address, f"an address with {why}") from None


@contextmanager
def _silence_dask() -> Iterator[None]:
    """Silence Dask's messages about workers that come and go."""
    # Dask gives levels and handlers of their own to some of the loggers below its own.
    names = [*LOUD, *logging.root.manager.loggerDict]
    loggers = [logging.getLogger(one) for one in names if one.partition(".")[0] in LOUD]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


@contextmanager
def _hide_main_script() -> Iterator[None]:
    """Keep workers from running the script that starts them, as Python's processes do otherwise: it
    then needs no `if __name__ == "__main__"`. Its functions reach them by value."""
    main = sys.modules["__main__"]
    kept = {name: main.__dict__.pop(name) for name in ("__file__",) if name in main.__dict__}
    spec, main.__spec__ = main.__spec__, None
    try:
        yield
    finally:
        main.__dict__.update(kept)
        main.__spec__ = spec
