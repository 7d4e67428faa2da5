"""A peer: a method of another library on a scene, and how it is held against rodgen.

Its formulation is its own, so that its accelerations are compared with rodgen's before it is timed.
"""

from __future__ import annotations

import signal
import threading
import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import ceil, inf
from typing import Any, ClassVar, NamedTuple, NoReturn

import numpy as np

import rodgen
from rodgen.analyse.precision.contestant import (
    Contestant,
    Deadline,
    NotModelledError,
    RunResult,
    TooSlowError,
)
from rodgen.analyse.precision.job import SAMPLES, Job, Stretch, integrate_stretches
from rodgen.arrays import Array
from rodgen.integrate.stability import Dominant, dominant
from rodgen_evidence.report.costs.cost_rows import VALUES, scene
from rodgen_evidence.report.interleaved_timing import Batch

AGREED = 1e-6  # relative: coordinates from link to link lose digits with n^4, 6e-10 at 50 links
STATES = 3  # that are looked at in every stretch
BEND, SPEED = 0.1, 0.5  # rad from link to link, rad/s (and m/s)
HALVINGS = 14  # of a step, at most

Accelerations = Callable[[float, Array], Array]  # t [s] and state -> second half of the rates
Over = Callable[[Stretch, Array], Array]  # a stretch, state at its start -> states at its times


class Peer(ABC):
    """A method on the scene of a job, which it is set up for when it is made.

    who: its library; target: what evaluates the equations; kind: of its settings, step or rtol;
    orders: of its methods, where they have one; most: links of a method, or of all of them, that
    it can do in time, and why not more; knows: the loads that it can model, None if the equations
    are rodgen's. setup: seconds of generation and compilation; counts: what the run that is on its
    way has counted.
    """

    who: ClassVar[str]
    target: ClassVar[str]
    kind: str = "rtol"
    orders: ClassVar[dict[str, float]] = {}
    most: ClassVar[int | dict[str, int]]
    why: ClassVar[str]
    knows: ClassVar[tuple[str, ...] | None] = None

    def __init__(self, job: Job, method: str):
        self.job, self.method = job, method
        self.setup: dict[str, float] = {}
        self.counts: Counter[str] = Counter()

    @classmethod
    def family(cls, job: Job, method: str, quick: bool) -> Iterator[Contestant]:
        """Settings from loose to tight. Raises NotModelledError, ArithmeticError."""
        if cls.knows is not None:
            refuse(cls.who, job.scene, cls.knows)
        at_most(
            cls.who,
            job.scene.rod.links,
            cls.most if isinstance(cls.most, int) else cls.most[method],
            cls.why,
        )
        one = cls(job, method)
        off = None if cls.knows is None else check_accelerations(job, one.accelerations)
        return (one.contestant(setting, off) for setting in one.settings(quick))

    def contestant(self, setting: float, off: float | None) -> Contestant:
        """A setting; off: how far the accelerations are from rodgen's."""
        over = self.integrator(setting)

        def integrate() -> RunResult:
            self.counts.clear()
            with stop_at_deadline():
                y = integrate_stretches(self.job, over)
            if not np.isfinite(y).all():
                raise ArithmeticError("states that are no numbers")
            return RunResult(y, dict(self.counts))

        return Contestant(
            *(self.who, self.name, self.target, self.kind, setting, integrate),
            order=self.order,
            setup=dict(self.setup),
            agreed=off,
        )

    @property
    def name(self) -> str:
        """The method's in tables."""
        return self.method

    @property
    def order(self) -> float | None:
        """The nominal order, of a method that has one."""
        return self.orders.get(self.method)

    def accelerations(self, t: float, y: Array) -> Array:
        """Second half of the rates, in rodgen's coordinates."""
        raise NotImplementedError  # of a peer that is compared by its runs alone

    @abstractmethod
    def settings(self, quick: bool) -> Iterator[float]:
        """Steps [s] or tolerances, from loose to tight."""

    @abstractmethod
    def integrator(self, setting: float) -> Over:
        """Create the function that integrates over a stretch; compile what the setting needs."""


def refuse(who: str, scene: rodgen.Scene, known: tuple[str, ...]) -> None:
    """Raise NotModelledError where the scene has a load that is not among those that are known, or
    a rod that differs along its length."""
    if scene.structure.nonuniform:
        raise NotModelledError(f"{who}: all links of this model are alike, and all joints")
    for term in scene.structure.terms:
        if term not in known:
            raise NotModelledError(f"{who}: this model has no {term.replace('_', ' ')}")


def at_most(who: str, links: int, most: int, why: str) -> None:
    """Raise NotModelledError for more links."""
    if links > most:
        raise NotModelledError(f"{who}: {why} for more than {most} links")


# Agreement -----------------------------------------------------------------------------------


def check_accelerations(job: Job, theirs: Accelerations) -> float:
    """Largest relative difference of accelerations from rodgen's, in every stretch of the loads.

    Raises ArithmeticError where it is beyond AGREED.
    """
    half, worst = len(job.initial_state) // 2, 0.0
    for stretch in job.stretches:
        for y in random_states(job.scene):
            ours = np.asarray(job.model.rhs(stretch.middle, y, job.p))[half:]
            worst = max(worst, difference(np.asarray(theirs(stretch.middle, y)), ours))
    return check_difference(worst)


def check_difference(off: float) -> float:
    """Raise ArithmeticError where a relative difference of accelerations is beyond AGREED."""
    if not off <= AGREED:
        raise ArithmeticError(f"the accelerations differ from rodgen's by {off:.1e}, relative")
    return off


def difference(theirs: Array, ours: Array) -> float:
    """The largest, over the largest of ours; infinite for what is not of one size, or no number."""
    if theirs.shape != ours.shape:
        return np.inf
    off = float(np.abs(theirs - ours).max() / np.abs(ours).max())
    return off if np.isfinite(off) else np.inf


def random_states(scene: rodgen.Scene) -> Array:
    """States (STATES, states) of a rod bent at random, and moving."""
    draw, half = np.random.default_rng(1), len(scene.initial_state()) // 2
    base = 2 * scene.boundary_condition.translates
    bends = draw.normal(scale=BEND, size=(STATES, half))
    bends[:, base:] = np.cumsum(bends[:, base:], axis=1) + (scene.rod.clamp_angle or 0.0)
    return np.concatenate([bends, SPEED * draw.normal(size=(STATES, half))], axis=1)


# Steps ---------------------------------------------------------------------------------------


def steps(job: Job, limit: float, quick: bool) -> Iterator[float]:
    """Steps [s] of which a whole number is the time between samples, from the limit down.

    limit: the longest that is stable [s], which may be infinite; each is half of the one before.
    """
    first, last = job.span
    between = (last - first) / SAMPLES
    count = max(1, ceil(between / limit))
    for halving in range(0, HALVINGS, 2 if quick else 1):
        yield between / (count * 2**halving)


def whole_steps(time: float, step: float) -> int:
    """Number of steps of at most that length that make up a time."""
    return max(1, ceil(time / step * (1 - 1e-9)))


def stable(limit: float, rate: float) -> float:
    """The longest stable step [s]: limit over |lambda| [1/s]; infinite where nothing moves."""
    return limit / rate if rate > 0 else inf


def fastest(job: Job) -> Dominant:
    """The fastest motion at the start."""
    first = job.stretches[0].first
    return dominant(job.model, first, job.initial_state, job.p)


def runs(stretch: Stretch) -> Iterator[tuple[float, Array]]:
    """Times at equal distances, each with the time before the first: of a stretch that starts or
    ends between two samples, three."""
    gaps = np.diff(stretch.times, prepend=stretch.first)
    cuts = np.flatnonzero(np.abs(np.diff(gaps)) > 1e-9 * gaps.max()) + 1
    before = stretch.first
    for times in np.split(stretch.times, cuts):
        yield before, times
        before = float(times[-1])


WHY = "stopped, as it took too long"


@contextmanager
def stop_at_deadline() -> Iterator[None]:
    """Raise TooSlowError at the deadline, from calls that ask Python for signals now and then."""
    alarms = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
    if not alarms or not np.isfinite(Deadline.at):
        yield
        return
    before = signal.signal(signal.SIGALRM, _over)
    signal.setitimer(signal.ITIMER_REAL, max(1e-3, Deadline.at - time.perf_counter()))
    try:
        yield
    except BaseException as error:
        if time.perf_counter() >= Deadline.at:  # as whatever the call made of it
            raise TooSlowError(WHY) from error
        raise
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _over(*_: Any) -> NoReturn:
    raise TooSlowError(WHY)


# Rates ---------------------------------------------------------------------------------------


class Prepared(NamedTuple):
    """A peer's rates for one number of links.

    rhs: from the state to its rates, both in rodgen's order, which is what is checked; batch:
    calls of the peer's own function at the state last given to rhs, without any conversion of it,
    which is what is timed.
    """

    rhs: Callable[[Array], Array]
    batch: Batch


def rod(links: int) -> rodgen.Scene:
    """The scene of the rates: free, uniform, under thrust at an angle."""
    return scene(links, angle=VALUES["follower_angle"])
