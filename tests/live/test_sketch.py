"""Pictures of scenes in the list of the live view."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import rodgen
from rodgen.live.page.sketch import HIGH, WIDE, joints_at_start, sketch
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from tests.live.conftest import ROD, SCENES

SVG = "{http://www.w3.org/2000/svg}"


def test_joints_at_the_start_are_those_of_the_module() -> None:
    scene = Scene.from_dict(ROD)
    model = rodgen.build(scene, target="numpy")
    found = model.joints(scene.initial_state(), model.parameters(**scene.parameters))
    assert joints_at_start(scene) == pytest.approx(found, abs=1e-14)  # rounding of lengths of 2 m


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_scenes_are_drawn_whole(path: Path) -> None:
    """In the picture, whatever holds the rod, and with an arrow for each force and weight."""
    scene = Scene.from_toml(path)
    root = ElementTree.fromstring(sketch(scene))
    numbers = [
        float(number)
        for shape in root.iter()
        for pair in shape.get("points", "").split()
        for number in pair.split(",")
    ]
    points = np.reshape(numbers, (-1, 2))
    assert np.all((points > -1) & (points < (WIDE + 1, HIGH + 1)))
    colours = {shape.get("fill") for shape in root.iter(f"{SVG}polygon")}
    forces = [TERMS[name] for name in scene.loads.terms if not TERMS[name].damps]
    assert colours == {term.colours[0] for term in forces}
