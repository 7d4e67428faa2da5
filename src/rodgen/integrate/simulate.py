"""Integration of a scene to a Solution, from break point to break point."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path
from types import ModuleType
from typing import Any, Unpack

import numpy as np

from rodgen.errors import InputError
from rodgen.integrate.dense_output import error_growth as growth_of
from rodgen.integrate.diagnosis import failure_message, step_doubts
from rodgen.integrate.events import EventDetector
from rodgen.integrate.files.saver import IN_MEMORY, Saver
from rodgen.integrate.methods.compiled_integrator import initial_parts
from rodgen.integrate.methods.method_choice import choose, make_integrator
from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.integrate.recorder import Recorder
from rodgen.integrate.solution import Interrupted, RunError, Solution
from rodgen.integrate.stepper import (
    FAILED,
    FINISHED,
    INTERRUPTED,
    MOMENT,
    Stats,
    StepError,
    event_message,
)
from rodgen.integrate.stretches import EventStop, Stretches
from rodgen.integrate.trajectory import Event
from rodgen.memory import check_memory, format_gigabytes, is_small, memory_limit
from rodgen.native.library import DeferredInterrupt
from rodgen.progress import report_stages_to, show_run
from rodgen.result import Note, warn_of
from rodgen.scene import Scene
from rodgen.scene.integration import AUTO, IntegrationSettings, check_settings_used, with_keywords
from rodgen.system import System
from rodgen.system.link_inertia import check_masses

LINK, SAMPLE = 6e3, 24.0  # bytes for every link, and for every number of a sample
TICK = 0.1  # seconds between two calls of the progress callback

Progress = Callable[[float], None] | bool | None


@with_keywords
def simulate(
    system: System | Scene,
    *,
    target: str | None = None,
    model: ModuleType | None = None,
    progress: Progress = None,
    out: str | Path | None = None,
    checkpoint: float | None = None,
    error_growth: bool = False,
    **overrides: Unpack[IntegrationSettings],
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
        check_settings_used(system.settings, overrides)
    check_samples(system, to_file=out is not None)
    system.time_laws.check_jumps()
    with _build_reports(progress):
        if model is None:
            model = system.model(target, initial_parts(system.settings, target))
        elif model.PROVENANCE["structure_hash"] != system.structure.hash:
            allowed = f"built for this scene, with {system.structure!r}"
            raise InputError("model", model.__name__, allowed)
        else:
            check_masses(system)
        if system.settings.method == AUTO:
            system = system.with_method(choose(system, model).method)
        with DeferredInterrupt() as interrupt:
            notes += _doubts(system, model)
            if notes:
                warn_of(notes)  # before there is a file
            saver = Saver.begin(system, model, out, checkpoint)
            if saver.stream is not None:
                saver.stream.write_notes(notes)
            solution = _run(saver, progress, interrupt, notes)
        warn_of(solution.notes[len(notes) :])
        if error_growth:
            add_error_growth(solution)
    return solution


def _doubts(system: System, model: ModuleType) -> tuple[Note, ...]:
    """Doubts about the steps; none where they cannot be looked at, which the run will tell."""
    with np.errstate(all="ignore"), suppress(StepError, OverflowError):
        return tuple(step_doubts(system, model))
    return ()


def add_error_growth(solution: Solution) -> None:
    """Find how fast errors grow in a run, and warn where its late angles are not to be trusted."""
    known = len(solution.notes)
    solution.errors = growth_of(solution)
    warn_of(solution.notes[known:])


def check_samples(system: System, to_file: bool) -> None:
    """Raise InputError for a run whose samples need more memory than it may take; of a run to a
    file, only those that the Solution holds count."""
    count, states = len(system.settings.sample_times), len(system.structure.state_names)
    held = min(count, IN_MEMORY) if to_file else count

    def need(links: int) -> float:
        return LINK * links + SAMPLE * held * (2 * links + states)

    if is_small(need(system.structure.n_links)):
        return
    if need(1) > memory_limit():
        allowed = (
            f"fewer, of a longer output_every: they need {format_gigabytes(need(1))} of memory"
        )
        raise InputError("samples", count, f"{allowed}, of {format_gigabytes(memory_limit())} here")
    check_memory(f"a run of {count} samples", system.structure.n_links, need)


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
        solution = _run(saver, progress, interrupt, notes)
    warn_of(solution.notes[len(notes) :])
    return solution


def _build_reports(progress: Progress) -> AbstractContextManager[None]:
    """Context in which stages of building the module are reported as `progress` asks."""
    if progress is False:
        return report_stages_to(lambda _: None)
    stage = getattr(progress, "stage", None)
    return nullcontext() if stage is None else report_stages_to(stage)


def _run(
    saver: Saver,
    progress: Progress,
    interrupt: DeferredInterrupt,
    notes: tuple[Note, ...],
) -> Solution:
    """Perform the run, with a bar if nothing else was asked for."""
    if callable(progress) or progress is False:
        return _Simulation(saver, progress or (lambda _: None), interrupt, notes).run()
    with show_run(saver.system.name, *saver.system.settings.span) as update:
        return _Simulation(saver, update, interrupt, notes).run()


class _Simulation:
    def __init__(
        self,
        saver: Saver,
        progress: Callable[[float], None],
        interrupt: DeferredInterrupt,
        notes: tuple[Note, ...],
    ):
        """Prepare the run; notes: on the numbers of the system."""
        self.saver, self.progress, self.interrupt = saver, progress, interrupt
        self.system, self.model = system, model = saver.system, saver.model
        self.settings, self.notes = system.settings, notes
        switches = () if self.settings.has_fixed_step else system.time_laws.switches()
        begin, end = self.settings.span
        watched = system.events, model, system.p, switches
        self.watch = EventDetector(*watched, MOMENT * (end - begin))
        self.start = self._told = time.perf_counter()
        start, y0 = self.settings.span[0], system.y0
        with np.errstate(all="ignore"):  # of a state that cannot be integrated
            self.machine = make_integrator(model, system.p, self.settings, start, y0)
        times, works = self.settings.sample_times, loads_at_work(model)
        self.pole: Any = None
        self.recorder = Recorder(times, len(y0), works, saver.stream, saver.samples)
        saver.attach(self.recorder, self.machine, self.watch, lambda: self.stats)

    def run(self) -> Solution:
        try:
            with np.errstate(all="ignore"):
                message = self._step_through()
        except (StepError, OverflowError) as error:
            message = failure_message(error, self.system.scene, self.machine, self.pole)
            status = getattr(error, "status", FAILED)
            raise RunError(message, self.solution(status, message)) from None
        except KeyboardInterrupt:
            message = f"interrupted at t = {self.machine.t:.9g} s"
            raise Interrupted(self.solution(INTERRUPTED, message)) from None
        return self.solution(FINISHED, message)

    def _step_through(self) -> str:
        """Step through all stretches, and return the message of the end."""
        stretches = Stretches.of(self.system.time_laws, self.settings.has_fixed_step)
        self.pole = stretches.pole
        self.saver.restore(self.machine)
        parts, budget = (self.machine, self.recorder, self.watch), self.settings.step_limit
        try:
            stretches.walk(*parts, budget, self._between_slices)
        except EventStop as event:
            return event_message(event.t, self.system.events[event.number].name)
        return ""

    def _between_slices(self) -> None:
        """Write what is due, report the time reached, and heed Ctrl-C."""
        now = time.perf_counter()
        self.saver.tick(now)
        if now - self._told > TICK:
            self._told = now
            self.progress(self.machine.t)
        self.interrupt.raise_pending()

    @property
    def stats(self) -> Stats:
        """Costs of the run so far, with its time by the clock."""
        seconds = self.saver.seconds + time.perf_counter() - self.start
        return Stats.of(self.machine.counts, seconds, self.model.PROVENANCE["target"])

    def solution(self, status: str, message: str) -> Solution:
        """Solution of the samples so far, from memory or from the file."""
        names = [event.name for event in self.system.events]
        with np.errstate(all="ignore"):
            t, y, work = self.recorder.in_memory()
            stats = self.stats
            if self.saver.stream is not None:
                kept = self.saver.finish(status, message, stats)
                kept.run_notes = self.notes  # for all of which a file may have no room
                return kept
        happened = tuple(Event(names[number], t, y) for number, t, y in self.watch.happened)
        more: dict[str, Any] = {"model": self.model, "events": happened, "run_notes": self.notes}
        return Solution(self.system, t, y, work, stats, status, message, **more)
