"""What is kept of a run: the whole of it, in bounded memory, each sample with its parameters."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from rodgen.integrate.live import Samples
from rodgen.live.samples import MOST, Store


def _samples(first: int, last: int, states: int = 4) -> Samples:
    """Samples whose every number tells which one it is."""
    t = np.arange(first, last, dtype=float)
    return Samples(t, np.repeat(t[:, None], states, axis=1), t[:, None] * 10)


def test_all_samples_come_back_with_their_parameters() -> None:
    store = Store(4, ("follower",), start=3.0)
    store.change(np.array([1.0]), 0.0)
    store.add(_samples(0, 10))
    store.change(np.array([2.0]), 0.5)
    store.add(_samples(10, 15))
    first, second = store.chunks()
    assert first.t.tolist() == list(range(10))
    assert (first.p.tolist(), first.given, first.start) == ([1.0], 0.0, 3.0)
    assert second.y[:, 3].tolist() == list(range(10, 15))
    assert second.work[:, 0].tolist() == [100, 110, 120, 130, 140]
    assert (second.p.tolist(), second.given) == ([2.0], 0.5)


@pytest.mark.parametrize("at_once", [1, 7, 1000, 3 * MOST])
def test_full_store_keeps_evenly_spread_samples_from_start_to_end(at_once: int) -> None:
    store, total = Store(4, (), start=0.0), 5 * MOST + 3 if at_once > 5 else 2 * MOST + 3
    store.change(np.array([1.0]), 0.0)
    for first in range(0, total, at_once):
        last = min(first + at_once, total)
        samples = _samples(first, last)
        store.add(Samples(samples.t, samples.y, np.empty((len(samples.t), 0))))
    t = np.concatenate([chunk.t for chunk in store.chunks()])
    assert len(t) <= MOST
    assert t[0] == 0.0
    assert len(set(np.diff(t))) == 1  # every so-manieth, no gap
    assert total - t[-1] <= np.diff(t)[0]


def test_changes_without_end_cost_no_memory() -> None:
    """A slider that is dragged for hours: what no sample needs is forgotten."""
    store = Store(2, (), start=0.0)
    for k in range(3 * MOST):
        store.change(np.array([float(k)]), 0.0)
        store.add(Samples(np.array([float(k)]), np.full((1, 2), float(k)), np.empty((1, 0))))
    assert len(store._epochs) <= MOST + 1
    assert all(chunk.p[0] == chunk.t[0] for chunk in store.chunks())


def test_few_of_many_parameters_that_change_cost_little() -> None:
    """A pull that is moved, of a rod whose module has thousands of parameters: two of them change
    with every sample. Then all do."""
    many, count = 4000, 3000
    p = np.arange(float(many))
    tracemalloc.start()
    store = Store(2, (), start=0.0)
    for k in range(count):
        p[[7, 3000]] = k, -k
        store.change(p, 0.0)
        store.add(Samples(np.array([float(k)]), np.full((1, 2), float(k)), np.empty((1, 0))))
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    store.change(-p, 0.5)
    store.add(Samples(np.array([float(count)]), np.zeros((1, 2)), np.empty((1, 0))))
    assert held < 0.1 * 8 * many * count
    *moved, last = store.chunks()
    for k, chunk in enumerate(moved):
        assert (chunk.p[7], chunk.p[3000], chunk.p[8]) == (k, -k, 8.0)
    np.testing.assert_array_equal(last.p, -p)


def test_what_comes_after_a_time_is_dropped() -> None:
    store = Store(4, ("follower",), start=0.0)
    for number, first in enumerate((0, 10, 20)):
        store.change(np.array([float(number)]), 0.0)
        store.add(_samples(first, first + 10))
    last = store.back_to(14.5)
    assert (last.t.tolist(), last.p.tolist()) == ([14.0], [1.0])
    store.change(np.array([5.0]), 0.0)
    store.add(_samples(30, 32))
    found = [(chunk.t.tolist(), chunk.p[0]) for chunk in store.chunks()]
    times = [list(range(10)), list(range(10, 15)), [30, 31]]
    assert found == list(zip(times, (0.0, 1.0, 5.0), strict=True))
    assert store.back_to(-1.0).t == [0.0]  # something is always shown


def test_sample_is_found_by_its_time_and_by_its_neighbours() -> None:
    store = Store(4, ("follower",), start=0.0)
    store.change(np.array([1.0]), 0.0)
    store.add(_samples(0, 10))
    store.change(np.array([2.0]), 0.5)
    store.add(_samples(10, 15))
    assert store.span == (0.0, 14.0)
    for t, by, found in ((3.4, 0, 3), (3.6, 0, 4), (3.6, -1, 3), (-5, 0, 0), (99, 0, 14)):
        near = store.near(t, by)
        assert near.t.tolist() == [found]
        assert near.y[0, 3] == found
    assert store.near(2.0, -7).t[0] == 0.0  # the ends hold
    assert store.near(13.0, 7).t[0] == 14.0
    assert (store.near(9.2).p[0], store.near(9.2, 1).p[0]) == (1.0, 2.0)
