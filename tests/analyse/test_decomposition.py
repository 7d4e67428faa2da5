"""Growth read off samples, against motions whose growth is known."""

from __future__ import annotations

import numpy as np
import pytest

from rodgen.analyse.growth import growth_in

T = np.linspace(0.0, 4.0, 801)
RATES = np.array([0.02 + 3j, -0.5 + 11j, -3.0 + 40j])


@pytest.mark.parametrize("fastest", [0.02, 0.0, -0.1, 0.8])
@pytest.mark.parametrize("noise", [0.0, 1e-9])
def test_of_three_motions(fastest: float, noise: float) -> None:
    """The second oscillates 30 times as fast as samples could tell, the third dies at once."""
    random = np.random.default_rng(1)
    rates = RATES.copy()
    rates[0] = fastest + 3j
    shapes = random.normal(size=(3, 5)) + 1j * random.normal(size=(3, 5))
    angles, speeds = (np.exp(np.outer(T, rates)) @ (k * shapes) for k in (1, rates[:, None]))
    found = growth_in([angles.real + noise * random.normal(size=angles.shape), speeds.real])
    # A thousandth of what is found to be growth.
    assert found == pytest.approx(np.exp(4.0 * fastest), rel=1e-5)


def test_nothing_moves() -> None:
    assert growth_in([np.zeros((10, 3)), np.zeros((10, 3))]) == 0.0
