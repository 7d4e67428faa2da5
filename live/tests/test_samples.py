"""What is kept of a run, in bounded memory, and the spectrum of what is kept."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

from rodgen.arrays import Array
from rodgen_live import sample_store
from rodgen_live.run.plot import Plot, PlotSpec
from rodgen_live.run.sample_curves import ROWS, Window, spectrum
from rodgen_live.sample_store import MOST, Chunk, SampleStore

FEW = 500  # samples that are kept at most, in place of MOST


def _samples(first: int, last: int, *p: float, given: float = 0.0) -> Chunk:
    """Samples whose every number tells which one it is, with these parameters."""
    t = np.arange(first, last, dtype=float)
    y = np.repeat(t[:, None], 4, axis=1)
    return Chunk(t, y, t[:, None] * 10, ("follower",), np.array(p), given, start=3.0)


def filled(*parts: tuple[int, int, float, float]) -> SampleStore:
    """Samples from ... to, with a parameter and an energy that was given."""
    store = SampleStore()
    for first, last, p, given in parts:
        store.add(_samples(first, last, p, given=given))
    return store


@pytest.mark.parametrize("at_once", [1, 7, 100, 3 * FEW])
def test_full_store_keeps_evenly_spread_samples_from_start_to_end(
    monkeypatch: pytest.MonkeyPatch, at_once: int
) -> None:
    monkeypatch.setattr(sample_store, "MOST", FEW)
    store, total = SampleStore(), 5 * FEW + 3
    for first in range(0, total, at_once):
        store.add(_samples(first, min(first + at_once, total)))
    t = np.concatenate([chunk.t for chunk in store.chunks()])
    assert len(t) <= FEW < MOST
    assert t[0] == 0.0
    assert len(set(np.diff(t))) == 1  # every so-manieth, no gap
    assert total - t[-1] <= np.diff(t)[0]


def test_changes_without_end_cost_no_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """A slider that is dragged for hours: what no sample needs is forgotten."""
    monkeypatch.setattr(sample_store, "MOST", FEW)
    store = filled(*((k, k + 1, float(k), 0.0) for k in range(3 * FEW)))
    assert len(store._epochs) <= FEW + 1
    assert all(chunk.p[0] == chunk.t[0] for chunk in store.chunks())


def test_few_of_many_parameters_that_change_cost_little() -> None:
    """A pull that is moved, of a rod whose module has thousands of parameters: two of them change
    with every sample. Then all do."""
    many, count = 4000, 500
    p = np.arange(float(many))
    tracemalloc.start()
    store = SampleStore()
    for k in range(count):
        p[[7, 3000]] = k, -k
        store.add(_samples(k, k + 1, *p))
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    store.add(_samples(count, count + 1, *-p, given=0.5))
    assert held < 0.1 * 8 * many * count
    *moved, last = store.chunks()
    for k, chunk in enumerate(moved):
        assert (chunk.p[7], chunk.p[3000], chunk.p[8]) == (k, -k, 8.0)
    np.testing.assert_array_equal(last.p, -p)


def test_what_comes_after_a_time_is_dropped() -> None:
    store = filled(*((10 * k, 10 * k + 10, float(k), 0.0) for k in range(3)))
    last = store.truncate(14.5)
    assert (last.t.tolist(), last.p.tolist(), last.start) == ([14.0], [1.0], 3.0)
    assert (last.y[0, 3], last.work[0, 0]) == (14.0, 140.0)
    store.add(_samples(30, 32, 5.0))
    found = [(chunk.t.tolist(), chunk.p[0]) for chunk in store.chunks()]
    times = [list(range(10)), list(range(10, 15)), [30, 31]]
    assert found == list(zip(times, (0.0, 1.0, 5.0), strict=True))
    assert store.truncate(-1.0).t == [0.0]  # something is always shown


def test_sample_is_found_by_its_time_and_by_its_neighbours() -> None:
    """The ends hold."""
    store = filled((0, 10, 1.0, 0.0), (10, 15, 2.0, 0.5))
    assert store.span == (0.0, 14.0)
    for t, by, found in (
        *((3.4, 0, 3), (3.6, 0, 4), (3.6, -1, 3), (-5, 0, 0), (99, 0, 14)),
        *((2.0, -7, 0), (13.0, 7, 14)),
    ):
        near = store.nearest(t, by)
        assert near.t.tolist() == [found]
        assert near.y[0, 3] == found
    assert (store.nearest(9.2).p[0], store.nearest(9.2, 1).p[0]) == (1.0, 2.0)


# Between two lines, a sixteenth of a bin away, Hann's window loses 1 - sinc(1/16) / (1 - 1/16^2).
LOST = 1 - np.sinc(1 / 16) / (1 - 1 / 16**2)


def peak(rows: Array) -> tuple[float, float]:
    f, amplitude = rows[int(np.argmax(rows[:, 1]))]
    return float(f), float(amplitude)


def tone(t: Array, f: float, amplitude: float, phase: float = 0.0) -> Array:
    return amplitude * np.sin(2 * np.pi * f * t + phase)


def test_a_sine_is_a_peak_of_its_amplitude() -> None:
    """Off the mean by far more than the amplitude, and drifting."""
    t = 5.0 + np.arange(1000) * 0.01
    for f in (1.0, 3.137, 7.77, 20.3):
        for phase in (0.0, 1.1):
            found, amplitude = peak(spectrum(t, 40.0 + 3 * t + tone(t, f, 0.25, phase)))
            # Lines are 1/8 of 1/(10 s) apart; the tone's other half leaks 1/(2 f T)^3 at most.
            leak = 1 / (20 * f) ** 3
            assert found == pytest.approx(f, abs=0.0125 / 2 + leak)
            assert amplitude == pytest.approx(0.25, rel=LOST + leak)
    assert spectrum(t, 1e3 - 7 * t)[:, 1].max() < 1e-10  # rounding of a thousand


def test_a_change_of_sampling_is_evened_out() -> None:
    """Cubics through samples 0.01 s apart miss a tone of 3 Hz by 3/128 (2 pi f h)^4 = 3e-5. A
    single step, by hand, changes neither the scale nor the peak."""
    finer = np.concatenate((np.arange(0, 5, 0.01), np.arange(5, 10, 0.002)))
    stepped = np.insert(np.arange(0, 10, 0.01), 500, 4.9903)
    for t in (finer, stepped):
        rows = spectrum(t, tone(t, 3.0, 2.0))
        assert peak(rows) == pytest.approx((3.0, 2.0), rel=1e-3)
    assert rows[-1, 0] == pytest.approx(50.0, rel=0.01)


def test_what_is_too_little_not_finite_or_stands_still_has_none() -> None:
    t = np.arange(100) * 0.1
    few = [(np.arange(count) * 0.1, np.ones(count)) for count in (0, 1, 15)]
    for times, x in (*few, (t, np.where(t > 5, np.nan, t)), (np.zeros(100), t)):
        assert spectrum(times, x).shape == (0, 2)


def test_many_samples_are_shown_by_their_largest_lines() -> None:
    t = np.arange(16000) * 0.001
    rows = spectrum(t, tone(t, 123.4, 0.5))
    assert len(rows) <= ROWS
    assert (np.diff(rows[:, 0]) > 0).all()
    assert peak(rows) == pytest.approx((123.4, 0.5), rel=LOST)


def test_a_window_holds_its_seconds() -> None:
    window = Window(2.0)
    for first in range(0, 1000, 7):
        t = np.arange(first, min(first + 7, 1000)) * 0.01
        window.feed(t, t**2)
    np.testing.assert_allclose(window.t, np.arange(799, 1000) * 0.01)
    np.testing.assert_array_equal(window.x, window.t**2)
    window.feed(np.array([0.5]), np.array([1.0]))  # the run has started again
    assert window.t.tolist() == [0.5]


def test_a_plot_of_a_spectrum_is_made_at_most_four_times_a_second(bar: Any, clock: Any) -> None:
    catalogue, chunk = bar
    choice = {"id": "s", "kind": "spectrum", "y": "phi_0", "window": 2}
    plot = Plot(PlotSpec.from_dict(choice, catalogue), catalogue, clock=clock)
    t = np.arange(800) * 0.01
    # 8 rad at 4 Hz for four seconds, then 3 rad at 10 Hz, in the end alone in the window.
    phi = np.where(t < 4, tone(t, 4.0, 8.0), tone(t, 10.0, 3.0))
    whole, drawn = chunk(t, np.stack((phi, np.zeros(800)), axis=1)), []
    for first in range(0, 800, 2):  # 0.02 s each
        part = whole.select(slice(first, first + 2))
        assert plot.feed(part) is None
        rows = plot.current_rows(part)
        if rows is not None:
            drawn.append((clock.now, peak(rows)))
        clock.now += 0.02
    times = np.array([at for at, _ in drawn])
    assert 24 < len(times) <= 32  # of 8 s
    assert np.diff(times).min() >= 0.25 - 1e-9
    before = max(at for at, time in enumerate(times) if time < 104.0)
    assert drawn[before][1] == pytest.approx((4.0, 8.0), rel=0.01)
    assert drawn[-1][1] == pytest.approx((10.0, 3.0), rel=0.01)


def test_the_axis_of_a_bar_that_turns_has_no_jumps_in_its_spectrum(bar: Any) -> None:
    """Its angle grows evenly, but for a tone of 0.1 rad; jumps of pi would be peaks of 1 rad."""
    catalogue, chunk = bar
    choice = {"id": "s", "kind": "spectrum", "y": "principal_angle"}
    plot = Plot(PlotSpec.from_dict(choice, catalogue), catalogue)
    t = np.arange(1000) * 0.01
    y = np.stack((3 * t + tone(t, 5.0, 0.1), np.zeros(1000)), axis=1)
    assert peak(plot.backlog([chunk(t, y)])) == pytest.approx((5.0, 0.1), rel=1e-4)  # on a line
