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
from rodgen_live.grid_recorder import Samples
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.run.change_marks import ChangeMark
from rodgen_live.run.message import Named, Trail, encode, pull_array, rod_arrays
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
    samples = [sample for chunk in store.chunks() for sample in _single_samples(chunk)]
    if len(samples) < LEAST or not all(np.isfinite(sample.y).all() for sample in samples):
        raise InputError("run", solution.status, "one of two samples or more, all of them finite")
    span = float(samples[-1].t[0] - samples[0].t[0])
    plots = [
        _make_plot({**choice, "window": span}, k, catalogue) for k, choice in enumerate(choices)
    ]
    shown = _evenly_spaced_samples(samples, solution)
    times = [float(sample.t[0]) for sample in shown]
    line = {"from": times[0], "to": times[-1], "count": len(times), "keeps": False}

    def message(sample: Chunk, arrays: Sequence[Named], **more: Any) -> bytes:
        t = float(sample.t[0])
        origin, places = rod_arrays(solution.model, sample)
        header = {"t": t, "origin": origin, "begun": BEGUN, "line": {**line, "past": t, **more}}
        pull = pull_array(solution.model, solution.system, sample, origin)
        return encode(header, [*places, pull, *arrays])

    whole = [plot for plot in plots if plot.spec.kind != "profile"]
    standing = [(f"plot!{plot.spec.id}", plot.backlog(store.chunks()).ravel()) for plot in whole]
    standing += _profile_arrays(plots, shown[0])
    trail = ("trail!", Trail().pop(solution.model, store).ravel())
    first = message(shown[0], [trail, *standing], marks=_marks(solution, store))
    frames = [message(sample, list(_profile_arrays(plots, sample))) for sample in shown]
    return Replay([plot.to_json() for plot in plots], first, frames, times)


def _fill_store(solution: Solution) -> SampleStore:
    """Store the samples of a run as the live view keeps them."""
    model, work = solution.model, tuple(solution.work)
    p, changes = solution.system.p, solution.changes
    every = changes.p if changes is not None else np.broadcast_to(p, (len(solution.t), len(p)))
    given = np.broadcast_to(solution.energy_input, solution.t.shape)
    with np.errstate(all="ignore"):
        start = float(sum(call_module(model, "energy", solution.t[0], solution.y[0], every[0])))
    store = SampleStore(solution.y.shape[1], work, start)
    works = np.zeros((len(solution.t), len(work)))
    for k, term in enumerate(work):
        works[:, k] = solution.work[term]
    changed = np.any(every[1:] != every[:-1], axis=1) | (given[1:] != given[:-1])
    edges = [0, *(np.flatnonzero(changed) + 1).tolist(), len(solution.t)]
    for a, b in itertools.pairwise(edges):
        store.set_parameters(every[a], float(given[a]))
        store.add(Samples(solution.t[a:b], solution.y[a:b], works[a:b]))
    return store


def _single_samples(chunk: Chunk) -> Iterator[Chunk]:
    return (chunk.select(slice(k, k + 1)) for k in range(len(chunk)))


def _evenly_spaced_samples(samples: Sequence[Chunk], solution: Solution) -> list[Chunk]:
    """Pick evenly spaced samples, as many as there is room for."""
    size = len(encode({}, rod_arrays(solution.model, samples[0])[1]))
    most = min(len(samples), MOST, max(LEAST, ROOM // size))
    return [samples[k] for k in np.linspace(0, len(samples) - 1, most).round().astype(int)]


def _make_plot(choice: dict[str, Any], number: int, catalogue: Catalogue) -> Plot:
    spec = PlotSpec.from_dict({**choice, "id": f"p{number}"}, catalogue)
    return Plot(spec, catalogue)


def _profile_arrays(plots: Iterable[Plot], sample: Chunk) -> Iterator[Named]:
    """Arrays of the profiles among the plots at one sample."""
    for plot in plots:
        if plot.spec.kind == "profile" and (rows := plot.current_rows(sample)) is not None:
            yield f"plot!{plot.spec.id}", rows.ravel()


def _change_chunks(solution: Solution, store: SampleStore) -> Iterator[Chunk]:
    """Chunks that begin with a change or a kick; moving the far end of a pull is none."""
    places = solution.system.structure.slices
    far = [places[name] for name in ("support_x", "support_y") if name in places]

    def comparison_key(chunk: Chunk) -> tuple[bytes, float]:
        p = chunk.p.copy()
        for place in far:
            p[place] = 0.0
        return p.tobytes(), chunk.given

    for before, chunk in itertools.pairwise(store.chunks()):
        if comparison_key(before) != comparison_key(chunk):
            yield chunk


def _marks(solution: Solution, store: SampleStore) -> list[ChangeMark]:
    """Marks at events, and where values were changed or the rod was kicked."""
    events = [ChangeMark(event.t, event.name) for event in solution.events]
    begin = (float(chunk.t[0]) for chunk in _change_chunks(solution, store))
    changes = [ChangeMark(t, "a change or a kick") for t in begin]
    return sorted(events + changes)
