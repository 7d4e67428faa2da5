"""Modes about any state, beside those about a steady one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen_live.run.worker_main import MOST_LINKS, WORKS, frozen_modes
from tests.palette import ROD


def straight(**initial: Any) -> Scene:
    """The rod without thrust and gravity."""
    loads = {**ROD["loads"], "follower": {"force": 0.0}, "gravity": {"g": 0.0}}
    return Scene.from_dict({**ROD, "loads": loads, "initial": {"phi": 0.3, **initial}})


def test_modes_of_a_straight_rod_are_its_natural_modes() -> None:
    """Whatever its speed is, which is left out."""
    scene = straight(velocity=[3.0, -1.0], omega="0.5*s")
    model = rodgen.build(scene, target="numpy")
    p = model.parameters(**scene.parameters)
    found = frozen_modes(model, 0.0, scene.initial_state(), p, 3)
    wanted = rodgen.natural_modes(straight(), count=3)
    # Differences of 1e-5 rad, and zeros of the rigid motions beside.
    assert found.frequencies == pytest.approx(wanted.frequencies, rel=1e-6)
    turned = np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])
    for mode, other in zip(found.displacements, wanted.displacements, strict=True):
        one, two = ((shape @ turned.T)[:, 1] for shape in (mode, other))
        assert one / one[0] == pytest.approx(two / two[0], abs=1e-6)


@pytest.mark.slow
def test_modes_for_the_page_have_names_and_displacements() -> None:
    scene = straight()
    p = rodgen.build(scene, target="numpy").parameters(**scene.parameters).tolist()
    (modes,) = WORKS["modes"](scene, t=0.0, y=scene.initial_state().tolist(), p=p)
    assert len(modes) == 4  # of five links, one motion turns all
    assert modes[0]["name"].endswith(" Hz")
    assert len(modes[0]["re"]) == len(modes[0]["im"]) == 12
    long = scene.with_links(MOST_LINKS + 1)
    with pytest.raises(InputError, match=rf"\b{MOST_LINKS}\b"):
        next(WORKS["modes"](long, t=0.0, y=long.initial_state().tolist(), p=[]))  # before p counts
