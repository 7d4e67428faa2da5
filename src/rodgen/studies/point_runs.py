"""Runs of points: in vector lanes of C where possible, else one by one."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.diagnosis import count_doubts
from rodgen.integrate.methods.method_choice import choose, choose_from
from rodgen.integrate.module_facts import ModuleFacts, facts_of
from rodgen.integrate.reductions import Crossing
from rodgen.integrate.simulate import simulate
from rodgen.integrate.simulate_many import simulate_rods
from rodgen.integrate.solution import RunError
from rodgen.integrate.stepper import FAILED
from rodgen.scene.integration import EventTable
from rodgen.studies.kept_quantities import PARTS, check_numbers, run_quantities
from rodgen.studies.measures import (
    CrossingSection,
    EventCount,
    RunMeasure,
    SampleReduction,
    SpectralPeak,
    UserFunction,
    event_crossing,
)
from rodgen.studies.point_arrays import METHOD, PointArrays, PointBatch, group_by, slot_names
from rodgen.studies.sampling import Point, reference_point
from rodgen.studies.time_limit import TimeLimitExceeded, time_limit
from rodgen.system import System

if TYPE_CHECKING:
    from rodgen.studies.study import Study

MOST_CROSSED = 2**22  # numbers of crossings and samples that are kept at once
MOST_CORNERED = 4  # varied numbers whose ends are tried in all combinations; beyond, one by one
ANYWHERE = EventTable(quantity="depth_wall", value=0.0)
FEW = 3  # points of a group, up to which making their scenes is faster than a batch


def compute(study: Study, points: list[Point], made: PointArrays) -> None:
    """Run every point, and fill in the kept quantities."""
    if any(isinstance(one, UserFunction) for one in run_quantities(study)):
        _run_one_by_one(study, points, range(len(points)), made)
    else:
        _run_together(study, points, made)


# Together -----------------------------------------------------------------------------------------


class _Batch:
    """Runs of one structure with the same settings: numbers of points, and their p and y0."""

    def __init__(self, system: System):
        self.system = system
        self.points: list[int] = []
        self.p: list[Array] = []
        self.y: list[Array] = []

    def add(self, points: Iterable[int], p: Array, y: Array) -> None:
        self.points.extend(points)
        self.p.append(p)
        self.y.append(y)


def _run_together(study: Study, points: list[Point], made: PointArrays) -> None:
    names = slot_names(study)
    others = tuple(name for axis in study.axes if (name := axis.name) not in names)
    batches: dict[Any, _Batch] = {}

    def batch_of(system: System) -> _Batch:
        events = tuple(event.model_dump_json() for event in system.events)
        key = system.structure, system.settings.model_dump_json(), events
        return batches.setdefault(key, _Batch(system))

    start = time.process_time()
    for shared, members in group_by(points, others):
        share = _shared_batch(study, tuple(shared.items())) if len(members) > FEW else None
        left = members
        usual = _common_method(study, tuple(shared.items()))
        if share is not None:
            p, y, taken = share.rows([points[at] for at in members])
            rows = np.flatnonzero(taken)
            for method, some in _group_by_method(share, usual, p, y, rows).items():
                ready = [members[row] for row in some]
                batch_of(share.system.with_method(method)).add(ready, p[some], y[some])
            left = [at for at, is_taken in zip(members, taken, strict=True) if not is_taken]
        for at in left:
            try:
                system = study.system_at(points[at])
                chosen = system.with_method(usual or _choose_method(system))
                batch_of(chosen).add([at], system.p[None], system.y0[None])
            except InputError as error:
                made.fail(at, str(error))
    made.arrays["seconds"][:] = (time.process_time() - start) / max(1, len(points))
    for one in batches.values():
        made.arrays[METHOD.name][one.points] = one.system.settings.method
        try:
            _run_batch(study, one, points, made)
        except InputError as error:
            for at in one.points:
                made.fail(at, str(error))


def _run_batch(study: Study, batch: _Batch, points: list[Point], made: PointArrays) -> None:
    """Run a batch, in lanes if possible. Raises InputError."""
    wanted = run_quantities(study)
    system = _with_section_events(batch.system, wanted)
    model = system.model(parts=PARTS)
    facts, settings = facts_of(model), system.settings
    check_numbers(system, wanted, facts)
    texts = [one.text for one in wanted if isinstance(one, SampleReduction)]
    crossings, crossing = _crossings(system, wanted, facts)
    peaks = [one for one in wanted if isinstance(one, SpectralPeak)]
    more = tuple(crossings), tuple(one.number for one in peaks)
    if any(more) and facts.plan(settings, facts.parse_reductions(texts), *more) is None:
        _run_one_by_one(study, points, batch.points, made)
        return
    p, y = np.concatenate(batch.p), np.concatenate(batch.y)
    width = 1 + sum(one.width for one in crossings) + len(peaks) * len(system.settings.sample_times)
    for few in np.array_split(np.arange(len(p)), -(-len(p) * width // MOST_CROSSED)):
        start, at = time.process_time(), np.array(batch.points)[few]
        limit = study.time_limit and study.time_limit * len(few)
        try:
            with time_limit(limit, system):
                found = simulate_rods(model, p[few], y[few], settings, texts, *more)
        except TimeLimitExceeded:  # some of them, or one
            _run_one_by_one(study, points, at.tolist(), made)
            continue
        values: dict[str, Any] = {text: found[text] for text in texts}
        for one, number in crossing:
            values |= one.compute_many(found.crossed[number], facts, p[few])
        for number, peak in enumerate(peaks):
            values |= peak.compute_many(found, number)
        doubts = count_doubts(batch.system, model, p[few], y[few])
        made.set_points(at, values, found.energy_error, found.status, found.message, doubts)
        shares = np.maximum(found.nfev, 1)
        made.arrays["seconds"][at] += (time.process_time() - start) * shares / shares.sum()


def _crossings(
    system: System, wanted: Sequence[RunMeasure], facts: ModuleFacts
) -> tuple[list[Crossing], list[tuple[EventCount | CrossingSection, int]]]:
    """Return the crossings that runs watch for, and the index of that of each kept quantity."""
    found = [
        replace(event_crossing(event), stop=event.name)
        for event in system.events
        if event.action == "stop"
    ]
    made: list[tuple[EventCount | CrossingSection, int]] = []
    events = {event.name: event for event in system.events}
    for one in wanted:
        if isinstance(one, EventCount | CrossingSection):
            made.append((one, len(found)))
            # Of one that is counted at any joint, no crossing stands for it: then runs are apart.
            found.append(one.crossing(events.get(one.event, ANYWHERE), facts))
    return found, made


@lru_cache(maxsize=512)
def _shared_batch(study: Study, shared: tuple[tuple[str, Any], ...]) -> PointBatch | None:
    """Return the batch of points that share these values, None where there can be none."""
    try:
        return PointBatch.of(study, reference_point(study) | dict(shared), slot_names(study))
    except InputError:
        return None


@lru_cache(maxsize=512)
def _common_method(study: Study, shared: tuple[tuple[str, Any], ...]) -> str:
    """Return the method of all points that share these values: the one that `auto` chooses at all
    corners of the other varied numbers, "" where it chooses several. It depends on the study alone,
    and not on which of its points are computed."""
    given = reference_point(study) | dict(shared)
    names = [name for name in slot_names(study) if name not in dict(shared)]
    ends = {axis.name: axis.extremes for axis in study.axes if axis.name in names}
    if len(ends) <= MOST_CORNERED:
        tried = [dict(zip(ends, values, strict=True)) for values in product(*ends.values())]
    else:
        tried = [{name: value} for name, both in ends.items() for value in both]
    found = set()
    for changes in ({}, *tried):
        with suppress(InputError):  # of a point that is not in the study, or fails in its turn
            found.add(_choose_method(study.system_at(given | changes)))
        if len(found) > 1:
            return ""
    return found.pop() if found else ""


def _group_by_method(
    share: PointBatch, method: str, p: Array, y: Array, rows: NDArray[np.intp]
) -> dict[str, NDArray[np.intp]]:
    """Group rows of p and y0 by the method that runs them; method: that of all rows, or ""."""
    if method:
        return {method: rows}
    settings, model = share.system.settings, share.system.model(parts=PARTS)
    found = np.array([choose_from(settings, model, p[row], y[row]).method for row in rows])
    return {str(name): rows[found == name] for name in dict.fromkeys(found.tolist())}


def _choose_method(system: System) -> str:
    return choose(system, system.model(parts=PARTS)).method


# One by one ---------------------------------------------------------------------------------------


def _run_one_by_one(
    study: Study, points: list[Point], places: Iterable[int], made: PointArrays
) -> None:
    """Run some of the points by `simulate`; places: their positions."""
    names, wanted = slot_names(study), run_quantities(study)
    others = [axis.name for axis in study.axes if axis.name not in names]
    for at in places:
        start, point = time.process_time(), points[at]
        shared = tuple((name, point[name]) for name in others)
        try:
            system = study.system_at(point)
            system = system.with_method(_common_method(study, shared) or _choose_method(system))
            made.arrays[METHOD.name][at] = system.settings.method
            with time_limit(study.time_limit, system):
                _run_point(_with_section_events(system, wanted), wanted, made, at)
        except (InputError, RunError) as error:
            made.fail(at, str(error), getattr(error, "status", FAILED))
        except TimeLimitExceeded:
            made.time_out(at, study.time_limit)
        made.arrays["seconds"][at] = time.process_time() - start


def _run_point(system: System, wanted: Sequence[RunMeasure], made: PointArrays, at: int) -> None:
    """Fill in the kept quantities of one run. Raises InputError, RunError."""
    model = system.model(parts=PARTS)
    facts = facts_of(model)
    check_numbers(system, wanted, facts)
    solution = simulate(system, model=model, progress=False)
    values: dict[str, Any] = {}
    for one in wanted:
        try:
            values |= one.compute(solution, facts.numbers)
        except InputError:
            raise
        except Exception as error:  # of a function of the user's own, which may raise anything
            made.fail(at, f"{one.text}: {type(error).__name__}: {error}")
            return
    made.set_point(at, values, solution.energy_error, solution.message, len(solution.doubts))


def _with_section_events(system: System, wanted: Sequence[RunMeasure]) -> System:
    """Return the system with the events of sections added."""
    tables = [one.event_table for one in wanted if isinstance(one, CrossingSection)]
    if not tables:
        return system
    own = [event.model_dump(exclude_none=True) for event in system.scene.events]
    return system.at({"events": [*own, *tables]})
