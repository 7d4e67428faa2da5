"""The spectrum of a live signal against tones whose amplitudes and frequencies are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import rodgen
from rodgen.integrate.stepper import Array
from rodgen.live.catalogue import Catalogue
from rodgen.live.run.curves import ROWS, Window, spectrum
from rodgen.live.run.plot import Plot, PlotSpec
from rodgen.live.samples import Chunk
from rodgen.scene import Scene

# Between two lines, a sixteenth of a bin away, Hann's window loses 1 - sinc(1/16) / (1 - 1/16^2).
LOST = 1 - np.sinc(1 / 16) / (1 - 1 / 16**2)


def peak(rows: Array) -> tuple[float, float]:
    f, amplitude = rows[int(np.argmax(rows[:, 1]))]
    return float(f), float(amplitude)


@pytest.mark.parametrize("f", [1.0, 3.137, 7.77, 20.3])
@pytest.mark.parametrize("phase", [0.0, 1.1])
def test_a_sine_is_a_peak_of_its_amplitude(f: float, phase: float) -> None:
    """Off the mean by far more than the amplitude, and drifting."""
    t = 5.0 + np.arange(1000) * 0.01
    rows = spectrum(t, 40.0 + 3 * t + 0.25 * np.sin(2 * np.pi * f * t + phase))
    found, amplitude = peak(rows)
    # Lines are 1/8 of 1/(10 s) apart; the tone's other half leaks 1/(2 f T)^3 at most.
    leak = 1 / (20 * f) ** 3
    assert found == pytest.approx(f, abs=0.0125 / 2 + leak)
    assert amplitude == pytest.approx(0.25, rel=LOST + leak)


def test_two_tones_keep_their_sizes() -> None:
    t = np.arange(4000) * 0.005
    rows = spectrum(t, np.sin(2 * np.pi * 2.0 * t) + 0.01 * np.cos(2 * np.pi * 9.0 * t))
    small = rows[(rows[:, 0] > 8) & (rows[:, 0] < 10)]
    assert peak(rows) == pytest.approx((2.0, 1.0), rel=1e-4)  # on a line
    # Hann's window falls as the third power: 140 bins away, 1/140^3 of the other.
    assert peak(small) == pytest.approx((9.0, 0.01), rel=1e-3)


def test_mean_and_drift_alone_have_no_peak() -> None:
    t = np.arange(500) * 0.01
    rows = spectrum(t, 1e3 - 7 * t)
    assert rows[:, 1].max() < 1e-10  # rounding of a thousand


def test_a_change_of_sampling_is_evened_out() -> None:
    """Cubics through samples 0.01 s apart miss a tone of 3 Hz by 3/128 (2 pi f h)^4 = 3e-5."""
    t = np.concatenate((np.arange(0, 5, 0.01), np.arange(5, 10, 0.002)))
    rows = spectrum(t, 2.0 * np.sin(2 * np.pi * 3.0 * t))
    assert peak(rows) == pytest.approx((3.0, 2.0), rel=1e-3)
    # A single step, by hand, changes neither the scale nor the peak.
    t = np.insert(np.arange(0, 10, 0.01), 500, 4.9903)
    rows = spectrum(t, 2.0 * np.sin(2 * np.pi * 3.0 * t))
    assert peak(rows) == pytest.approx((3.0, 2.0), rel=1e-3)
    assert rows[-1, 0] == pytest.approx(50.0, rel=0.01)


@pytest.mark.parametrize("samples", [0, 1, 15])
def test_too_little_has_no_spectrum(samples: int) -> None:
    assert spectrum(np.arange(samples) * 0.1, np.ones(samples)).shape == (0, 2)


def test_what_is_not_finite_or_stands_still_has_none() -> None:
    t = np.arange(100) * 0.1
    assert spectrum(t, np.where(t > 5, np.nan, t)).shape == (0, 2)
    assert spectrum(np.zeros(100), t).shape == (0, 2)


def test_many_samples_are_shown_by_their_largest_lines() -> None:
    t = np.arange(16000) * 0.001
    rows = spectrum(t, 0.5 * np.sin(2 * np.pi * 123.4 * t))
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


def test_a_plot_of_a_spectrum_is_made_at_most_four_times_a_second(
    make_scene: Callable[..., Scene],
) -> None:
    scene = make_scene(1, "pinned")
    model = rodgen.build(scene)
    catalogue, now = Catalogue(scene, model), [100.0]
    choice = {"id": "s", "kind": "spectrum", "y": "phi_0", "window": 5}
    plot = Plot(PlotSpec.from_dict(choice, catalogue), catalogue, clock=lambda: now[0])
    t = np.arange(2000) * 0.01
    # 8 rad at 1 Hz for ten seconds, then 3 rad at 4 Hz, which alone is in the window.
    phi = np.where(t < 10, 8 * np.sin(2 * np.pi * t), 3 * np.sin(8 * np.pi * t))
    p = model.parameters(**scene.parameters)
    drawn = []
    for first in range(0, 2000, 2):  # 0.02 s each
        y = np.stack((phi[first : first + 2], np.zeros(2)), axis=1)
        chunk = Chunk(t[first : first + 2], y, np.zeros((2, 0)), (), p)
        assert plot.feed(chunk) is None
        rows = plot.present(chunk)
        if rows is not None:
            drawn.append((now[0], peak(rows)))
        now[0] += 0.02
    times = np.array([at for at, _ in drawn])
    assert 60 < len(times) <= 80  # of 20 s
    assert np.diff(times).min() >= 0.25 - 1e-9
    assert drawn[30][1] == pytest.approx((1.0, 8.0), rel=0.01)
    assert drawn[-1][1] == pytest.approx((4.0, 3.0), rel=0.01)


def test_the_axis_of_a_bar_that_turns_has_no_jumps_in_its_spectrum(
    make_scene: Callable[..., Scene],
) -> None:
    """Its angle grows evenly, but for a tone of 0.1 rad; jumps of pi would be peaks of 1 rad."""
    scene = make_scene(1, "pinned")
    model = rodgen.build(scene)
    catalogue = Catalogue(scene, model)
    choice = {"id": "s", "kind": "spectrum", "y": "principal_angle"}
    plot = Plot(PlotSpec.from_dict(choice, catalogue), catalogue)
    t = np.arange(1000) * 0.01
    y = np.stack((3 * t + 0.1 * np.sin(2 * np.pi * 5 * t), np.zeros(1000)), axis=1)
    chunk = Chunk(t, y, np.zeros((1000, 0)), (), model.parameters(**scene.parameters))
    rows = plot.backlog([chunk])
    assert peak(rows) == pytest.approx((5.0, 0.1), rel=1e-4)  # on a line
