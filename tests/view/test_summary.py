"""What a summary says of the energy of a run: numbers, in words."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import rodgen as package
from rodgen.scene import Scene
from rodgen.show.summary import summary
from tests.cli.conftest import numbers

Make = Callable[..., Scene]


def told(solution: package.Solution) -> tuple[list[float], list[float]]:
    """Numbers of the sentence on energy, and of that on its balance with work: the error [J], and
    its share of the largest energy or exchange."""
    lines = [line for line in summary(solution).splitlines() if line.startswith("Energy")]
    energy, balance = map(numbers, lines)
    return energy, balance


@pytest.mark.parametrize(
    ("terms", "omega", "energy"),
    [((), 3.0, 18.0), ((), 0.0, 0.0), (("gravity",), 0.0, 0.0)],
    ids=["spins", "rests", "falls"],
)
def test_energy_that_stays(
    make_scene: Make, terms: tuple[str, ...], omega: float, energy: float
) -> None:
    """Of a free rod of 2 m and 3 kg; at 3 rad/s it has 1/2 m (l omega/2)^2 + m l^2 omega^2/24. At
    rest there is nothing of which an error could be a share."""
    scene = make_scene(3, terms=terms, initial={"phi": 0.0, "omega": omega})
    (stays, within), (error, *share) = told(package.simulate(scene, target="numpy"))
    assert stays == energy
    assert within <= 1e-8
    assert error <= 1e-8
    assert len(share) == bool(terms or omega)
    assert all(one < 1e-9 for one in share)
    if omega:  # of the energy that there is, as none is exchanged; of two digits
        assert share[0] * energy == pytest.approx(error, rel=0.06)


def changed(make_scene: Make) -> package.Solution:
    """The first two states of a rod that spins, in each of which it is the same."""
    scene = make_scene(3, initial={"phi": 0.0, "omega": 3.0})
    solution = package.simulate(scene, target="numpy").taken(slice(2))
    solution.y[:] = solution.y[0]
    return solution


@pytest.mark.parametrize(
    ("change", "said"),
    [(1.0, 36), (1e-6, 18.000018), (1e-8, 18.0000002), (1e-12, 1.8e-11)],
)
def test_energy_that_went_elsewhere_shows_it(make_scene: Make, change: float, said: float) -> None:
    """Kinetic energy grows with the square of the rate; what is less than rounding stayed."""
    solution = changed(make_scene)
    solution.y[1, 5:] *= np.sqrt(1 + change)
    assert told(solution)[0] == [18, said]


def test_energies_that_overflow_did_not_stay(make_scene: Make) -> None:
    solution = changed(make_scene)
    solution.y[1, 5] = 1e200  # vx0
    with np.errstate(all="ignore"):
        assert "18 J to inf J" in summary(solution)
