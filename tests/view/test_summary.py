"""What a summary says of the energy of a run."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

import rodgen as package
from rodgen.scene import Scene
from rodgen.show.summary import summary

NONE = "of the largest energy, as next to none was exchanged"


def share(words: str) -> float:
    found = re.search(r"balance to \S+ J, (\S+) of the largest", words)
    assert found
    return float(found[1])


def test_free_spinning_rod_exchanges_nothing(make_scene: Callable[..., Scene]) -> None:
    """Of kinetic energy alone: 2 m and 3 kg at 3 rad/s, 1/2 m (l omega/2)^2 + m l^2 omega^2/24."""
    scene = make_scene(3, initial={"phi": 0.0, "omega": 3.0})
    words = summary(package.simulate(scene, target="numpy"))
    assert "Energy stayed at 18 J, to within" in words
    assert NONE in words
    assert share(words) < 1e-9


def test_rod_at_rest_has_no_share(make_scene: Callable[..., Scene]) -> None:
    scene = make_scene(3, initial={"phi": 0.0, "omega": 0.0})
    words = summary(package.simulate(scene, target="numpy"))
    assert "Energy stayed at 0 J, to within 0.0e+00 J." in words
    assert "balance to 0.00e+00 J." in words


def test_falling_rod_exchanges_while_its_energy_stays(make_scene: Callable[..., Scene]) -> None:
    scene = make_scene(3, terms=("gravity",), initial={"phi": 0.0, "omega": 0.0})
    words = summary(package.simulate(scene, target="numpy"))
    assert "Energy stayed at 0 J" in words
    assert "of the largest exchange" in words
    assert share(words) < 1e-9


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (1.0, "went from 18 J to 36 J"),
        (1e-6, "went from 18 J to 18.000018 J"),
        (1e-8, "went from 18 J to 18.0000002 J"),
        (1e-12, "stayed at 18 J, to within 1.8e-11 J"),
    ],
)
def test_energy_that_went_elsewhere_shows_it(
    make_scene: Callable[..., Scene], change: float, said: str
) -> None:
    """Kinetic energy grows with the square of the rate."""
    scene = make_scene(3, initial={"phi": 0.0, "omega": 3.0})
    solution = package.simulate(scene, target="numpy").taken(slice(2))
    solution.y[:] = solution.y[0]
    solution.y[1, scene.rod.links + 2 :] *= np.sqrt(1 + change)
    assert f"Energy {said}." in summary(solution)


def test_energies_that_overflow_did_not_stay(make_scene: Callable[..., Scene]) -> None:
    scene = make_scene(3, initial={"phi": 0.0, "omega": 3.0})
    solution = package.simulate(scene, target="numpy").taken(slice(2))
    solution.y[1, scene.rod.links + 2] = 1e200  # vx0
    with np.errstate(all="ignore"):
        assert "Energy went from 18 J to inf J." in summary(solution)
