"""Workers of a study: a Dask cluster of processes that is started and closed, or one that is there.

Whoever may talk to Dask may have it run Python, and every user of a machine may talk to its ports:
processes that are started here talk to holders of a certificate alone, which is made for the run.

What Dask reports of tasks is not believed: a block is done where the store has its mark. What Dask
is asked for is small: to hold two tasks for every worker, and to say when one is over.
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
from rodgen.studies.store import Store
from rodgen.studies.tracker import outlive_tracker
from rodgen.studies.worker import (
    SAFE,
    SAFE_PATH,
    Context,
    Indices,
    Texts,
    check_worker,
    compute,
    compute_alone,
    end_safe_path,
    of_client,
    piece,
    piece_alone,
    timed,
    who,
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
BLOCK = 1.0  # seconds
LONGEST = 300.0  # seconds after which nobody waits to know how long a point takes
STARTS = 6  # of workers of our own, and of telling them of a study
MOST_LOST = 10  # tasks of a block alone that are lost
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
class _Work:
    """What is computed in one task: how often its worker was killed."""

    what: Any
    number: int
    deaths: int = 0


@dataclass
class Cluster:
    """Workers that compute blocks; address: of a scheduler that is there, else so many workers are
    started here. A context manager."""

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
            stack.enter_context(_quiet())
            stack.enter_context(_as_no_script())
            stack.enter_context(dask.config.set(SETTINGS))
            self.client = stack.enter_context(self._connected())
            self._seen = self._whole = monotonic()
            while True:
                self._watch(wait=True)
                if self._threads:
                    break
                sleep(TICK)
            self._check_workers()
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *of: Any) -> bool | None:
        return self._stack.__exit__(*of)

    @contextmanager
    def _connected(self) -> Iterator[distributed.Client]:
        """A client, of a cluster of its own unless there is an address."""
        if self.address is not None:
            client = _client(self.address)
            self.said(f"dashboard: {client.dashboard_link}")
            try:
                yield client
            finally:
                client.close(timeout=5)
            return
        with ExitStack() as stack:
            stack.enter_context(_own_folder())
            with DeferredInterrupt(), _unheard():  # one that starts cannot be closed
                self._cluster = cluster = _started(self.workers)
                stack.callback(cluster.close, timeout=20)
            yield stack.enter_context(distributed.Client(cluster, timeout="60s"))

    @property
    def count(self) -> int:
        """How many blocks are computed at once: by all that there are to be of our own, by all
        that are there of others."""
        return self.workers if self._cluster is not None else self._threads

    def _check_workers(self) -> None:
        """Raise InputError for workers that would give other results."""
        if self._cluster is not None:
            return
        for worker, found in self.client.run(who, on_error="return").items():
            if not isinstance(found, OSError):  # one that died meanwhile is no worker any more
                check_worker(worker, found, of_client())

    def timed(self, study: Study) -> tuple[float, Texts]:
        """Time that a point takes [s] and generated texts, as a worker finds them; where points
        kill their worker or take long, as long as a block, and no texts."""
        future = self.client.submit(timed, study, pure=False)
        events: queue.SimpleQueue[Any] = queue.SimpleQueue()
        future.add_done_callback(events.put)
        try:
            if self._next(events, LONGEST) is None:
                return LONGEST, {}
            found: tuple[float, Texts] = self._found(future) or (BLOCK, {})
            return found
        finally:
            future.release()

    def compute(self, store: Store, blocks: Iterator[int], texts: Texts) -> Iterator[task.Done]:
        """Compute blocks, in whatever order they come to an end. Raises StudyError where that
        cannot be gone on with, InputError for workers that cannot be used."""
        yield from self._each(store, blocks, texts, compute, compute_alone)

    def pieces(
        self, store: Store, pieces: Iterator[Indices], texts: Texts
    ) -> Iterator[tuple[Indices, task.Arrays]]:
        """Compute points that are no blocks; what comes out is not written. Raises what `compute`
        raises."""
        yield from self._each(store, pieces, texts, piece, piece_alone)

    def _each(
        self, store: Store, wanted: Iterator[Any], texts: Texts, *ways: Callable[..., Any]
    ) -> Iterator[Any]:
        """What comes out of tasks; ways: how it is computed first, and how where that killed the
        worker."""
        context = Context(store, texts, self._cluster is not None)
        self._register(context)
        events: queue.SimpleQueue[distributed.Future] = queue.SimpleQueue()
        works: dict[str, _Work] = {}
        again: list[_Work] = []
        new = (_Work(what, number) for number, what in enumerate(wanted))
        try:
            while True:
                while len(works) < AHEAD * self._threads:
                    work = again.pop() if again else next(new, None)
                    if work is None:
                        break
                    way = ways[work.deaths >= ENOUGH_DEATHS]
                    key = f"{way.__name__}-{context.name}-{work.number}-{work.deaths}"
                    future = self.client.submit(way, context.name, work.what, key=key, pure=False)
                    works[future.key] = work
                    future.add_done_callback(events.put)
                if not works:
                    return
                future = self._next(events)
                assert future is not None
                work = works.pop(future.key)
                found = self._found(future)
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

    def _register(self, context: Context) -> None:
        """Give all workers what they need, and those that come later; again where one dies
        meanwhile. Raises StudyError where the scheduler is gone."""
        for turn in range(STARTS):
            try:
                self.client.register_plugin(context)
                return
            except (CommClosedError, TimeoutError):
                self._watch(wait=True)
                sleep(TICK * turn)
        raise StudyError("the workers do not answer")

    def _next(
        self, events: queue.SimpleQueue[distributed.Future], seconds: float = math.inf
    ) -> distributed.Future | None:
        """The next task that is over, None where none is for so many seconds. Raises StudyError
        where none will be."""
        until = monotonic() + seconds
        while monotonic() < until:
            try:
                future = events.get(timeout=TICK)
            except queue.Empty:
                self._watch()
                continue
            if monotonic() - self._asked > EVERY:
                self._watch()
            return future
        return None

    def _found(self, future: distributed.Future) -> Any:
        """What came out of a task, None where its worker was lost, be it when the task was done.
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
        self._watch()
        return None

    def _watch(self, wait: bool = False) -> None:
        """See how many workers there are. Raises StudyError where the scheduler is gone, and where
        there have been none for long."""
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
            self._mend(len(found), now)

    def _mend(self, found: int, now: float) -> None:
        """Start workers of our own in place of those that did not come back."""
        if found >= self.workers:
            self._whole = now
        elif now - self._whole > MENDED:
            self._whole = now
            there = {one["name"] for one in self._cluster.scheduler_info["workers"].values()}
            for name in [name for name in self._cluster.worker_spec if name not in there]:
                del self._cluster.worker_spec[name]
            self._cluster.scale(self.workers)


class _Nanny(distributed.Nanny):  # type: ignore[misc]  # of a package without types
    """A process beside a worker that waits less for its end: blocks are kept whole, or not."""

    async def close(self, timeout: float = ENDED, reason: str = "nanny-close") -> Any:
        """End the worker, whatever it computes."""
        return await super().close(timeout, reason)


def _started(workers: int) -> distributed.LocalCluster:
    """A cluster of so many processes, started again where one dies meanwhile. Raises StudyError
    where they do not start."""
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
def _unheard() -> Iterator[None]:
    """What a terminal sends to all that run in it does not reach processes that are started here:
    their client hears it, and ends them."""
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
def _own_folder() -> Iterator[None]:
    """Folders of workers, from which they import, lie in one that nobody else can write, and
    nothing is imported from the one in which they are started."""
    os.environ.setdefault(SAFE_PATH, SAFE)
    with (
        tempfile.TemporaryDirectory(prefix="rodgen-", ignore_cleanup_errors=True) as folder,
        dask.config.set({"temporary-directory": folder}),
    ):
        try:
            yield
        finally:
            end_safe_path()


def _client(address: str) -> distributed.Client:
    """A client of a scheduler that is there. Raises InputError where none answers."""
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
def _quiet() -> Iterator[None]:
    """Nothing of what Dask tells of workers that come and go."""
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
def _as_no_script() -> Iterator[None]:
    """Workers do not run the script again that starts them, as Python's processes do otherwise:
    a script then needs no `if __name__ == "__main__"`. Its functions reach them by value."""
    main = sys.modules["__main__"]
    kept = {name: main.__dict__.pop(name) for name in ("__file__",) if name in main.__dict__}
    spec, main.__spec__ = main.__spec__, None
    try:
        yield
    finally:
        main.__dict__.update(kept)
        main.__spec__ = spec
