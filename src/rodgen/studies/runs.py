"""Points of which a scene is run: in vector lanes of C where that is possible, else one by one."""

from __future__ import annotations

import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.crossings import Crossing
from rodgen.integrate.diagnosis import doubt_counts
from rodgen.integrate.endings import FAILED
from rodgen.integrate.equations import Equations, equations_of
from rodgen.integrate.many import goes_side_by_side, watched_many
from rodgen.integrate.methods.choose import choose, choose_from
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import RunError
from rodgen.studies.axis import Axis
from rodgen.studies.block_arrays import Made
from rodgen.studies.keep import PARTS, check_numbers, kept
from rodgen.studies.measures import Count, Kept, Own, Peak, Sampled, Section, crossing_of
from rodgen.studies.point_batch import PointBatch, groups, slot_names
from rodgen.studies.points import Point
from rodgen.studies.reference import reference
from rodgen.studies.time_limit import TooLong, time_limit
from rodgen.studies.variable import METHOD
from rodgen.system import System

if TYPE_CHECKING:
    from rodgen.studies.study import Study

MOST_CROSSED = 2**22  # numbers of crossings and samples that are kept at once
MOST_CORNERED = 4  # varied numbers of which all ends are tried with each other, else one by one
FEW = 3  # points of a group whose scenes are made sooner than what they share is found


def compute(study: Study, points: list[Point], made: Made) -> None:
    """Fill in what is kept of a run of every point."""
    wanted = kept(study)
    if not any(isinstance(one, Own) for one in wanted):
        _together(study, points, made, wanted)
    else:
        _one_by_one(study, points, range(len(points)), made, wanted)


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


def _together(study: Study, points: list[Point], made: Made, wanted: tuple[Kept, ...]) -> None:
    names = _slot_names(study)
    others = tuple(name for axis in study.axes if (name := axis.name) not in names)
    batches: dict[Any, _Batch] = {}

    def batch(system: System) -> _Batch:
        events = tuple(event.model_dump_json() for event in system.events)
        key = system.structure, system.settings.model_dump_json(), events
        return batches.setdefault(key, _Batch(system))

    start = time.process_time()
    for shared, members in groups(points, others):
        share = _share(study, tuple(shared.items())) if len(members) > FEW else None
        left = members
        usual = _method(study, tuple(shared.items()))
        if share is not None:
            p, y, taken = share.rows([points[at] for at in members])
            rows = np.flatnonzero(taken)
            for method, some in _by_method(share, usual, p, y, rows).items():
                ready = [members[row] for row in some]
                batch(share.system.integrated_by(method)).add(ready, p[some], y[some])
            left = [at for at, is_taken in zip(members, taken, strict=True) if not is_taken]
        for at in left:
            try:
                system = study.system_at(points[at])
                chosen = system.integrated_by(usual or _choice(system))
                batch(chosen).add([at], system.p[None], system.y0[None])
            except InputError as error:
                made.fail(at, str(error))
    made.arrays["seconds"][:] = (time.process_time() - start) / max(1, len(points))
    for one in batches.values():
        made.arrays[METHOD.name][one.points] = one.system.settings.method
        try:
            _run(study, one, points, made, wanted)
        except InputError as error:
            for at in one.points:
                made.fail(at, str(error))


def _run(
    study: Study, batch: _Batch, points: list[Point], made: Made, wanted: tuple[Kept, ...]
) -> None:
    """Runs of a batch, in lanes if they can be. Raises InputError."""
    system = _watching(batch.system, wanted)
    model = system.model(parts=PARTS)
    equations, settings = equations_of(model), system.settings.used
    check_numbers(system, (number for one in wanted for number in one.numbers), equations)
    texts = [one.text for one in wanted if isinstance(one, Sampled)]
    crossings, crossing = _crossings(system, wanted, equations)
    peaks = [one for one in wanted if isinstance(one, Peak)]
    more: dict[str, Any] = {"crossings": crossings, "traced": [one.number for one in peaks]}
    if (crossings or peaks) and not goes_side_by_side(model, texts, **more, **settings):
        _one_by_one(study, points, batch.points, made, wanted)
        return
    p, y = np.concatenate(batch.p), np.concatenate(batch.y)
    width = 1 + sum(one.width for one in crossings) + len(peaks) * len(system.settings.samples)
    for few in np.array_split(np.arange(len(p)), -(-len(p) * width // MOST_CROSSED)):
        start, at = time.process_time(), np.array(batch.points)[few]
        limit = study.time_limit and study.time_limit * len(few)
        try:
            with time_limit(limit, system):
                found = watched_many(model, p[few], y[few], keep=texts, **more, **settings)
        except TooLong:  # some of them, or one
            _one_by_one(study, points, at.tolist(), made, wanted)
            continue
        values: dict[str, Any] = {text: found[text] for text in texts}
        for one, number in crossing:
            values |= one.of_many(found.crossed[number], equations, p[few])
        for number, peak in enumerate(peaks):
            values |= peak.of_many(found, number)
        doubts = doubt_counts(batch.system, model, p[few], y[few])
        made.set_many(at, values, found.energy_error, found.status, found.message, doubts)
        shares = np.maximum(found.nfev, 1)
        made.arrays["seconds"][at] += (time.process_time() - start) * shares / shares.sum()


def _crossings(
    system: System, wanted: tuple[Kept, ...], equations: Equations
) -> tuple[list[Crossing], list[tuple[Count | Section, int]]]:
    """What runs of a system look out for, and of which of it what is kept is made."""
    found = [
        replace(crossing_of(event), stop=event.name)
        for event in system.events
        if event.action == "stop"
    ]
    made: list[tuple[Count | Section, int]] = []
    events = {event.name: event for event in system.events}
    for one in wanted:
        if isinstance(one, Count | Section):
            made.append((one, len(found)))
            found.append(one.crossing(events[one.event], equations))
    return found, made


@lru_cache(maxsize=8)
def _slot_names(study: Study) -> tuple[str, ...]:
    return slot_names(study)


@lru_cache(maxsize=512)
def _share(study: Study, shared: tuple[tuple[str, Any], ...]) -> PointBatch | None:
    """How points with these values in common are made together, where they can be."""
    try:
        return PointBatch.of(study, reference(study) | dict(shared), _slot_names(study))
    except InputError:
        return None


@lru_cache(maxsize=512)
def _method(study: Study, shared: tuple[tuple[str, Any], ...]) -> str:
    """The method of all points that have these values in common, where `auto` finds the same at
    all ends of what is put into them; empty where it does not. So it depends on what the study
    is, and not on which of its points are asked for."""
    given = reference(study) | dict(shared)
    names = [name for name in _slot_names(study) if name not in dict(shared)]
    ends = {axis.name: _ends(axis) for axis in study.axes if axis.name in names}
    if len(ends) <= MOST_CORNERED:
        tried = [dict(zip(ends, values, strict=True)) for values in product(*ends.values())]
    else:
        tried = [{name: value} for name, both in ends.items() for value in both]
    found = set()
    for changes in ({}, *tried):
        with suppress(InputError):  # of a point that is not in the study, or fails in its turn
            found.add(_choice(study.system_at(given | changes)))
        if len(found) > 1:
            return ""
    return found.pop() if found else ""


def _ends(axis: Axis) -> tuple[Any, Any]:
    """The smallest and the largest value."""
    return (min(axis.values), max(axis.values)) if len(axis.values) else (axis.low, axis.high)


def _by_method(
    share: PointBatch, method: str, p: Array, y: Array, rows: NDArray[np.intp]
) -> dict[str, NDArray[np.intp]]:
    """Rows of p and y0 by the method that runs them: by one for all, or each by its own."""
    if method:
        return {method: rows}
    settings, model = share.system.settings, share.system.model(parts=PARTS)
    found = np.array([choose_from(settings, model, p[row], y[row]).method for row in rows])
    return {str(name): rows[found == name] for name in dict.fromkeys(found.tolist())}


def _choice(system: System) -> str:
    return choose(system, system.model(parts=PARTS)).method


# One by one ---------------------------------------------------------------------------------------


def _one_by_one(
    study: Study,
    points: list[Point],
    places: Iterable[int],
    made: Made,
    wanted: tuple[Kept, ...],
) -> None:
    """Runs of the points at some places, by `simulate`."""
    names = _slot_names(study)
    others = [axis.name for axis in study.axes if axis.name not in names]
    for at in places:
        start, point = time.process_time(), points[at]
        shared = tuple((name, point[name]) for name in others)
        try:
            system = study.system_at(point)
            system = system.integrated_by(_method(study, shared) or _choice(system))
            made.arrays[METHOD.name][at] = system.settings.method
            with time_limit(study.time_limit, system):
                _keep(_watching(system, wanted), wanted, made, at)
        except (InputError, RunError) as error:
            made.fail(at, str(error), getattr(error, "status", FAILED))
        except TooLong:
            made.stop(at, study.time_limit)
        made.arrays["seconds"][at] = time.process_time() - start


def _keep(system: System, wanted: tuple[Kept, ...], made: Made, at: int) -> None:
    """Fill in what is kept of one run. Raises InputError, RunError."""
    model = system.model(parts=PARTS)
    equations = equations_of(model)
    check_numbers(system, (number for one in wanted for number in one.numbers), equations)
    solution = simulate(system, model=model, progress=False)
    values: dict[str, Any] = {}
    for one in wanted:
        try:
            values |= one.of(solution, equations.numbers)
        except InputError:
            raise
        except Exception as error:  # of a function of the user's own, which may raise anything
            made.fail(at, f"{one.text}: {type(error).__name__}: {error}")
            return
    made.set(at, values, solution.energy_error, solution.message, len(solution.doubts))


def _watching(system: System, wanted: tuple[Kept, ...]) -> System:
    """The system that looks out for the crossings of sections, too."""
    tables = [one.table for one in wanted if isinstance(one, Section)]
    if not tables:
        return system
    own = [event.model_dump(exclude_none=True) for event in system.events]
    return system.at({"events": [*own, *tables]})
