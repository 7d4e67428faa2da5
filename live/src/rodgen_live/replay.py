"""A recorded run as messages to a page: what the live view would send, sample by sample."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rodgen.errors import InputError
from rodgen.integrate.solution import Solution
from rodgen.loading.generated_module import call_module
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.run.change_history import ChangeMark
from rodgen_live.run.message import Named, encode, pull_array, rod_arrays, trail_so_far
from rodgen_live.run.plot import Plot
from rodgen_live.run.plot_spec import PlotSpec
from rodgen_live.sample_store import Chunk, SampleStore

MOST, ROOM = 1500, 12_000_000  # samples that are shown, bytes of all of them
LEAST = 2  # samples, for a time line
BEGUN = 1  # number of the run, as there is one


@dataclass(frozen=True)
class Replay:
    """Messages of a recorded run. plots: as the page has them; first: the message with trail, marks
    and whole plots; frames: those of the samples that are shown; times: of each [s]."""

    plots: list[dict[str, Any]]
    first: bytes
    frames: list[bytes]
    times: list[float]


def replay(solution: Solution, choices: Iterable[dict[str, Any]]) -> Replay:
    """Convert a run to messages; choices: its plots (see PlotSpec.from_dict). Raises InputError for
    a run of a single sample, or with states that are not finite."""
    store, catalogue = _fill_store(solution), Catalogue(solution.system, solution.model)
    samples = [chunk.select(slice(k, k + 1)) for chunk in store.chunks() for k in range(len(chunk))]
    if len(samples) < LEAST or not all(np.isfinite(sample.y).all() for sample in samples):
        raise InputError("run", solution.status, "one of two samples or more, all of them finite")
    span = float(samples[-1].t[0] - samples[0].t[0])
    given = ({**choice, "window": span, "id": f"p{k}"} for k, choice in enumerate(choices))
    plots = [Plot(PlotSpec.from_dict(choice, catalogue), catalogue) for choice in given]
    # Evenly spaced ones, as many as there is room for.
    size = len(encode({}, rod_arrays(solution.model, solution.system, samples[0])[1]))
    most = min(len(samples), MOST, max(LEAST, ROOM // size))
    shown = [samples[k] for k in np.linspace(0, len(samples) - 1, most).round().astype(int)]
    times = [float(sample.t[0]) for sample in shown]
    line = {"from": times[0], "to": times[-1], "count": len(times), "keeps": False}

    def message(sample: Chunk, arrays: Sequence[Named], **more: Any) -> bytes:
        t = float(sample.t[0])
        origin, places = rod_arrays(solution.model, solution.system, sample)
        header = {"t": t, "origin": origin, "begun": BEGUN, "line": {**line, "past": t, **more}}
        pull = pull_array(solution.model, solution.system, sample, origin)
        return encode(header, [*places, pull, *arrays])

    whole = [plot for plot in plots if plot.spec.kind != "profile"]
    standing = [(f"plot!{plot.spec.id}", plot.backlog(store.chunks()).ravel()) for plot in whole]
    standing += _profile_arrays(plots, shown[0])
    trail = ("trail!", trail_so_far(solution.model, store).ravel())
    first = message(shown[0], [trail, *standing], marks=_marks(solution, store))
    frames = [message(sample, list(_profile_arrays(plots, sample))) for sample in shown]
    return Replay([plot.to_json() for plot in plots], first, frames, times)


def _fill_store(solution: Solution) -> SampleStore:
    model, work = solution.model, tuple(solution.work)
    p, changes = solution.system.p, solution.changes
    every = changes.p if changes is not None else np.broadcast_to(p, (len(solution.t), len(p)))
    given = np.broadcast_to(solution.energy_input, solution.t.shape)
    with np.errstate(all="ignore"):
        start = call_module(model, "energy", solution.t[0], solution.y[0], every[0])
    store = SampleStore()
    works = np.reshape([*solution.work.values()], (len(work), len(solution.t))).T
    changed = np.any(every[1:] != every[:-1], axis=1) | (given[1:] != given[:-1])
    edges = [0, *(np.flatnonzero(changed) + 1).tolist(), len(solution.t)]
    for a, b in itertools.pairwise(edges):
        t, y, held = solution.t[a:b], solution.y[a:b], (every[a], float(given[a]))
        store.add(Chunk(t, y, works[a:b], work, *held, float(sum(start)), float(start[-1])))
    return store


def _profile_arrays(plots: Iterable[Plot], sample: Chunk) -> Iterator[Named]:
    for plot in plots:
        if plot.spec.kind == "profile" and (rows := plot.current_rows(sample)) is not None:
            yield f"plot!{plot.spec.id}", rows.ravel()


def _marks(solution: Solution, store: SampleStore) -> list[ChangeMark]:
    """Marks at events, and where values were changed or the rod was kicked; that the far end of a
    pull is moved is none."""
    places = solution.system.structure.slices
    far = np.zeros(len(solution.system.p), dtype=bool)
    for name in ("support_x", "support_y"):
        far[places.get(name, slice(0))] = True
    marks = [ChangeMark(event.t, event.name) for event in solution.events]
    for before, chunk in itertools.pairwise(store.chunks()):
        differ = before.p != chunk.p
        if not differ.any() or (differ & ~far).any():
            marks.append(ChangeMark(float(chunk.t[0]), "a change or a kick"))
    return sorted(marks)
