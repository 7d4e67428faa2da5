"""Frequencies of simulations against the eigenvalues of their modules, and of known tones."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

import rodgen
from rodgen.analyse.spectrum import WINDOWS, find_peaks, spectrum
from rodgen.errors import AnalysisError
from rodgen.scene import Scene
from tests.analyse.rods import jacobian, rod
from tests.told import numbers

SMALL = "1e-4*cos(pi*s) + 1e-4*s**3"  # rad: symmetric and antisymmetric, products of 1e-8


@lru_cache
def _run(boundary: str, phi: str = SMALL, seconds: float = 2.1, every: float = 0.004, **more: Any):
    initial = {key: list(v) if isinstance(v, tuple) else v for key, v in more.items()}
    sizes = {"length": 2.0, "bending_stiffness": 30.0, "mass": 3.0}
    integrate = {"span": [0.0, seconds], "rtol": 1e-8, "atol": 1e-13, "output_every": every}
    scene = rod(4, boundary, **sizes, initial={"phi": phi} | initial, integrate=integrate)
    return rodgen.simulate(scene, target="numpy")


def _frequencies(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Natural frequencies [Hz] and mode shapes at y = 0, from the generated mass matrix and
    Jacobian: stiffness is -M dv'/dq."""
    model = rodgen.build(scene, "numpy")
    p, y = model.parameters(**scene.parameters), np.zeros(len(model.STATE))
    half = len(y) // 2
    M = model.mass_matrix(y, p)
    K = -M @ jacobian(scene, y)[half:, :half]
    squares, shapes = eigh((K + K.T) / 2, M)
    return np.sqrt(np.abs(squares)) / (2 * np.pi), shapes


def test_free_rod_shows_symmetric_and_antisymmetric_modes() -> None:
    found = spectrum(_run("free"))
    exact, shapes = _frequencies(_run("free").scene)
    bending = exact > 0.1
    # Eight periods of the first, and the errors of steps with rtol 1e-8.
    np.testing.assert_allclose(found.frequencies[:3], exact[bending][:3], rtol=1e-6)
    assert len(found.frequencies) == bending.sum() == 3
    angles = shapes[2:, bending].T
    parity = [np.sign((a * a[::-1]).sum()) for a in angles]  # +1: angles even, shape antisymmetric
    assert parity == [-1, 1, -1]


@pytest.mark.parametrize("boundary", ["clamped", pytest.param("pinned", marks=pytest.mark.slow)])
def test_held_rod(boundary: str) -> None:
    """The first bending mode of a clamp is slower than two seconds show; the others are there."""
    found = spectrum(_run(boundary, "1e-4*s**2"))
    exact, _ = _frequencies(_run(boundary, "1e-4*s**2").scene)
    seen = exact[exact > found.resolution * 1.3]
    # The slowest is near its own image at -f and near the mode that is not seen.
    np.testing.assert_allclose(found.frequencies, seen, rtol=3e-5)
    with pytest.raises(AnalysisError, match=r"\b0\.5 Hz.*\b8\b.*\b16 s"):
        spectrum(_run(boundary, "1e-4*s**2"), lowest=0.5)


def test_rod_that_tumbles_and_flies() -> None:
    """The local frame takes translation and rotation away, half turns of the axis included; a
    rotation changes a squared frequency by about its own square, here (2/25)^2 of the first."""
    motion = _run("free", "2.0 + " + SMALL, omega=2.0, velocity=(3.0, -1.0), position=(5.0, 7.0))
    assert np.ptp(motion.phi) > np.pi
    turning, still = spectrum(motion), spectrum(_run("free"))
    np.testing.assert_allclose(turning.frequencies[:3], still.frequencies[:3], rtol=1e-2)
    np.testing.assert_allclose(turning.amplitudes[:3], still.amplitudes[:3], rtol=1e-1)


def test_samples_too_far_apart_are_told() -> None:
    """10.5 Hz sampled every 0.06 s would be found at 6.1 Hz: no frequency at all is better."""
    with pytest.raises(AnalysisError, match=r"\b6\.1\d* Hz.*\b10\.5 Hz"):
        spectrum(_run("free", SMALL, 2.5, 0.06))


@pytest.mark.parametrize(("window", "bins"), [("hann", 2e-3), ("sine4", 1e-4), ("sine6", 1e-5)])
def test_lone_tone_is_found_between_bins(window: str, bins: float) -> None:
    """What is left is the leakage of its image at -f, the less the more terms a window has."""
    random, t, H = np.random.default_rng(3), 0.01 * np.arange(1000), len(WINDOWS[window])
    T = 10.0
    for _ in range(100):
        f, phase = random.uniform(2 * H / T, 50 - 2 * H / T), random.uniform(0, 2 * np.pi)
        found = find_peaks(t, 3 * np.cos(2 * np.pi * f * t + phase) + 7 - 2 * t, window=window)
        assert len(found.frequencies) == 1
        assert abs(found.frequencies[0] - f) * T < bins
        assert found.amplitudes[0] == pytest.approx(3, rel=3 * bins)
    assert found.resolution == pytest.approx(H / T)
    power = found.density.sum() * found.bins[1]
    assert power == pytest.approx(3**2 / 2, rel=1e-4)  # Parseval: the mean square of the tone


@pytest.mark.parametrize(("apart", "bins"), [(1.0, 0.2), (2.0, 1e-4)])
def test_two_close_tones(apart: float, bins: float) -> None:
    random, t = np.random.default_rng(4), 0.01 * np.arange(1000)
    for _ in range(100):
        f = random.uniform(2, 40)
        both = np.array([f, f + apart * 0.4])
        x = np.cos(2 * np.pi * np.outer(t, both) + random.uniform(0, 7, 2))
        found = find_peaks(t, x.sum(axis=1))
        assert np.abs(found.frequencies - both).max() * 10 < bins


def test_weak_tone_beside_a_strong_one_and_a_node() -> None:
    """A channel that stands still at one tone does not hide it."""
    t = 0.01 * np.arange(2000)
    strong, weak = np.cos(2 * np.pi * 3.33 * t), 1e-5 * np.sin(2 * np.pi * 7.77 * t)
    found = find_peaks(t, np.stack((strong, weak, 0 * t), axis=1))
    np.testing.assert_allclose(found.frequencies, (3.33, 7.77), rtol=1e-6)
    np.testing.assert_allclose(found.amplitudes, (1, 1e-5), rtol=1e-5)
    assert len(find_peaks(t, strong + weak, peaks=1).frequencies) == 1
    assert len(find_peaks(t, strong + weak, floor=1e-3).frequencies) == 1


def test_drift_and_noise_are_no_tones_and_what_is_needed_is_told() -> None:
    """The error names how long, and how often, a signal has to be sampled for what is asked."""
    random, t = np.random.default_rng(6), 0.01 * np.arange(2000)
    drifts = [shape(t - 5) for shape in (np.square, np.tanh, np.zeros_like, np.positive)]
    for signal in (*drifts, *random.standard_normal((20, 2000))):
        with pytest.raises(AnalysisError):
            find_peaks(t, signal)
    t, x = t[:100], np.cos(60 * t[:100])
    for lowest, needed in ((2.0, 4.0), (50.0, 0.008)):
        with pytest.raises(AnalysisError) as error:
            find_peaks(t, x, lowest=lowest)
        assert needed in numbers(error.value)
    with pytest.raises(AnalysisError, match=r"\b16\b"):
        find_peaks(t[:10], x[:10])
