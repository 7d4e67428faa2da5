"""Modes about any state, as the page draws them."""

from __future__ import annotations

from typing import Any

import pytest

import rodgen
from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen_live.run.worker_main import MOST_LINKS, WORKS
from tests.palette import ROD


def straight(**initial: Any) -> Scene:
    """The rod without thrust and gravity."""
    loads = {**ROD["loads"], "follower": {"force": 0.0}, "gravity": {"g": 0.0}}
    return Scene.from_dict({**ROD, "loads": loads, "initial": {"phi": 0.3, **initial}})


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
