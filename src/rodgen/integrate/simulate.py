"""A scene to a Solution: the run from break point to break point."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path
from types import ModuleType
from typing import Any, Unpack

import numpy as np

from rodgen.errors import InputError
from rodgen.integrate.catalogue import loads_at_work
from rodgen.integrate.diagnosis import failure, step_doubts
from rodgen.integrate.endings import (
    FAILED,
    FINISHED,
    INTERRUPTED,
    ended_by,
)
from rodgen.integrate.error_growth import error_growth as growth_of
from rodgen.integrate.events import Watch
from rodgen.integrate.files.saver import IN_MEMORY, Saver
from rodgen.integrate.machine import Happened
from rodgen.integrate.methods.choose import choose, machine
from rodgen.integrate.methods.compiled import parts
from rodgen.integrate.samples import Recorder
from rodgen.integrate.solution import Interrupted, RunError, Solution
from rodgen.integrate.stepper import Stats, StepError
from rodgen.integrate.stretches import UNBOUNDED, Stretches, inside, step_to
from rodgen.integrate.trajectory import Event
from rodgen.memory import check_memory, gigabytes, is_small, limit
from rodgen.native.library import DeferredInterrupt
from rodgen.progress import running, telling
from rodgen.result import Note, warn_of
from rodgen.scene import Scene
from rodgen.scene.integration import AUTO, Settings, check_used, spelt_out
from rodgen.system import System

LINK, SAMPLE = 6e3, 24.0  # bytes for every link, and for every number of a sample
TICK = 0.1  # seconds between two calls of the progress callback

Progress = Callable[[float], None] | bool | None


@spelt_out
def simulate(
    system: System | Scene,
    *,
    target: str | None = None,
    model: ModuleType | None = None,
    progress: Progress = None,
    out: str | Path | None = None,
    checkpoint: float | None = None,
    error_growth: bool = False,
    **overrides: Unpack[Settings],
) -> Solution:
    """Integrate a scene.

    Parameters
    ----------
    system
        A scene: a rod, its loads, its initial state, span and method; or a System, which is one
        with other numbers: ``System(scene).at({"loads.follower.force": 300}, y0=y)``.
    target
        "c" or "numpy". By default C if it can be built.
    model
        A module that `build` has made before.
    progress
        A function that is called with the time [s] some ten times a second. If it has a method
        ``stage``, this is called with the stage of making the module, such as "compiling". By
        default terminals and notebooks show a bar if the run takes more than a second. False shows
        none.
    out
        A NetCDF file into which samples are written as they come, so that memory does not grow with
        the span. The Solution then has at most MOST_SAMPLES of them.
    checkpoint
        Time between two saved states of the run [s]. `resume` continues from the last one to the
        same bits.
    error_growth
        Also find how fast small errors grow (`sol.error_growth`, which the file does not keep). A
        second motion is followed for this, which takes three to six times as long as the run.
    **overrides
        Values for the scene's [integrate]: method, span, step, rtol, atol, output_every, t_eval,
        max_steps. They are checked as the scene's are.

    Returns
    -------
    Solution
        States (T, states) at T times, and every quantity that follows from them.

    Raises
    ------
    InputError
        For values that cannot be used, such as a step for a method that chooses its own, or masses
        that jump too often.
    TypeError
        If ``system`` is neither a System nor a Scene.
    RunError
        If the state is no longer finite or the method gives up. It carries the samples so far.
    Interrupted
        On Ctrl-C. It carries the samples so far.

    Warns
    -----
    DoubtWarning
        Of every doubt about the run, such as a fixed step beyond the method's stability limit, or
        an angle of several turns. They are notes of the Solution.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("missile")
    >>> sol = rodgen.simulate(scene, rtol=1e-8, progress=False)
    >>> sol.status, sol.y.shape[0] == len(sol.t), sol.energy_error < 1e-4
    ('finished', True, True)
    """
    system = System.of(system)
    notes = system.doubts
    if any(value is not None for value in overrides.values()):
        system = system.with_settings(**overrides)
        check_used(system.settings, overrides)
    check_samples(system, to_file=out is not None)
    system.course.check_masses()
    with _making(progress):
        if model is None:
            model = system.model(target, parts(system.settings, target))
        elif model.PROVENANCE["structure_hash"] != system.structure.hash:
            allowed = f"built for this scene, with {system.structure!r}"
            raise InputError("model", model.__name__, allowed)
        if system.settings.method == AUTO:
            system = system.integrated_by(choose(system, model).method)
        with DeferredInterrupt() as interrupt:
            notes += _doubts(system, model)
            if notes:
                warn_of(notes)  # before there is a file
            saver = Saver.begin(system, model, out, checkpoint)
            if saver.stream is not None:
                saver.stream.keep(notes)
            solution = _run(saver, progress, interrupt, notes)
        if error_growth:
            follow_errors(solution)
    return solution


def _doubts(system: System, model: ModuleType) -> tuple[Note, ...]:
    """What is doubtful about the steps, as far as it can be looked at: else the run will say so."""
    with np.errstate(all="ignore"), suppress(StepError, OverflowError):
        return step_doubts(system, model)
    return ()


def follow_errors(solution: Solution) -> None:
    """Find how fast errors grow in a run, and warn where its late angles are not to be trusted."""
    solution.errors = growth_of(solution)
    warn_of(solution.notes[len(solution.run_notes) :])


def check_samples(system: System, to_file: bool) -> None:
    """Raise InputError for a run that needs more memory than it may take, with its samples; of one
    to a file, some of these."""
    count, states = len(system.settings.samples), len(system.added)
    held = min(count, IN_MEMORY) if to_file else count

    def need(links: int) -> float:
        return LINK * links + SAMPLE * held * (2 * links + states)

    if is_small(need(system.structure.links)):
        return
    if need(1) > limit():
        allowed = f"fewer, of a longer output_every: they need {gigabytes(need(1))} of memory"
        raise InputError("samples", count, f"{allowed}, of {gigabytes(limit())} here")
    check_memory(f"a run of {count} samples", system.structure.links, need)


def resume(
    path: str | Path,
    *,
    progress: Progress = None,
    checkpoint: float | None = None,
) -> Solution:
    """Go on with a run that was killed, from the last checkpoint beside its file.

    What comes out is bitwise what the run would have given, on the same machine with the same
    compiler. Without a checkpoint the run starts again.

    Parameters
    ----------
    path
        The file that `simulate(out=...)` or `rodgen run` was writing.
    progress
        As of `simulate`.
    checkpoint
        Time between two saved states of the run [s].

    Returns
    -------
    Solution
        The whole run.

    Raises
    ------
    InputError
        For a run that has ended, and for a checkpoint that is damaged or of another version's
        module.

    Examples
    --------
    >>> import rodgen, tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "run.nc"
    >>> scene = rodgen.Scene.example("missile")
    >>> sol = rodgen.simulate(scene, out=path, checkpoint=1.0, progress=False)
    >>> rodgen.resume(path)
    Traceback (most recent call last):
    ...
    rodgen.errors.InputError: ...
    """
    saver = Saver.resume(Path(path), checkpoint)
    notes = saver.stream.notes if saver.stream is not None else ()
    warn_of(notes)
    with DeferredInterrupt() as interrupt:
        return _run(saver, progress, interrupt, notes)


def _making(progress: Progress) -> AbstractContextManager[None]:
    """Who is told of the making of the module and of its parts."""
    if progress is False:
        return telling(lambda _: None)
    stage = getattr(progress, "stage", None)
    return nullcontext() if stage is None else telling(stage)


def _run(
    saver: Saver,
    progress: Progress,
    interrupt: DeferredInterrupt,
    notes: tuple[Note, ...],
) -> Solution:
    """The run, with a bar if nothing else was asked for."""
    if callable(progress):
        return _Run(saver, progress, interrupt, notes).go()
    if progress is False:
        return _Run(saver, lambda _: None, interrupt, notes).go()
    with running(saver.system.name, *saver.system.settings.span) as update:
        return _Run(saver, update, interrupt, notes).go()


class _Run:
    def __init__(
        self,
        saver: Saver,
        progress: Callable[[float], None],
        interrupt: DeferredInterrupt,
        notes: tuple[Note, ...],
    ):
        """notes: on the numbers of the system."""
        self.saver, self.progress, self.interrupt = saver, progress, interrupt
        self.system, self.model = system, model = saver.system, saver.model
        self.settings, self.p = system.settings, system.p
        self.notes = notes
        switches = () if self.settings.fixed else system.course.switches()
        self.watch = Watch(system.events, model, self.p, switches)
        self.start = self._told = time.perf_counter()
        start, y0 = self.settings.span[0], system.y0
        self.works = loads_at_work(model)
        with np.errstate(all="ignore"):  # of a state that cannot be integrated
            self.machine = machine(model, self.p, self.settings, start, y0)
        times = self.settings.samples
        self.pole: Any = None
        self.recorder = Recorder(times, len(y0), self.works, saver.stream, saver.samples)
        self.seconds_before = saver.seconds
        saver.keep_safe(self.recorder, self.machine, self.watch, lambda: self.counts)

    def go(self) -> Solution:
        try:
            with np.errstate(all="ignore"):
                message = self._walk()
        except (StepError, OverflowError) as error:
            message = failure(error, self.system.scene, self.machine, self.pole)
            status = getattr(error, "status", FAILED)
            raise RunError(message, self.solution(status, message)) from None
        except KeyboardInterrupt:
            message = f"interrupted at t = {self.machine.t:.9g} s"
            raise Interrupted(self.solution(INTERRUPTED, message)) from None
        return self.solution(FINISHED, message)

    def _walk(self) -> str:
        """All stretches; what there is to say of the end."""
        stretches = Stretches.of(self.system.course, self.settings.fixed)
        self.pole = stretches.pole
        taken_up = self.saver.restore(self.machine)
        times, rows = self.recorder.room()
        if not taken_up and times[0] == self.machine.t:
            rows[0] = 0.0
            rows[0, : self.recorder.states] = self.machine.y
            self.recorder.took(1)
        try:
            for end in stretches.ends:
                if end <= self.machine.t:
                    continue
                if not (taken_up and self.machine.end == end):
                    self.machine.begin(end, *inside(self.machine.t, end), stretches.swing)
                taken_up = False
                self._told = time.perf_counter()
                step_to(
                    end, self.machine, self.recorder, self.watch, self.settings.budget, self._look
                )
        except Happened as event:
            name = self.system.events[event.number].name
            return ended_by(event.t, name)
        if self.pole:  # a step across it would be finite, and wrong
            raise StepError(UNBOUNDED)
        return ""

    def _look(self) -> None:
        """Write what is to be written, tell how far it is, and heed Ctrl-C."""
        now = time.perf_counter()
        self.saver.tick(now)
        if now - self._told > TICK:
            self._told = now
            self.progress(self.machine.t)
        self.interrupt.look()

    @property
    def counts(self) -> Stats:
        """What the run has cost so far."""
        seconds = self.seconds_before + time.perf_counter() - self.start
        return Stats.of(self.machine.counts, seconds, self.model.PROVENANCE["target"])

    def solution(self, status: str, message: str) -> Solution:
        """What there is, from memory or from the file."""
        names = [event.name for event in self.system.events]
        with np.errstate(all="ignore"):
            t, y, work = self.recorder.kept()
            stats = self.counts
            if self.saver.stream is not None:
                kept = self.saver.finish(status, message, stats)
                kept.run_notes = self.notes  # for all of which a file may have no room
                return kept
        happened = tuple(Event(names[number], t, y) for number, t, y in self.watch.happened)
        return Solution(
            system=self.system,
            t=t,
            y=y,
            work=work,
            stats=stats,
            status=status,
            message=message,
            model=self.model,
            events=happened,
            run_notes=self.notes,
        )
