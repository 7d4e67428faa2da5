"""Many runs of one module: from parameters and initial states to what is kept of every run."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from types import ModuleType
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike
from pydantic import ValidationError

from rodgen.arrays import Array
from rodgen.errors import InputError, Missing, check_type
from rodgen.integrate.diagnosis import advice
from rodgen.integrate.ensemble import Ensemble
from rodgen.integrate.events import EventDetector
from rodgen.integrate.lane_runs import ReductionPlan, run_lanes, stop_reason
from rodgen.integrate.methods.method_choice import choose, make_integrator
from rodgen.integrate.module_facts import ModuleFacts, facts_of
from rodgen.integrate.quantity_formulas import MotionSlice, loads_at_work
from rodgen.integrate.recorder import Recorder
from rodgen.integrate.reductions import Crossing, Reduction
from rodgen.integrate.stepper import FAILED, FINISHED, MOMENT, StepError, event_message
from rodgen.integrate.stretches import Integrator, Stretches
from rodgen.model.methods import METHODS
from rodgen.native.native_batch import REACHED, STOPPED
from rodgen.scene import Scene
from rodgen.scene.integration import (
    AUTO,
    IntegrationSettings,
    IntegrationTable,
    check_settings_used,
    with_keywords,
)
from rodgen.scene.plain_tables import to_plain
from rodgen.scene.validation import to_input_error
from rodgen.system import System

MOST_WORKERS = 1024
PARTS = ("rhs", "power")  # of a module of many runs; lanes come when they are asked for


@with_keywords
def simulate_many(
    system: System | Scene | ModuleType,
    p: ArrayLike | Mapping[str, ArrayLike] | None = None,
    y0: ArrayLike | None = None,
    *,
    keep: Sequence[str] = (),
    workers: int = 1,
    **settings: Unpack[IntegrationSettings],
) -> Ensemble:
    """Integrate many rods of one structure, each with parameters and an initial state of its own.

    Explicit methods of C modules take their steps in C, as many rods side by side as a vector has
    lanes, each with a step of its own. Samples are not stored, but taken into what is kept as runs
    go. Where laws of the motion switch at a sensor or a state, with methods that are implicit or
    not compiled, and for quantities that C does not have, runs are made one after the other. What
    comes out of a run does not depend on the others, their order or number, nor on the workers, to
    the bit. A run that fails does not stop the others.

    Parameters
    ----------
    system
        A System or a scene, with its own settings where none are given; or a module of `build`.
        Events are not looked for.
    p
        What the rods differ in. Of a System by keys of its scene, such as "loads.follower.force",
        each a number or (rods,), in SI units. Or parameters (rods, parameters), as the module's
        `parameters` packs them; of a module also by their names in it, each a number or (rods,), of
        several numbers (K,) or (rods, K). One set for all has no first axis.
    y0
        States (rods, states) at the start, in SI units and the order of the module's STATE, or one
        for all. By default those of the System.
    keep
        Reductions such as "max(phi_19)" or "rms(tip_y, from=5)": last, min, max, mean, rms, std or
        time_of_max of a number of any quantity, over the samples of a run (between two times [s]).
    workers
        Threads that share the work.
    **settings
        As those of [integrate] in a scene: span, method (of a module by default dop853), step,
        rtol, atol, output_every, t_eval, max_steps.

    Returns
    -------
    Ensemble
        What is kept, in arrays (rods,).

    Raises
    ------
    InputError
        For arrays of other shapes, values that are not finite or not allowed, names that the module
        does not have, reductions that are none, and settings that cannot be used.
    TypeError
        For what is no System, scene or module.

    Examples
    --------
    >>> import numpy as np, rodgen
    >>> scene = rodgen.Scene.example("missile")
    >>> masses = {"rod.mass": np.linspace(19, 21, 3)}
    >>> found = rodgen.simulate_many(scene, masses, keep=["last(tip_x)"], span=[0, 1], rtol=1e-6)
    >>> found.values["last(tip_x)"].shape
    (3,)
    """
    check_type("system", system, System, Scene, ModuleType, see="Scene.from_toml")
    if isinstance(system, ModuleType):
        for name, value in (("p", p), ("y0", y0)):
            if value is None:
                raise InputError(name, Missing(), "given beside a module")
        return simulate_rods(system, p, y0, _read_settings(settings), keep=keep, workers=workers)
    system = System.of(system).with_settings(**settings)
    check_settings_used(system.settings, settings)
    if ends := [event.name for event in system.events if event.action == "stop"]:
        raise InputError("events", ends, "absent, as they stop a run: rodgen.study heeds them")
    model = system.model(parts=PARTS)
    if isinstance(p, Mapping):
        p, own = system.batch_arrays(p)
    else:
        p, own = system.p if p is None else p, system.y0
    if system.settings.method == AUTO:
        system = system.with_method(choose(system, model).method)
    y0 = own if y0 is None else y0
    return simulate_rods(model, p, y0, system.settings, keep=keep, workers=workers)


def simulate_rods(
    model: ModuleType,
    p: ArrayLike | Mapping[str, ArrayLike] | None,
    y0: ArrayLike | None,
    settings: IntegrationTable,
    keep: Sequence[str] = (),
    crossings: Sequence[Crossing] = (),
    traced: Sequence[str] = (),
    workers: int = 1,
) -> Ensemble:
    """Integrate many rods of a module, as `simulate_many` does. settings: with a method that is
    chosen; crossings: levels to look for, traced: numbers of which all samples are kept; both in
    runs side by side alone. Raises what `simulate_many` raises."""
    facts = facts_of(model)
    whole = isinstance(workers, int) and not isinstance(workers, bool)
    if not (whole and 0 < workers <= MOST_WORKERS):
        raise InputError("workers", workers, f"a whole number from 1 to {MOST_WORKERS}")
    width, states = facts.structure.width, facts.states
    packed = facts.pack(p) if isinstance(p, Mapping) else _check_rows("p", p, width)
    y = _check_rows("y0", y0, states)
    if len(packed) != len(y) and 1 not in (len(packed), len(y)):
        allowed = f"({len(packed)}, {states}), a state for every row of p, or one state ({states},)"
        raise InputError("y0", _Shape(y.shape), allowed)
    rods = min(len(packed), len(y)) and max(len(packed), len(y))
    reductions = facts.parse_reductions((keep,) if isinstance(keep, str) else keep)
    plan = facts.plan(settings, reductions, tuple(crossings), tuple(traced))
    if plan is None:
        return _run_in_turn(facts, reductions, settings, packed, y, rods)
    return _run_in_lanes(facts, plan, reductions, settings, packed, y, rods, workers)


class _Shape(tuple[int, ...]):
    """Shape of an array that was given, as messages show it."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"(an array of shape {tuple(self)})"


def _check_rows(name: str, values: Any, width: int) -> Array:
    """Check rows of numbers, and return them as doubles, (rods, width). Raises InputError."""
    array = np.asarray(values)
    if isinstance(values, np.ma.MaskedArray) or array.dtype.kind not in "iuf":
        raise InputError(name, values, "real numbers")
    if array.ndim not in (1, 2) or array.shape[-1] != width:
        raise InputError(name, _Shape(array.shape), f"of shape ({width},) or (rods, {width})")
    rows = np.ascontiguousarray(array.reshape(-1, width), dtype=float)
    if not np.isfinite(rows).all():
        rod, at = (int(place) for place in np.argwhere(~np.isfinite(rows))[0])
        where = f"{name}[{rod}, {at}]" if array.ndim == 2 else f"{name}[{at}]"
        raise InputError(where, float(rows[rod, at]), "a finite number")
    return rows


def _read_settings(given: Mapping[str, Any]) -> IntegrationTable:
    """Settings beside a module, checked as a scene's are."""
    table = {name: to_plain(v, name) for name, v in given.items() if v is not None}
    try:
        settings = IntegrationTable.model_validate({"method": "dop853"} | table)
    except ValidationError as error:
        raise to_input_error(error, IntegrationTable) from None
    if settings.method == AUTO:
        raise InputError("method", AUTO, f"one of {', '.join(METHODS)}: auto looks at one scene")
    check_settings_used(settings, table)
    return settings


# Side by side ----------------------------------------------------------------------------------


def _run_in_lanes(
    facts: ModuleFacts,
    plan: ReductionPlan,
    reductions: Sequence[Reduction],
    settings: IntegrationTable,
    p: Array,
    y: Array,
    rods: int,
    workers: int,
) -> Ensemble:
    """Integrate the rods side by side, in the lanes of C."""
    table, which, refused = facts.find_stretches(settings, p, rods)
    gaps = pairwise((-1, *sorted(refused), rods))
    jobs = [(before + 1, gap) for before, gap in gaps if gap > before + 1]
    times, lanes, first = settings.sample_times, facts.model.LANES, facts.states
    block = run_lanes(lanes, plan, settings, times, p, y, table, which, rods, jobs, workers)
    outcome, reached = block.outcome, block.outcome["status"] == REACHED
    ended = np.full(rods, FINISHED)
    message: dict[int, str] = {}
    # Of what has come to its end there is nothing to say: most often that is all of it.
    for rod in () if reached.all() else np.flatnonzero(~reached).tolist():
        status, t = int(outcome["status"][rod]), float(outcome["t"][rod])
        if status == STOPPED:
            message[rod] = event_message(t, plan.watched.stop_name(int(outcome["stopped"][rod])))
            continue
        ended[rod] = FAILED
        message[rod] = refused.get(rod) or _failure_message(
            stop_reason(status, settings, t), t, settings
        )
    for rod in refused:
        block.values[rod], block.state[rod], outcome["t"][rod] = np.nan, np.nan, settings.span[0]
    least, most = block.values[:, -2], block.values[:, -1]
    return Ensemble(
        values={one.text: block.values[:, at] for at, one in enumerate(reductions)},
        t=outcome["t"],
        y=block.state[:, :first],
        work={term: block.state[:, first + at] for at, term in enumerate(lanes.works)},
        status=ended,
        message=message,
        nsteps=outcome["steps"],
        rejected=outcome["rejected"],
        nfev=outcome["rhs"],
        energy_error=np.maximum(most, -least),
        crossed=tuple(plan.watched.decode(block.crossed)),
        traces=block.traces,
        samples=times,
    )


def _failure_message(why: str, t: float, settings: IntegrationTable) -> str:
    return f"stopped at t = {t:.9g} s: {why}; {advice(why, settings, False)}"


# One by one ------------------------------------------------------------------------------------


def _run_in_turn(
    facts: ModuleFacts,
    reductions: Sequence[Reduction],
    settings: IntegrationTable,
    p: Array,
    y: Array,
    rods: int,
) -> Ensemble:
    """Integrate the rods one after the other, by whatever method."""
    works, times = loads_at_work(facts.model), settings.sample_times
    made = Ensemble(
        values={one.text: np.full(rods, np.nan) for one in reductions},
        t=np.full(rods, settings.span[0]),
        y=np.full((rods, facts.states), np.nan),
        work={term: np.full(rods, np.nan) for term in works},
        status=np.full(rods, FINISHED),
        message={},
        nsteps=np.zeros(rods, dtype=np.int64),
        rejected=np.zeros(rods, dtype=np.int64),
        nfev=np.zeros(rods, dtype=np.int64),
        energy_error=np.full(rods, np.nan),
    )
    for rod in range(rods):
        of_rod, start = p[rod % len(p)], y[rod % len(y)]
        recorder = Recorder(times, facts.states, works)
        with np.errstate(all="ignore"):  # of a state that cannot be integrated
            taken = make_integrator(facts.model, of_rod, settings, settings.span[0], start)
            try:
                run = of_rod, start, taken, recorder
                found, made.energy_error[rod] = _run_rod(facts, settings, reductions, *run)
                for one, value in zip(reductions, found, strict=True):
                    made.values[one.text][rod] = value
            except (StepError, OverflowError, InputError) as error:
                made.status[rod] = getattr(error, "status", FAILED)
                why = _with_values(str(error), facts, of_rod)
                if not isinstance(error, InputError):
                    why = _failure_message(why, taken.t, settings)
                made.message[rod] = why
            made.t[rod], made.y[rod] = taken.t, taken.y
            for term, work in zip(works, taken.works(recorder), strict=True):
                made.work[term][rod] = work
            counts = taken.counts
            made.nsteps[rod], made.nfev[rod] = counts.nsteps, counts.nfev
            made.rejected[rod] = -1 if counts.rejected is None else counts.rejected
    return made


def _with_values(text: str, facts: ModuleFacts, p: Array) -> str:
    """Replace the names that numbers of expressions have in p by their values in a text."""
    structure = facts.structure
    if not structure.numbers:
        return text
    names = re.compile(rf"\b({'|'.join(map(re.escape, structure.numbers))})\b")
    return names.sub(lambda found: f"{p[structure.indices[found[1]]]:g}", text)


def _run_rod(
    facts: ModuleFacts,
    settings: IntegrationTable,
    reductions: Sequence[Reduction],
    p: Array,
    start: Array,
    machine: Integrator,
    recorder: Recorder,
) -> tuple[list[float], float]:
    """Run a rod to its end, and return its reductions and the largest error of its energy balance
    [J]. Raises StepError."""
    laws, fixed = facts.time_laws(settings.span, p), settings.has_fixed_step
    switches, (begin, end) = () if fixed else laws.switches(), settings.span
    touching, moment = facts.structure.contact_events, MOMENT * (end - begin)
    watch = EventDetector(touching, facts.model, p, switches, moment)
    Stretches.of(laws, fixed).walk(machine, recorder, watch, settings.step_limit)
    t, y, work = recorder.in_memory()
    at_start = MotionSlice(facts.model, p, start[None], np.array(settings.span[:1]))
    motion = MotionSlice(
        *(facts.model, p, y, t, work),
        start_energy=float(at_start.values("total_energy")[0]),
        timed=facts.structure.time_dependent_loads(p),
    )
    found = [one.reduce(t, facts.numbers.values(motion, one.number)) for one in reductions]
    return found, float(np.abs(motion.values("energy_balance")).max(initial=0.0))
